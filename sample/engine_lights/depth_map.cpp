#include "depth_map.h"

#include <algorithm>
#include <cmath>

namespace engine_lights {

using pelage::Float3;
using pelage::Float4;

namespace {

// A corner in the map: x and y [texels], depth; w <= 0: behind the eye.
Float4 cornerOf(const Float3& p, const pelage::Matrix4& worldToClip, float size) {
  const auto row = [&](int i) {
    const Float4& r = worldToClip.rows[i];
    return r.x * p.x + r.y * p.y + r.z * p.z + r.w;
  };
  const float w = row(3);
  return {(0.5f + 0.5f * row(0) / w) * size, (0.5f - 0.5f * row(1) / w) * size, row(2) / w, w};
}

// Twice the area of the triangle of a, b and a point.
float areaOf(const Float4& a, const Float4& b, float x, float y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

void drawTriangle(const Float4 (&c)[3], uint32_t size, std::vector<float>& map) {
  const float area = areaOf(c[0], c[1], c[2].x, c[2].y);
  if (!(std::abs(area) > 1e-9f)) return;
  const auto bound = [&](float value) {
    return static_cast<uint32_t>(std::clamp(value, 0.0f, static_cast<float>(size)));
  };
  const uint32_t left = bound(std::min({c[0].x, c[1].x, c[2].x}) - 0.5f);
  const uint32_t right = bound(std::max({c[0].x, c[1].x, c[2].x}) + 1.0f);
  const uint32_t top = bound(std::min({c[0].y, c[1].y, c[2].y}) - 0.5f);
  const uint32_t bottom = bound(std::max({c[0].y, c[1].y, c[2].y}) + 1.0f);
  for (uint32_t row = top; row < bottom; ++row) {
    for (uint32_t column = left; column < right; ++column) {
      const float x = static_cast<float>(column) + 0.5f, y = static_cast<float>(row) + 0.5f;
      const float a = areaOf(c[1], c[2], x, y) / area, b = areaOf(c[2], c[0], x, y) / area;
      if (a < 0 || b < 0 || a + b > 1) continue;
      const float depth = a * c[0].z + b * c[1].z + (1 - a - b) * c[2].z;
      float& nearest = map[size_t{row} * size + column];
      if (depth >= 0) nearest = std::min(nearest, depth);
    }
  }
}

}  // namespace

std::vector<float> drawDepthMap(const OpaqueGeometry& geometry, const pelage::Matrix4& worldToClip,
                                uint32_t size) {
  std::vector<float> map(size_t{size} * size, 1.0f);
  for (size_t i = 0; i + 2 < geometry.indices.size(); i += 3) {
    Float4 corners[3];
    for (size_t k = 0; k < 3; ++k) {
      corners[k] = cornerOf(geometry.positions[geometry.indices[i + k]], worldToClip,
                            static_cast<float>(size));
    }
    if (corners[0].w > 0 && corners[1].w > 0 && corners[2].w > 0) drawTriangle(corners, size, map);
  }
  return map;
}

}  // namespace engine_lights
