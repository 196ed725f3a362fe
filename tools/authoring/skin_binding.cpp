#include "pelage/authoring/skin_binding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/errors.h"
#include "influence_blend.h"
#include "points.h"
#include "triangle_tree.h"

namespace pelage {
namespace {

using detail::SurfacePoint;
using detail::toFloat3;
using detail::TriangleTree;
using detail::Vector;
using detail::vectorOf;
using tools::invalid;

Result<void> checkRoots(std::span<const Float3> roots, const BindDef& def) {
  if (!(def.maxDistance >= 0) || !std::isfinite(def.maxDistance))
    return invalid(fmt::format("maxDistance is {}; it must be 0 or more", def.maxDistance));
  if (def.maxBones < 1 || def.maxBones > 4)
    return invalid(fmt::format("maxBones is {}; it must be 1 to 4", def.maxBones));
  if (roots.empty()) return invalid("there are no roots to bind");
  if (roots.size() > std::numeric_limits<uint32_t>::max())
    return invalid(fmt::format("{} roots; the maximum is 2^32-1", roots.size()));
  for (size_t i = 0; i < roots.size(); ++i)
    if (const Float3& p = roots[i]; !detail::isCoordinate(p))
      return invalid(fmt::format("the root of strand {} is at {} {} {}; it must be within +-1e6", i,
                                 p.x, p.y, p.z));
  return {};
}

// The frame of SurfaceRoot::offset.
struct TriangleFrame {
  Vector x, y, z;  // unit vectors

  Vector offset(const Vector& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
};

// Nothing for a triangle that .tfxskin refuses: one that is not finite, or without area.
std::optional<TriangleFrame> frameOf(const Vector& a, const Vector& b, const Vector& c) {
  constexpr double kNoArea = 1e-9;  // twice the area over the square of the longest edge
  const Vector u = b - a, v = c - a, w = c - b, normal = cross(u, v);
  const double area = length(normal);
  if (!std::isfinite(area) || !(area > kNoArea * std::max({dot(u, u), dot(v, v), dot(w, w)})))
    return std::nullopt;
  const Vector x = u * (1 / length(u)), z = normal * (1 / area);
  return TriangleFrame{x, cross(z, x), z};
}

class Binder {
 public:
  Binder(const SkinnedMesh& mesh, const BindDef& def) : mesh_(mesh), def_(def) {}

  Result<SkinBinding> bind(std::span<const Float3> roots) {
    std::vector<uint32_t> used;
    for (uint32_t t = 0; t < mesh_.triangleCount(); ++t) {
      const auto corner = [&](size_t k) {
        return vectorOf(mesh_.positions[mesh_.indices[size_t{t} * 3 + k]]);
      };
      if (frameOf(corner(0), corner(1), corner(2))) used.push_back(t);
    }
    if (used.empty()) return invalid("mesh: none of its triangles has an area");
    out_.report.degenerateTriangles = mesh_.triangleCount() - static_cast<uint32_t>(used.size());
    const TriangleTree tree(mesh_.positions, mesh_.indices, used);
    uint32_t hint = used.front();
    double sum = 0;
    for (uint32_t i = 0; i < roots.size(); ++i) {
      const Vector root = vectorOf(roots[i]);
      const SurfacePoint point = tree.closest(root, hint);
      hint = point.triangle;
      out_.weights.strands.push_back(weightsAt(point));
      out_.table.roots.push_back(positionAt(point, root));
      const double distance = std::sqrt(point.squaredDistance);
      sum += distance;
      const auto rounded = static_cast<float>(distance);
      out_.report.maxDistance = std::max(out_.report.maxDistance, rounded);
      if (rounded > def_.maxDistance) out_.report.farStrands.push_back({i, rounded});
    }
    out_.report.meanDistance = static_cast<float>(sum / static_cast<double>(roots.size()));
    for (const SkinnedMeshPart& part : mesh_.parts)
      out_.table.parts.push_back(
          {part.name, part.mesh, part.material, part.vertexCount, part.triangleCount});
    dropUnusedBones();
    return std::move(out_);
  }

 private:
  BoneInfluences weightsAt(const SurfacePoint& point) {
    std::array<detail::WeightedInfluences, 3> corners;
    for (size_t k = 0; k < 3; ++k)
      corners[k] = {&mesh_.influences[mesh_.indices[size_t{point.triangle} * 3 + k]],
                    point.barycentric[k]};
    double lost = 0;
    const BoneInfluences result = detail::blendInfluences(corners, def_.maxBones, &lost);
    out_.report.maxLostWeight = std::max(out_.report.maxLostWeight, static_cast<float>(lost));
    return result;
  }

