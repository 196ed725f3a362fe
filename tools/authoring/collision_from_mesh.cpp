#include "pelage/authoring/collision_from_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/errors.h"
#include "cut_caps.h"
#include "influence_blend.h"
#include "mesh_simplify.h"
#include "mesh_weld.h"
#include "points.h"

namespace pelage {
namespace {

using detail::toFloat3;
using detail::Vector;
using detail::vectorOf;
using detail::WeldBy;
using tools::invalid;

// Names in a message about a name that is not there.
constexpr size_t kPiecesListed = 20;

// Triangles of the mesh that become one collision mesh.
struct Piece {
  std::string name;
  std::vector<uint32_t> triangles;
};

class Cutter {
 public:
  Cutter(const SkinnedMesh& mesh, const CollisionMeshDef& def)
      : mesh_(mesh),
        def_(def),
        slots_(detail::weldVertices(mesh, WeldBy::kPosition)),
        merged_(def.errorBound > 0 ? slots_
                                   : detail::weldVertices(mesh, WeldBy::kPositionAndBones)),
        whole_(positionsOf(mesh.indices)),
        normals_(mesh.positions.size()),
        numbers_(mesh.positions.size(), kNone),
        cornerAt_(mesh.positions.size(), kNone),
        boneNumbers_(mesh.bones.size(), kNone) {
    boneNames_.resize(mesh.bones.size());
    for (const BoneName& bone : mesh.bones) boneNames_[bone.index] = bone.name;
    for (size_t v = 0; v < merged_.size(); ++v) normals_[merged_[v]] += vectorOf(mesh.normals[v]);
    std::vector<uint32_t> counts(merged_.size());
    for (const uint32_t v : merged_) ++counts[v];
    for (size_t v = 0; v < merged_.size(); ++v)
      if (counts[v] > 1) normals_[v] = detail::unitOrZero(normals_[v]);
  }

  Result<std::vector<NamedCollisionMesh>> cut() {
    auto pieces = piecesOf();
    if (!pieces) return pieces.error();
    std::vector<NamedCollisionMesh> result;
    for (const Piece& piece : *pieces) {
      auto mesh = make(piece);
      if (!mesh) return mesh.error();
      result.push_back(std::move(*mesh));
    }
    return result;
  }

 private:
  std::vector<uint32_t> positionsOf(std::span<const uint32_t> indices) const {
    std::vector<uint32_t> result;
    result.reserve(indices.size());
    for (const uint32_t v : indices) result.push_back(slots_[v]);
    return result;
  }

  // [triangle] the bone with the largest sum of weights.
  uint32_t boneOf(uint32_t triangle) const {
    std::array<detail::WeightedInfluences, 3> corners;
    for (size_t k = 0; k < 3; ++k)
      corners[k] = {&mesh_.influences[mesh_.indices[size_t{triangle} * 3 + k]], 1};
    return detail::blendInfluences(corners, 1).bones[0];
  }

  // All pieces, those without triangles too; for kWhole the objects.
  std::vector<Piece> allPieces() const {
    std::vector<Piece> pieces;
    if (def_.by == CollisionSplit::kBone) {
      for (const std::string& name : boneNames_) pieces.push_back({name, {}});
      for (uint32_t t = 0; t < mesh_.triangleCount(); ++t) pieces[boneOf(t)].triangles.push_back(t);
      return pieces;
    }
    for (const SkinnedMeshPart& part : mesh_.parts) {
      const std::string& name = def_.by == CollisionSplit::kMaterial ? part.material : part.name;
      auto piece = std::find_if(pieces.begin(), pieces.end(),
                                [&](const Piece& p) { return p.name == name; });
      if (piece == pieces.end()) piece = pieces.insert(pieces.end(), {name, {}});
      for (uint32_t i = 0; i < part.triangleCount; ++i)
        piece->triangles.push_back(part.firstTriangle + i);
    }
    return pieces;
  }

