// A groom whose rays are compared with its picture: some strands before a camera on the z axis.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pelage/headless.h"
#include "pelage/scene.h"
#include "support/plain_asset.h"

namespace pelage::test::rayScene {

using Vector = std::array<float, 3>;

inline float dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector scaled(const Vector& v, float s) { return {v[0] * s, v[1] * s, v[2] * s}; }
inline Vector sum(const Vector& a, const Vector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline constexpr uint32_t kPixels = 96;
inline constexpr float kHalf = 0.4141f, kDistance = 0.5f;  ///< of the camera: 45 degrees

inline HairAsset strands() {
  return strandsAt(9, 8, [](uint32_t s, uint32_t v) {
    const auto t = static_cast<float>(v);
    return Float3{0.036f * (static_cast<float>(s) - 4), 0.04f * t - 0.15f,
                  0.02f * std::sin(t + static_cast<float>(s))};
  });
}
inline HairDef def() {
  HairDef def;
  def.material.fiberRadius = 0.006f;
  def.material.tipRadiusRatio = 1;
  return def;
}

/// Direction of the ray through the middle of a pixel, from (0, 0, kDistance).
inline Vector rayOf(uint32_t x, uint32_t y) {
  const auto at = [](uint32_t i) {
    return (2 * (static_cast<float>(i) + 0.5f) / kPixels - 1) * kHalf;
  };
  return {at(x), -at(y), -1};
}

struct Triangles {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  Vector corner(size_t i) const {
    const float* p = &positions[size_t{indices[i]} * 3];
    return {p[0], p[1], p[2]};
  }
  /// Whether a ray from the camera hits a triangle that is larger by `slack` of its size. Moeller
  /// and Trumbore 1997, "Fast, minimum storage ray/triangle intersection".
  bool isHit(size_t triangle, const Vector& ray, float slack = 0) const {
    const Vector a = corner(3 * triangle);
    const Vector e1 = difference(corner(3 * triangle + 1), a);
    const Vector e2 = difference(corner(3 * triangle + 2), a), p = cross(ray, e2);
    const float determinant = dot(e1, p);
    if (determinant == 0) return false;
    const Vector t = difference({0, 0, kDistance}, a), q = cross(t, e1);
    const float u = dot(t, p) / determinant, v = dot(ray, q) / determinant;
    return u >= -slack && v >= -slack && u + v <= 1 + slack && dot(e2, q) / determinant > 0;
  }
};

/// [row][column] whether the pixel's ray hits a triangle.
inline std::vector<bool> trace(const Triangles& triangles) {
  std::vector<bool> hits;
  for (uint32_t y = 0; y < kPixels; ++y) {
    for (uint32_t x = 0; x < kPixels; ++x) {
      bool hit = false;
      for (size_t i = 0; i < triangles.indices.size() / 3 && !hit; ++i)
        hit = triangles.isHit(i, rayOf(x, y));
      hits.push_back(hit);
    }
  }
  return hits;
}

/// Fails unless rays hit what a picture of kPixels shows, and about as much.
inline void expectDrawn(const std::vector<bool>& hits, const RenderedImage& image) {
  size_t traced = 0, outside = 0;
  double drawn = 0;
  for (uint32_t y = 0; y < kPixels; ++y) {
    for (uint32_t x = 0; x < kPixels; ++x) {
      drawn += double{image.pixels[size_t{y} * kPixels + x].w};
      if (!hits[size_t{y} * kPixels + x]) continue;
      ++traced;
      // Edges of pictures are soft: a pixel beside one that is drawn counts, too.
      bool near = false;
      for (uint32_t v = y - (y > 0); v <= std::min(y + 1, kPixels - 1); ++v)
        for (uint32_t u = x - (x > 0); u <= std::min(x + 1, kPixels - 1); ++u)
          near = near || image.pixels[size_t{v} * kPixels + u].w > 0;
      outside += near ? 0 : 1;
    }
  }
  EXPECT_GT(traced, 1000u);
  EXPECT_EQ(outside, 0u);
  // Two quads at right angles cover between 0.71 and 1 of a fiber's width.
  EXPECT_GT(static_cast<double>(traced), 0.68 * drawn);
  EXPECT_LT(static_cast<double>(traced), 1.05 * drawn);
}

}  // namespace pelage::test::rayScene
