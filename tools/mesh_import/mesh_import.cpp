#include "pelage/mesh_import.h"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/errors.h"
#include "mesh_weld.h"
#include "pelage/authoring/skinned_mesh.h"

namespace pelage {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double kMaxCoordinate = 1e6;
// Relative difference below which two matrices are one, exported in float.
constexpr double kSameMatrix = 1e-4;

Matrix4d toEigen(const aiMatrix4x4& m) {
  Matrix4d result;
  result << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return result;
}

Vector3d toEigen(const aiVector3D& v) { return {v.x, v.y, v.z}; }

std::string_view viewOf(const aiString& text) { return {text.C_Str(), text.length}; }

Float3 toFloat3(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// A node that has meshes, with its map to the scene.
struct NodeAt {
  const aiNode* node;
  Matrix4d toScene;
};

// A bone's share of one vertex.
struct Share {
  uint32_t bone;
  double weight;
};

class MeshReader {
 public:
  MeshReader(const aiScene& scene, std::string name) : scene_(scene), name_(std::move(name)) {}

  Result<SkinnedMesh> read() {
    distributeNodes();
    for (const NodeAt& placed : nodes_)
      for (uint32_t i = 0; i < placed.node->mNumMeshes; ++i)
        if (auto r = addMesh(*scene_.mMeshes[placed.node->mMeshes[i]], placed); !r)
          return r.error();
    if (out_.indices.empty())
      return Error{ErrorCode::kInvalidFile, name_ + ": the file has no triangles"};
    return std::move(out_);
  }

 private:
  // Without recursion: a file can nest its nodes as deeply as it likes.
  void distributeNodes() {
    std::vector<NodeAt> stack = {{scene_.mRootNode, toEigen(scene_.mRootNode->mTransformation)}};
    while (!stack.empty()) {
      const NodeAt placed = stack.back();
      stack.pop_back();
      // The first one of a name, as an engine finds it.
      transforms_.emplace(std::string(viewOf(placed.node->mName)), placed.toScene);
      nodes_.push_back(placed);
      for (uint32_t i = placed.node->mNumChildren; i-- > 0;) {
        const aiNode* child = placed.node->mChildren[i];
        stack.push_back({child, placed.toScene * toEigen(child->mTransformation)});
      }
    }
  }

  Error fail(const aiMesh& mesh, std::string_view what) const {
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: mesh '{}': {}", name_, viewOf(mesh.mName), what)};
  }

  uint32_t boneIndex(std::string_view name) {
    std::string key(name.empty() ? std::string_view("root") : name);
    const auto next = static_cast<uint32_t>(out_.bones.size());
    const auto [entry, added] = bones_.emplace(key, next);
    if (added) out_.bones.push_back({next, std::move(key)});
    return entry->second;
  }

  // Maps from the mesh to the scene [bone of the mesh]; the last one is for vertices without a
  // bone. In the bind pose all maps are equal but for rounding, which would tear vertices of
  // different bones apart: then all are the same.
  std::vector<Matrix4d> mapsOf(const aiMesh& mesh, const NodeAt& placed) const {
    std::vector<Matrix4d> maps;
    for (uint32_t i = 0; i < mesh.mNumBones; ++i) {
      const aiBone& bone = *mesh.mBones[i];
      const auto found = transforms_.find(std::string(viewOf(bone.mName)));
      maps.push_back(found != transforms_.end() ? found->second * toEigen(bone.mOffsetMatrix)
                                                : placed.toScene);
    }
    if (maps.empty()) return {placed.toScene};
    const double tolerance = kSameMatrix * maps.front().norm();
    if (std::all_of(maps.begin(), maps.end(),
                    [&](const Matrix4d& m) { return (m - maps.front()).norm() <= tolerance; }))
      return std::vector<Matrix4d>(mesh.mNumBones + 1, maps.front());
    maps.push_back(placed.toScene);
    return maps;
  }

  // [vertex] shares by bone of the mesh, the strongest four first.
  static std::vector<std::vector<Share>> sharesOf(const aiMesh& mesh) {
    std::vector<std::vector<Share>> shares(mesh.mNumVertices);
    for (uint32_t b = 0; b < mesh.mNumBones; ++b)
      for (uint32_t i = 0; i < mesh.mBones[b]->mNumWeights; ++i) {
        const aiVertexWeight& weight = mesh.mBones[b]->mWeights[i];
        if (weight.mVertexId >= mesh.mNumVertices || !(weight.mWeight > 0) || weight.mWeight > 1e6f)
          continue;
        std::vector<Share>& list = shares[weight.mVertexId];
        if (!list.empty() && list.back().bone == b)
          list.back().weight += weight.mWeight;
        else
          list.push_back({b, weight.mWeight});
      }
    for (std::vector<Share>& list : shares) {
      std::stable_sort(list.begin(), list.end(),
                       [](const Share& a, const Share& b) { return a.weight > b.weight; });
      if (list.size() > 4) list.resize(4);
      double sum = 0;
      for (const Share& share : list) sum += share.weight;
      for (Share& share : list) share.weight /= sum;
    }
    return shares;
  }

  Result<void> addMesh(const aiMesh& mesh, const NodeAt& placed) {
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) return {};
    if (out_.positions.size() + mesh.mNumVertices > std::numeric_limits<uint32_t>::max() ||
        out_.indices.size() / 3 + mesh.mNumFaces > std::numeric_limits<uint32_t>::max() / 3)
      return fail(mesh, "more than 2^32 vertices or corners in the file; split it");
    const std::vector<Matrix4d> maps = mapsOf(mesh, placed);
    const std::vector<std::vector<Share>> shares = sharesOf(mesh);
    std::vector<uint32_t> boneNumbers;  // [bone of the mesh]
    for (uint32_t i = 0; i < mesh.mNumBones; ++i)
      boneNumbers.push_back(boneIndex(viewOf(mesh.mBones[i]->mName)));

    SkinnedMeshPart part;
    part.mesh = viewOf(mesh.mName);
    part.name = placed.node->mName.length > 0 ? viewOf(placed.node->mName) : viewOf(mesh.mName);
    part.material = materialOf(mesh);
    part.firstVertex = static_cast<uint32_t>(out_.positions.size());
    part.vertexCount = mesh.mNumVertices;
    part.firstTriangle = out_.triangleCount();
    for (uint32_t v = 0; v < mesh.mNumVertices; ++v) {
      Matrix4d map = Matrix4d::Zero();
      BoneInfluences influences;
      if (shares[v].empty()) {
        map = maps.back();
        influences.bones[0] = boneIndex(viewOf(placed.node->mName));
        std::fill(std::begin(influences.bones) + 1, std::end(influences.bones),
                  influences.bones[0]);
        influences.weights[0] = 1;
        if (mesh.mNumBones > 0) ++out_.repairedVertexCount;
      } else {
        for (size_t k = 0; k < 4; ++k) {
          const bool there = k < shares[v].size();
          const Share& share = shares[v][there ? k : 0];
          influences.bones[k] = boneNumbers[share.bone];
          influences.weights[k] = there ? static_cast<float>(share.weight) : 0;
          if (there) map += share.weight * maps[share.bone];
        }
        // Shares of one map are that map, whatever rounding their sum has.
        if (maps.front() == maps.back()) map = maps.front();
      }
      const Vector3d position =
          map.topLeftCorner<3, 3>() * toEigen(mesh.mVertices[v]) + map.col(3).head<3>();
      if (!(position.cwiseAbs().maxCoeff() <= kMaxCoordinate) || !position.allFinite())
        return fail(mesh, fmt::format("vertex {} is at {} {} {}; coordinates must be within +-1e6",
                                      v, position.x(), position.y(), position.z()));
      out_.positions.push_back(toFloat3(position));
      out_.normals.push_back(normalOf(mesh, v, map));
      out_.influences.push_back(influences);
    }
    if (auto r = addTriangles(mesh, part.firstVertex, maps); !r) return r;
    part.triangleCount = out_.triangleCount() - part.firstTriangle;
    out_.parts.push_back(std::move(part));
    return {};
  }

  std::string materialOf(const aiMesh& mesh) const {
    aiString name;
    if (mesh.mMaterialIndex < scene_.mNumMaterials)
      scene_.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, name);
    return std::string(viewOf(name));
  }