  Result<std::vector<Piece>> piecesOf() const {
    std::vector<Piece> pieces = allPieces();
    std::erase_if(pieces, [](const Piece& piece) { return piece.triangles.empty(); });
    for (const std::string& name : def_.only)
      if (std::none_of(pieces.begin(), pieces.end(),
                       [&](const Piece& piece) { return piece.name == name; })) {
        std::string names;
        for (size_t i = 0; i < std::min(pieces.size(), kPiecesListed); ++i)
          names += fmt::format("{}'{}'", i == 0 ? "" : ", ", pieces[i].name);
        return invalid(fmt::format("nothing of the mesh is named '{}'; there are {}{}", name, names,
                                   pieces.size() > kPiecesListed ? ", ..." : ""));
      }
    if (!def_.only.empty())
      std::erase_if(pieces, [&](const Piece& piece) {
        return std::find(def_.only.begin(), def_.only.end(), piece.name) == def_.only.end();
      });
    if (def_.by != CollisionSplit::kWhole) return pieces;
    Piece whole = {pieces.front().name, {}};
    for (const Piece& piece : pieces)
      whole.triangles.insert(whole.triangles.end(), piece.triangles.begin(), piece.triangles.end());
    std::sort(whole.triangles.begin(), whole.triangles.end());
    return std::vector<Piece>{std::move(whole)};
  }

  Result<NamedCollisionMesh> make(const Piece& piece) {
    NamedCollisionMesh result;
    result.name = piece.name;
    CollisionMesh& mesh = result.mesh;
    std::vector<uint32_t> source;  // vertices of the skinned mesh
    for (const uint32_t t : piece.triangles)
      for (size_t k = 0; k < 3; ++k) source.push_back(mesh_.indices[size_t{t} * 3 + k]);
    for (const uint32_t v : source) {
      mesh.indices.push_back(numberOf(v, mesh));
      if (uint32_t& corner = cornerAt_[slots_[v]]; corner == kNone) corner = mesh.indices.back();
    }
    std::vector<std::vector<uint32_t>> rims;
    if (def_.capHoles) rims = detail::cutRims(positionsOf(source), whole_);
    const size_t sourceCount = mesh.indices.size();
    if (def_.errorBound > 0) {
      auto simplified =
          detail::simplifyMesh(mesh.positions, mesh.indices, def_.errorBound, !rims.empty());
      mesh.indices = std::move(simplified.indices);
      // Up, so that the bound stays one in float.
      if (simplified.error > 0)
        result.error = std::nextafter(static_cast<float>(simplified.error), kMaxCoordinate);
    }
    const size_t simplifiedCount = mesh.indices.size();
    for (const std::vector<uint32_t>& rim : rims) addCap(rim, mesh);
    result.capCount = static_cast<uint32_t>(rims.size());
    result.sourceTriangleCount =
        static_cast<uint32_t>((sourceCount + mesh.indices.size() - simplifiedCount) / 3);
    keepUsed(mesh);
    // As they were: there may be many small pieces of a large mesh.
    for (const uint32_t v : source) numbers_[merged_[v]] = cornerAt_[slots_[v]] = kNone;
    auto report = inspectMesh(mesh);
    if (!report) return report.error();
    result.report = *report;
    return result;
  }

  uint32_t numberOf(uint32_t vertex, CollisionMesh& mesh) {
    const uint32_t first = merged_[vertex];
    if (numbers_[first] == kNone) {
      numbers_[first] = static_cast<uint32_t>(mesh.positions.size());
      mesh.positions.push_back(mesh_.positions[first]);
      mesh.normals.push_back(toFloat3(normals_[first]));
      mesh.influences.push_back(mesh_.influences[first]);
    }
    return numbers_[first];
  }

