#include "scene_setup.h"

#include <algorithm>
#include <cmath>

#include "float3_math.h"
#include "names.h"
#include "pelage/skeleton.h"

namespace sample {

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

namespace {

// A direction in the view of a camera that looks horizontally.
Float3 fromCamera(const Float3& camera, float right, float up, float back) {
  const float length = std::hypot(camera.x, camera.z);
  const Float3 to = length > 0 ? Float3{camera.x / length, 0, camera.z / length} : Float3{0, 0, 1};
  return {back * to.x + right * to.z, up, back * to.z - right * to.x};
}

}  // namespace

pelage::Light studioLight(const Float3& camera) {
  pelage::Light light;
  light.direction = fromCamera(camera, -0.55f, 0.70f, 0.62f);
  light.color = {1.32f, 1.24f, 1.12f};
  light.ambient = {0.19f, 0.22f, 0.27f};
  // Bands of order 1 are radiance over 0.488603.
  const Float3 fill = fromCamera(camera, 0.5f, 0, 0.4f);
  light.environment.l1m1 = {0.20f, 0.23f, 0.28f};
  light.environment.l10 = {0.16f * fill.z, 0.17f * fill.z, 0.19f * fill.z};
  light.environment.l11 = {0.16f * fill.x, 0.17f * fill.x, 0.19f * fill.x};
  return light;
}

std::vector<pelage::Light> studioLights(const Float3& camera) {
  pelage::Light rim;
  rim.direction = fromCamera(camera, 0.45f, 0.62f, -0.75f);
  rim.color = {0.24f, 0.26f, 0.30f};
  rim.ambient = {};
  rim.shadow = pelage::HairShadow::kDeep;
  rim.shadowSize = 512;
  return {studioLight(camera), rim};
}

pelage::View lightView(std::span<const Float3> points, const Float3& toLight, uint32_t size) {
  const Float3 light = unit(toLight);
  const Float3 right =
      unit(cross(std::abs(light.y) < 0.9f ? Float3{0, 1, 0} : Float3{1, 0, 0}, light));
  const Float3 up = cross(light, right);
  Float3 low = points[0], high = points[0];
  for (const Float3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Float3 middle = {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
  float radius = 0;
  for (const Float3& p : points)
    radius = std::max(radius, std::hypot(p.x - middle.x, p.y - middle.y, p.z - middle.z));

  // From 4 radii in front of the middle to one behind it.
  constexpr float kFront = 4, kRange = kFront + 1;
  const auto row = [&](const Float3& along, float scale, float offset) -> Float4 {
    return {along.x * scale, along.y * scale, along.z * scale, offset - dot(along, middle) * scale};
  };
  pelage::View view;
  view.width = view.height = size;
  view.eye = {middle.x + kFront * radius * light.x, middle.y + kFront * radius * light.y,
              middle.z + kFront * radius * light.z};
  view.worldToClip.rows[0] = row(right, 1 / radius, 0);
  view.worldToClip.rows[1] = row(up, 1 / radius, 0);
  view.worldToClip.rows[2] = row(light, -1 / (kRange * radius), kFront / kRange);
  view.worldToClip.rows[3] = {0, 0, 0, 1};
  return view;
}

}  // namespace sample
