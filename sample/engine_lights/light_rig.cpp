#include "light_rig.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "pelage/view.h"

namespace engine_lights {

using pelage::Float3;
using pelage::Float4;
using pelage::Matrix4;
using pelage::Result;
using pelage::TextureId;

namespace {

constexpr Float3 kCenter = {0, 0.08f, 0};  // of the cascades [m]
constexpr float kCascadeRadii[] = {0.2f, 0.4f, 0.8f};
constexpr float kDepthRange = 2;  // of each cascade [m]
constexpr uint32_t kCascadeSize = 256, kSpotSize = 256, kCubeSize = 8;
constexpr float kBias = 0.006f;  // [m]; hair begins at the skin
constexpr Float3 kSpotPosition = {0.55f, 0.45f, 0.55f}, kSpotTarget = {0, 0.16f, 0};
constexpr float kSpotAngle = 0.9f;  // of the whole cone [radians]
constexpr float kSpotNear = 0.1f, kSpotFar = 2;

Float3 minus(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Float3 cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Float3 unit(Float3 v) {
  const float scale = 1 / std::sqrt(dot(v, v));
  return {v.x * scale, v.y * scale, v.z * scale};
}

// A row that gives `scale` x the distance from the center along an axis, plus an offset.
Float4 rowOf(Float3 axis, float scale, float offset) {
  return {scale * axis.x, scale * axis.y, scale * axis.z, offset - scale * dot(axis, kCenter)};
}

// Parallel light: clip space of a cascade.
Matrix4 cascadeMatrix(float radius) {
  const Float3 toSun = sunDirection();
  const Float3 right = unit(cross({0, 1, 0}, toSun));
  const Float3 up = cross(toSun, right);
  Matrix4 result;
  result.rows[0] = rowOf(right, 1 / radius, 0);
  result.rows[1] = rowOf(up, 1 / radius, 0);
  result.rows[2] = rowOf(toSun, -1 / kDepthRange, 0.5f);
  return result;
}

// The direction of a texel of a cube, as every API has it.
Float3 cubeDirection(uint32_t face, float u, float v) {
  switch (face) {
    case 0:
      return {1, -v, -u};
    case 1:
      return {-1, -v, u};
    case 2:
      return {u, 1, v};
    case 3:
      return {u, -1, -v};
    case 4:
      return {u, -v, 1};
    default:
      return {-u, -v, -1};
  }
}

// Light of a blue sky, brown ground and a warm wall at the character's right.
Float3 irradianceOf(Float3 normal) {
  const float up = 0.5f + 0.5f * normal.y;
  const float wall = std::max(-normal.x, 0.0f);
  return {0.09f + 0.13f * up + 0.16f * wall, 0.08f + 0.19f * up + 0.09f * wall,
          0.06f + 0.30f * up + 0.04f * wall};
}

Result<TextureId> createIrradiance(pelage::HeadlessDevice& device) {
  std::vector<float> texels;
  for (uint32_t face = 0; face < 6; ++face) {
    for (uint32_t i = 0; i < kCubeSize * kCubeSize; ++i) {
      const auto coordinate = [](uint32_t texel) {
        return 2 * (static_cast<float>(texel) + 0.5f) / kCubeSize - 1;
      };
      const Float3 light = irradianceOf(
          unit(cubeDirection(face, coordinate(i % kCubeSize), coordinate(i / kCubeSize))));
      texels.insert(texels.end(), {light.x, light.y, light.z, 1});
    }
  }
  return device.createTexture({.shape = pelage::TextureShape::kCube,
                               .width = kCubeSize,
                               .height = kCubeSize,
                               .layers = 6,
                               .texels = texels});
}

Result<TextureId> createDepths(pelage::HeadlessDevice& device, const std::vector<float>& depths,
                               uint32_t size, uint32_t layers) {
  return device.createTexture(
      {.width = size, .height = size, .layers = layers, .channels = 1, .texels = depths});
}

EngineRig constantsOf(const Matrix4& spot) {
  EngineRig rig = {};
  const Float3 sun = sunDirection();
  rig.rigSun = {sun.x, sun.y, sun.z, 0};
  rig.rigSunColor = {1.35f, 1.22f, 1.02f, 0};
  for (size_t i = 0; i < std::size(kCascadeRadii); ++i) {
    const Matrix4 clip = cascadeMatrix(kCascadeRadii[i]);
    // From clip space to the map, whose first row is the upper one.
    const auto half = [](const Float4& row, float sign) {
      return Float4{sign * 0.5f * row.x, sign * 0.5f * row.y, sign * 0.5f * row.z,
                    sign * 0.5f * row.w + 0.5f};
    };
    rig.rigCascades[3 * i] = half(clip.rows[0], 1);
    rig.rigCascades[3 * i + 1] = half(clip.rows[1], -1);
    rig.rigCascades[3 * i + 2] = clip.rows[2];
  }
  std::copy(std::begin(spot.rows), std::end(spot.rows), std::begin(rig.rigSpot));
  const Float3 axis = unit(minus(kSpotTarget, kSpotPosition));
  rig.rigSpotPosition = {kSpotPosition.x, kSpotPosition.y, kSpotPosition.z,
                         std::cos(0.5f * kSpotAngle)};
  rig.rigSpotAxis = {axis.x, axis.y, axis.z, std::cos(0.25f * kSpotAngle)};
  rig.rigSpotColor = {0.30f, 0.20f, 0.42f, 0};
  rig.rigSky = {1, 0, 0, 0};
  // The spot's depths are not linear: the bias is that at the distance of its target.
  const Float3 offset = minus(kSpotTarget, kSpotPosition);
  const float spotBias =
      kBias * kSpotNear * kSpotFar / ((kSpotFar - kSpotNear) * dot(offset, offset));
  rig.rigMaps = {kCascadeSize, kSpotSize, kBias / kDepthRange, spotBias};
  return rig;
}

}  // namespace

Float3 sunDirection() { return unit({-0.62f, 0.62f, 0.48f}); }

Result<LightRig> LightRig::create(pelage::HeadlessDevice& device, const OpaqueGeometry& opaque) {
  LightRig rig;
  std::vector<float> cascades;
  for (const float radius : kCascadeRadii) {
    const std::vector<float> map = drawDepthMap(opaque, cascadeMatrix(radius), kCascadeSize);
    cascades.insert(cascades.end(), map.begin(), map.end());
  }
  const Matrix4 spot = pelage::lookAt(kSpotPosition, kSpotTarget, {0, 1, 0}, 1.1f * kSpotAngle, 1,
                                      kSpotNear, kSpotFar);
  const auto layers = static_cast<uint32_t>(std::size(kCascadeRadii));
  const std::vector<float> empty(cascades.size(), 1.0f);
  for (const auto& [id, made] :
       {std::pair(&rig.cascades, createDepths(device, cascades, kCascadeSize, layers)),
        std::pair(&rig.open, createDepths(device, empty, kCascadeSize, layers)),
        std::pair(&rig.spot,
                  createDepths(device, drawDepthMap(opaque, spot, kSpotSize), kSpotSize, 1)),
        std::pair(&rig.irradiance, createIrradiance(device))}) {
    if (!made) return made.error();
    *id = *made;
  }
  rig.constants = constantsOf(spot);
  return rig;
}

std::vector<pelage::NamedResource> LightRig::resources(const LightsOn& on) const {
  EngineRig block = constants;
  const auto scale = [](Float4& color, float factor) {
    color = {factor * color.x, factor * color.y, factor * color.z, 0};
  };
  scale(block.rigSunColor, on.sun);
  scale(block.rigSpotColor, on.spot);
  scale(block.rigSky, on.sky);
  return {pelage::NamedResource::constants("EngineRig", block),
          {.name = "g_rigCascadeMaps", .texture = on.cascades ? cascades : open},
          {.name = "g_rigSpotMap", .texture = spot},
          {.name = "g_rigIrradiance", .texture = irradiance},
          {.name = "g_rigIrradianceSampler", .texture = irradiance}};
}

}  // namespace engine_lights
