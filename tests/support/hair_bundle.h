// Bundles of straight strands, and how much room they take.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "pelage/hair_asset.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

struct BundleDef {
  uint32_t strands = 300;
  uint32_t vertices = 16;
  double radius = 0.03;  ///< of the disc of the roots [m]
  double length = 0.24;  ///< [m]
  bool hanging = true;   ///< along -y from a disc across y; else along x from a disc across x
};

/// Parallel strands whose roots fill a disc evenly (Vogel's spiral).
inline HairAsset bundle(const BundleDef& def = {}) {
  HairAsset asset;
  asset.strandCount = def.strands;
  asset.verticesPerStrand = def.vertices;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (uint32_t s = 0; s < def.strands; ++s) {
    const double r = def.radius * std::sqrt((s + 0.5) / def.strands);
    const double a = r * std::cos(golden * s), b = r * std::sin(golden * s);
    for (uint32_t i = 0; i < def.vertices; ++i) {
      const double along = def.length * i / (def.vertices - 1);
      const auto f = [](double v) { return static_cast<float>(v); };
      const float w = i < 2 ? 0.0f : 1.0f;
      asset.positions.push_back(def.hanging ? Float4{f(a), f(-along), f(b), w}
                                            : Float4{f(along), f(a), f(b), w});
    }
  }
  expectOk(asset.process());
  return asset;
}

/// Sum of the areas that the strands take in each of their layers of equal vertices, as the root of
/// the determinant of their covariance in the plane of two axes [m2].
inline double areaOfLayers(const std::vector<Float4>& positions, uint32_t strands,
                           uint32_t vertices, int axisA, int axisB) {
  const auto at = [](const Float4& p, int axis) {
    return static_cast<double>(axis == 0 ? p.x : axis == 1 ? p.y : p.z);
  };
  double sum = 0;
  for (uint32_t i = 2; i < vertices; ++i) {
    double a = 0, b = 0, aa = 0, ab = 0, bb = 0;
    for (uint32_t s = 0; s < strands; ++s) {
      const Float4& p = positions[size_t{s} * vertices + i];
      a += at(p, axisA) / strands;
      b += at(p, axisB) / strands;
    }
    for (uint32_t s = 0; s < strands; ++s) {
      const Float4& p = positions[size_t{s} * vertices + i];
      const double u = at(p, axisA) - a, v = at(p, axisB) - b;
      aa += u * u / strands;
      ab += u * v / strands;
      bb += v * v / strands;
    }
    sum += std::sqrt(std::max(aa * bb - ab * ab, 0.0));
  }
  return sum;
}

}  // namespace pelage::test
