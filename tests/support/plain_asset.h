// A small groom for tests of pass lists.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>

#include "pelage/hair_asset.h"
#include "support/errors.h"

namespace pelage::test {

/// Slightly bent strands near the origin, 1 cm apart along x and 7 cm long with 8 vertices.
inline HairAsset makeAsset(uint32_t strands = 5, uint32_t vertices = 8) {
  HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  for (uint32_t s = 0; s < strands; ++s) {
    for (uint32_t v = 0; v < vertices; ++v) {
      const float t = 0.01f * static_cast<float>(v);
      asset.positions.push_back(
          {0.01f * static_cast<float>(s) + 3 * t * t, t, 0, v < 2 ? 0.0f : 1.0f});
    }
  }
  expectOk(asset.process());
  return asset;
}

/// Strands whose vertices are where a function has them; the first two of each are held.
/// \param positionAt  (strand, vertex) to a Float3
template <class Position>
HairAsset strandsAt(uint32_t strands, uint32_t vertices, const Position& positionAt) {
  HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  for (uint32_t s = 0; s < strands; ++s) {
    for (uint32_t v = 0; v < vertices; ++v) {
      const Float3 p = positionAt(s, v);
      asset.positions.push_back({p.x, p.y, p.z, v < 2 ? 0.0f : 1.0f});
    }
  }
  expectOk(asset.process());
  return asset;
}

}  // namespace pelage::test
