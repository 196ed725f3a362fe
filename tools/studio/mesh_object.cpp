#include "mesh_object.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "names.h"
#include "pelage/assert.h"
#include "sample/gpu_structs.h"
#include "sample/kernels.h"

namespace sample {

using pelage::BufferId;
using pelage::BufferUsage;

namespace {

constexpr uint32_t kRowsPerBone = 3;
constexpr size_t kMaxBones = std::size(MeshConstants{}.meshBones) / kRowsPerBone;

/// A vertex as mesh_vertex reads it.
struct MeshVertex {
  Float4 position, normal;
  pelage::Uint4 bones;
  Float4 weights;
};
static_assert(sizeof(MeshVertex) == 64);

Float4 unitVector(const Float3& v) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0) || !std::isfinite(length)) return {0, 1, 0, 0};
  return {v.x / length, v.y / length, v.z / length, 0};
}

void setBones(MeshVertex& vertex, const BoneInfluences& from) {
  float sum = 0;
  for (const float weight : from.weights) sum += weight;
  const float scale = sum > 0 ? 1 / sum : 0;
  vertex.bones = {from.bones[0], from.bones[1], from.bones[2], from.bones[3]};
  vertex.weights = {sum > 0 ? from.weights[0] * scale : 1, from.weights[1] * scale,
                    from.weights[2] * scale, from.weights[3] * scale};
}

std::vector<MeshVertex> packVertices(const CollisionMesh& mesh, const MeshDef& def) {
  std::vector<MeshVertex> vertices(mesh.positions.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Float3& p = mesh.positions[i];
    vertices[i].position = {p.x, p.y, p.z, def.scalp.empty() ? 0 : def.scalp[i]};
    vertices[i].normal = unitVector(mesh.normals[i]);
    vertices[i].normal.w = def.coat.empty() ? 0 : def.coat[i];
    setBones(vertices[i], def.influences.empty() ? BoneInfluences{} : def.influences[i]);
  }
  return vertices;
}

}  // namespace

Result<MeshObject> MeshObject::create(pelage::ResourceTable& resources, const CollisionMesh& mesh,
                                      const MeshDef& def) {
  const size_t count = mesh.positions.size();
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::kInvalidArgument, "mesh '" + def.name + "' " + what};
  };
  if (mesh.indices.size() < 3) return refuse("has no triangles");
  if (mesh.normals.size() != count || (!def.scalp.empty() && def.scalp.size() != count) ||
      (!def.coat.empty() && def.coat.size() != count) ||
      (!def.influences.empty() && def.influences.size() != count))
    return refuse("has arrays of different lengths");
  if (def.boneCount > kMaxBones) {
    return Error{ErrorCode::kInvalidArgument,
                 "mesh '" + def.name + "' has " + std::to_string(def.boneCount) +
                     " bones; meshes are drawn with at most " + std::to_string(kMaxBones)};
  }

  MeshObject object;
  object.vertexCount_ = static_cast<uint32_t>(count);
  object.indexCount_ = static_cast<uint32_t>(mesh.indices.size());
  object.bones_.resize(def.boneCount);
  const std::vector<MeshVertex> vertices = packVertices(mesh, def);
  object.vertices_ = resources.add(def.name + "/vertices", vertices, BufferUsage::kVertex);
  object.indices_ = resources.add(def.name + "/indices", mesh.indices, BufferUsage::kIndex);
  return object;
}

void MeshObject::remove(pelage::ResourceTable& resources) {
  for (BufferId* buffer : {&vertices_, &indices_}) {
    if (*buffer != BufferId::kInvalid) resources.remove(*buffer);
    *buffer = BufferId::kInvalid;
  }
}

void MeshObject::setBones(std::span<const pelage::AffineTransform> bones) {
  PELAGE_ASSERT(bones.size() == bones_.size(), "MeshObject::setBones() takes boneCount transforms");
  std::copy(bones.begin(), bones.end(), bones_.begin());
}

Result<void> MeshObject::draw(const pelage::View& view, const pelage::Light& light,
                              pelage::PassList& list, const HairShadowMaps* shadows) const {
  MeshConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.worldToClip));
  constants.eye = {view.eye.x, view.eye.y, view.eye.z, 1};
  constants.lightDirection = unitVector(light.direction);
  constants.lightColor = {light.color.x, light.color.y, light.color.z, 0};
  constants.ambientColor = {light.ambient.x, light.ambient.y, light.ambient.z, 0};
  constants.skinColor = {material.skin.x, material.skin.y, material.skin.z, 1};
  constants.scalpColor = {material.scalp.x, material.scalp.y, material.scalp.z, 1};
  constants.coatColor = {material.coat.x, material.coat.y, material.coat.z, 1};
  constants.meshBoneCount = static_cast<uint32_t>(bones_.size());
  for (size_t bone = 0; bone < bones_.size(); ++bone)
    std::copy(std::begin(bones_[bone].rows), std::end(bones_[bone].rows),
              constants.meshBones + kRowsPerBone * bone);

  pelage::DrawState state;
  state.depthCompare =
      view.reversedDepth ? pelage::DepthCompare::kGreater : pelage::DepthCompare::kLess;
  const uint64_t vertexBytes = uint64_t{vertexCount_} * sizeof(MeshVertex);
  pelage::PassBuilder builder(list);
  const pelage::KernelVariant& pixel = meshPixelVariant({.shadowed = shadows != nullptr});
  builder.draw(meshVertexVariant({}), pixel, state, indexCount_, 1, indices_)
      .vertices({vertices_, vertexBytes})
      .constants("MeshConstants", constants)
      .bytes(vertexBytes + uint64_t{indexCount_} * sizeof(uint32_t));
  if (shadows != nullptr) {
    builder.bind("g_meshShadowWords", shadows->words.buffer, shadows->words.size)
        .bind("g_meshShadowViews", shadows->views.buffer, shadows->views.size);
  }
  return builder.finish();
}

}  // namespace sample
