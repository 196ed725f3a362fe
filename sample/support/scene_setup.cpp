#include "scene_setup.h"

#include <algorithm>
#include <cmath>

#include "pelage/skeleton.h"

namespace sample {

using pelage::AffineTransform;
using pelage::BoneInfluences;
using pelage::Float3;
using pelage::Float4;
using pelage::HairAsset;

Float3 blendedPoint(const std::vector<AffineTransform>& bones, const BoneInfluences& influences,
                    const Float3& point) {
  Float3 sum;
  float weights = 0;
  for (int i = 0; i < 4; ++i) {
    const float weight = influences.weights[i];
    if (!(weight > 0)) continue;
    const Float3 moved = pelage::transformPoint(bones[influences.bones[i]], point);
    sum = {sum.x + weight * moved.x, sum.y + weight * moved.y, sum.z + weight * moved.z};
    weights += weight;
  }
  if (!(weights > 0)) return pelage::transformPoint(bones[0], point);
  return {sum.x / weights, sum.y / weights, sum.z / weights};
}

namespace {

constexpr uint32_t kSweptStrands = 500;       // strands that the camera looks at, at most
constexpr uint32_t kSweptMeshVertices = 600;  // the same for the mesh

}  // namespace

void sweepHair(const HairAsset& hair, std::span<const BoneInfluences> influences,
               const std::vector<AffineTransform>& bones, std::vector<Float3>& points) {
  const uint32_t stride = std::max(1u, hair.strandCount / kSweptStrands);
  for (uint32_t strand = 0; strand < hair.strandCount; strand += stride) {
    const BoneInfluences root = influences.empty() ? BoneInfluences{} : influences[strand];
    for (const uint32_t vertex : {0u, hair.verticesPerStrand / 2, hair.verticesPerStrand - 1}) {
      const Float4& p = hair.positions[size_t{strand} * hair.verticesPerStrand + vertex];
      points.push_back(blendedPoint(bones, root, {p.x, p.y, p.z}));
    }
  }
}

void sweepMesh(const pelage::CollisionMesh& mesh, const std::vector<AffineTransform>& bones,
               std::vector<Float3>& points) {
  const size_t stride = std::max<size_t>(1, mesh.positions.size() / kSweptMeshVertices);
  for (size_t i = 0; i < mesh.positions.size(); i += stride)
    points.push_back(blendedPoint(bones, mesh.influences[i], mesh.positions[i]));
}

pelage::Light studioLight(const Float3& camera) {
  const float length = std::hypot(camera.x, camera.z);
  const Float3 back =
      length > 0 ? Float3{camera.x / length, 0, camera.z / length} : Float3{0, 0, 1};
  constexpr float kLeft = 0.55f, kUp = 0.70f, kBack = 0.62f;
  pelage::Light light;
  light.direction = {kBack * back.x - kLeft * back.z, kUp, kBack * back.z + kLeft * back.x};
  light.color = {1.32f, 1.24f, 1.12f};
  light.ambient = {0.19f, 0.22f, 0.27f};
  return light;
}

}  // namespace sample