  static Float3 normalOf(const aiMesh& mesh, uint32_t vertex, const Matrix4d& map) {
    if (!mesh.HasNormals()) return {};
    // The cofactors transform normals also where the matrix has no inverse.
    const Eigen::Matrix3d m = map.topLeftCorner<3, 3>();
    Eigen::Matrix3d cofactors;
    for (Eigen::Index i = 0; i < 3; ++i)
      cofactors.col(i) = m.col((i + 1) % 3).cross(m.col((i + 2) % 3));
    const Vector3d normal = cofactors * toEigen(mesh.mNormals[vertex]);
    const double length = normal.norm();
    return length > 0 && std::isfinite(length) ? toFloat3(normal / length) : Float3{};
  }

  Result<void> addTriangles(const aiMesh& mesh, uint32_t firstVertex,
                            const std::vector<Matrix4d>& maps) {
    // A mirror turns the triangles inside out.
    const bool mirrored = maps.front().topLeftCorner<3, 3>().determinant() < 0;
    for (uint32_t f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t index = face.mIndices[mirrored ? 2 - k : k];
        if (index >= mesh.mNumVertices)
          return fail(mesh, fmt::format("triangle {} refers to vertex {} of {}", f, index,
                                        mesh.mNumVertices));
        out_.indices.push_back(firstVertex + index);
      }
    }
    return {};
  }

  const aiScene& scene_;
  std::string name_;
  std::vector<NodeAt> nodes_;
  std::map<std::string, Matrix4d> transforms_;
  std::map<std::string, uint32_t> bones_;
  SkinnedMesh out_;
};