  SurfaceRoot positionAt(const SurfacePoint& point, const Vector& root) const {
    const auto after = std::upper_bound(
        mesh_.parts.begin(), mesh_.parts.end(), point.triangle,
        [](uint32_t t, const SkinnedMeshPart& part) { return t < part.firstTriangle; });
    // The last part that starts there; others that start there have no triangles.
    const auto part = after - 1;
    SurfaceRoot result;
    result.part = static_cast<uint32_t>(part - mesh_.parts.begin());
    result.triangle = point.triangle - part->firstTriangle;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t vertex = mesh_.indices[size_t{point.triangle} * 3 + k];
      result.corners[k] = vertex - part->firstVertex;
      result.bind[k] = mesh_.positions[vertex];
    }
    result.barycentric = {static_cast<float>(point.barycentric[0]),
                          static_cast<float>(point.barycentric[1]),
                          static_cast<float>(point.barycentric[2])};
    // From where the rounded weights are, so that the sum is the root.
    const Vector a = vectorOf(result.bind[0]);
    const Vector surface = a + (vectorOf(result.bind[1]) - a) * result.barycentric.y +
                           (vectorOf(result.bind[2]) - a) * result.barycentric.z;
    const auto frame = frameOf(a, vectorOf(result.bind[1]), vectorOf(result.bind[2]));
    result.offset = toFloat3(frame->offset(root - surface));
    return result;
  }

  void dropUnusedBones() {
    std::vector<bool> used(mesh_.bones.size());
    for (const BoneInfluences& strand : out_.weights.strands)
      for (const uint32_t bone : strand.bones) used[bone] = true;
    std::vector<uint32_t> numbers(mesh_.bones.size());  // [bone of the mesh]
    std::vector<const BoneName*> byIndex(mesh_.bones.size());
    for (const BoneName& bone : mesh_.bones) byIndex[bone.index] = &bone;
    for (size_t i = 0; i < used.size(); ++i) {
      if (!used[i]) continue;
      numbers[i] = static_cast<uint32_t>(out_.weights.bones.size());
      out_.weights.bones.push_back({numbers[i], byIndex[i]->name});
    }
    for (BoneInfluences& strand : out_.weights.strands)
      for (uint32_t& bone : strand.bones) bone = numbers[bone];
  }

  const SkinnedMesh& mesh_;
  const BindDef& def_;
  SkinBinding out_;
};

// Weights of one strand by bone name, their sum 1.
Result<std::map<std::string_view, double>> byName(const BoneWeights& weights,
                                                  const std::vector<std::string_view>& names,
                                                  size_t strand) {
  const BoneInfluences& influences = weights.strands[strand];
  std::map<std::string_view, double> result;
  double sum = 0;
  for (const float weight : influences.weights) sum += weight;
  if (!(sum > 0) || !std::isfinite(sum))
    return invalid(fmt::format("strand {} has no bone weights", strand));
  for (size_t k = 0; k < 4; ++k) {
    if (influences.bones[k] >= names.size())
      return invalid(fmt::format("strand {} follows bone {} of {}", strand, influences.bones[k],
                                 names.size()));
    result[names[influences.bones[k]]] += influences.weights[k] / sum;
  }
  return result;
}

std::vector<std::string_view> namesOf(const BoneWeights& weights) {
  std::vector<std::string_view> names(weights.bones.size());
  for (const BoneName& bone : weights.bones)
    if (bone.index < names.size()) names[bone.index] = bone.name;
  return names;
}

Result<WeightComparison> compare(const BoneWeights& a, const BoneWeights& b) {
  if (a.strands.size() != b.strands.size() || a.strands.empty())
    return invalid(fmt::format("weights of {} strands cannot be compared with those of {}",
                               a.strands.size(), b.strands.size()));
  const std::vector<std::string_view> namesA = namesOf(a), namesB = namesOf(b);
  WeightComparison result;
  double sum = 0;
  size_t above = 0;
  for (size_t i = 0; i < a.strands.size(); ++i) {
    auto of = byName(a, namesA, i);
    if (!of) return of.error();
    auto other = byName(b, namesB, i);
    if (!other) return other.error();
    for (const auto& [name, weight] : *other) (*of)[name] -= weight;
    double difference = 0;
    for (const auto& [name, weight] : *of) difference += std::abs(weight);
    result.difference.push_back(static_cast<float>(difference));
    result.max = std::max(result.max, result.difference.back());
    sum += difference;
    if (difference > 0.1) ++above;
  }
  const auto count = static_cast<double>(a.strands.size());
  result.mean = static_cast<float>(sum / count);
  result.shareAboveTenth = static_cast<float>(static_cast<double>(above) / count);
  return result;
}

}  // namespace

Result<SkinBinding> bindRoots(std::span<const Float3> roots, const SkinnedMesh& mesh,
                              const BindDef& def) {
  return tools::guarded([&]() -> Result<SkinBinding> {
    if (auto r = checkRoots(roots, def); !r) return r.error();
    if (auto r = validate(mesh); !r) return r.error();
    return Binder(mesh, def).bind(roots);
  });
}

std::vector<Float3> rootsOf(const HairAsset& asset) {
  std::vector<Float3> roots;
  if (asset.positions.size() != size_t{asset.strandCount} * asset.verticesPerStrand) return roots;
  for (size_t i = 0; i < asset.positions.size(); i += asset.verticesPerStrand)
    roots.push_back({asset.positions[i].x, asset.positions[i].y, asset.positions[i].z});
  return roots;
}

Result<WeightComparison> compareWeights(const BoneWeights& a, const BoneWeights& b) {
  return tools::guarded([&] { return compare(a, b); });
}

}  // namespace pelage