  // A triangle, or a fan around the middle of the rim.
  void addCap(const std::vector<uint32_t>& rim, CollisionMesh& mesh) {
    std::vector<uint32_t> corners;
    for (const uint32_t point : rim) corners.push_back(cornerAt_[point]);
    if (corners.size() == 3) {
      mesh.indices.insert(mesh.indices.end(), corners.begin(), corners.end());
      return;
    }
    const auto middle = static_cast<uint32_t>(mesh.positions.size());
    Vector sum, normal;
    std::vector<detail::WeightedInfluences> influences;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vector at = vectorOf(mesh.positions[corners[i]]);
      sum += at;
      normal += cross(at, vectorOf(mesh.positions[corners[(i + 1) % corners.size()]]));
      influences.push_back({&mesh.influences[corners[i]], 1});
    }
    const BoneInfluences blended = detail::blendInfluences(influences, 4);
    mesh.positions.push_back(toFloat3(sum * (1.0 / static_cast<double>(corners.size()))));
    mesh.normals.push_back(toFloat3(detail::unitOrZero(normal)));
    mesh.influences.push_back(blended);
    for (size_t i = 0; i < corners.size(); ++i)
      mesh.indices.insert(mesh.indices.end(),
                          {middle, corners[i], corners[(i + 1) % corners.size()]});
  }

  // Leaves out the vertices and bones that no triangle needs.
  void keepUsed(CollisionMesh& mesh) {
    std::vector<uint32_t> vertices(mesh.positions.size(), kNone);
    std::vector<uint32_t> kept;
    for (uint32_t& index : mesh.indices) {
      if (vertices[index] == kNone) {
        vertices[index] = static_cast<uint32_t>(kept.size());
        kept.push_back(index);
      }
      index = vertices[index];
    }
    CollisionMesh out;
    std::vector<uint32_t> bones;
    for (const uint32_t v : kept)
      for (const uint32_t bone : mesh.influences[v].bones) {
        if (boneNumbers_[bone] == kNone) bones.push_back(bone);
        boneNumbers_[bone] = 0;
      }
    std::sort(bones.begin(), bones.end());
    for (const uint32_t bone : bones) {
      boneNumbers_[bone] = static_cast<uint32_t>(out.bones.size());
      out.bones.push_back({boneNumbers_[bone], boneNames_[bone]});
    }
    for (const uint32_t v : kept) {
      out.positions.push_back(mesh.positions[v]);
      out.normals.push_back(mesh.normals[v]);
      out.influences.push_back(mesh.influences[v]);
      for (uint32_t& bone : out.influences.back().bones) bone = boneNumbers_[bone];
    }
    for (const uint32_t bone : bones) boneNumbers_[bone] = kNone;
    out.indices = std::move(mesh.indices);
    mesh = std::move(out);
  }

  static constexpr uint32_t kNone = 0xffffffffu;

  const SkinnedMesh& mesh_;
  const CollisionMeshDef& def_;
  std::vector<uint32_t> slots_;   // [vertex] the first one at its place
  std::vector<uint32_t> merged_;  // [vertex] the one that it becomes
  detail::EdgeBalance whole_;     // between places
  std::vector<Vector> normals_;   // [vertex] of those that stay
  std::vector<std::string> boneNames_;
  // Reset for each piece; kNone: not in the piece.
  std::vector<uint32_t> numbers_;      // [vertex] in the collision mesh
  std::vector<uint32_t> cornerAt_;     // [place] a vertex of the collision mesh
  std::vector<uint32_t> boneNumbers_;  // [bone] in the collision mesh
};

}  // namespace

Result<std::vector<NamedCollisionMesh>> collisionMeshes(const SkinnedMesh& mesh,
                                                        const CollisionMeshDef& def) {
  return tools::guarded([&]() -> Result<std::vector<NamedCollisionMesh>> {
    if (!(def.errorBound >= 0) || !std::isfinite(def.errorBound))
      return invalid(fmt::format("errorBound is {}; it must be 0 or more", def.errorBound));
    if (auto r = validate(mesh); !r) return r.error();
    return Cutter(mesh, def).cut();
  });
}

}  // namespace pelage