Result<SkinnedMesh> importFile(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status))
    return Error{ErrorCode::kFileNotFound, name + ": there is no such file"};

  Assimp::Importer importer;
  // Else an FBX node comes as a chain of nodes with names that no engine has.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* scene = importer.ReadFile(name, aiProcess_Triangulate);
  if (scene == nullptr) {
    const std::string reason = importer.GetErrorString();
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: cannot be read: {}", name,
                             reason.empty() ? "assimp gives no reason" : reason)};
  }
  if (scene->mRootNode == nullptr)
    return Error{ErrorCode::kInvalidFile, name + ": the file has no nodes"};
  return MeshReader(*scene, name).read();
}

// The four places of a vertex in a file need not be in order, nor their weights sum to 1.
BoneInfluences normalized(const BoneInfluences& influences) {
  std::vector<Share> shares;
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) {
    sum += influences.weights[k];
    if (influences.weights[k] > 0) shares.push_back({influences.bones[k], influences.weights[k]});
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.weight > b.weight; });
  BoneInfluences result;
  std::fill(std::begin(result.bones), std::end(result.bones), shares.front().bone);
  for (size_t k = 0; k < shares.size(); ++k) {
    result.bones[k] = shares[k].bone;
    result.weights[k] = static_cast<float>(shares[k].weight / sum);
  }
  return result;
}

bool isTfxMesh(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension == ".tfxmesh";
}

Result<SkinnedMesh> loadSkinned(const std::filesystem::path& path) {
  if (!isTfxMesh(path)) return importFile(path);
  auto mesh = loadTfxMesh(path);
  if (!mesh) return mesh.error();
  SkinnedMesh out;
  SkinnedMeshPart part;
  part.name = path.stem().string();
  part.vertexCount = static_cast<uint32_t>(mesh->positions.size());
  part.triangleCount = static_cast<uint32_t>(mesh->indices.size() / 3);
  out.parts.push_back(std::move(part));
  out.bones = std::move(mesh->bones);
  out.positions = std::move(mesh->positions);
  out.normals = std::move(mesh->normals);
  out.indices = std::move(mesh->indices);
  for (const BoneInfluences& influences : mesh->influences)
    out.influences.push_back(normalized(influences));
  out.repairedVertexCount = mesh->repairedVertexCount;
  return out;
}

Result<CollisionMesh> load(const std::filesystem::path& path) {
  if (isTfxMesh(path)) return loadTfxMesh(path);
  auto mesh = importFile(path);
  if (!mesh) return mesh.error();
  const std::vector<uint32_t> first =
      detail::weldVertices(*mesh, detail::WeldBy::kPositionNormalAndBones);
  CollisionMesh out;
  std::vector<uint32_t> numbers(first.size());  // [vertex] that of the welded one
  for (uint32_t v = 0; v < first.size(); ++v) {
    numbers[v] = first[v] == v ? static_cast<uint32_t>(out.positions.size()) : numbers[first[v]];
    if (first[v] != v) continue;
    out.positions.push_back(mesh->positions[v]);
    out.normals.push_back(mesh->normals[v]);
    out.influences.push_back(mesh->influences[v]);
  }
  for (const uint32_t index : mesh->indices) out.indices.push_back(numbers[index]);
  out.bones = std::move(mesh->bones);
  // Several of them may have become one.
  out.repairedVertexCount =
      static_cast<uint32_t>(std::min<size_t>(mesh->repairedVertexCount, out.positions.size()));
  return out;
}

}  // namespace

Result<CollisionMesh> loadMesh(const std::filesystem::path& path) {
  return tools::guarded([&] { return load(path); });
}

Result<SkinnedMesh> loadSkinnedMesh(const std::filesystem::path& path) {
  return tools::guarded([&] { return loadSkinned(path); });
}

}  // namespace pelage
