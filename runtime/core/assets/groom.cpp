#include "assets/groom.h"

#include <algorithm>

namespace pelage::detail {

float longestStrand(const HairAsset& asset) {
  float longest = 0;
  const size_t stride = asset.verticesPerStrand;
  for (size_t s = 0; s < asset.strandCount; ++s) {
    float length = 0;
    for (size_t i = 0; i < stride; ++i) length += asset.restLengths[s * stride + i];
    longest = std::max(longest, length);
  }
  return longest;
}

uint32_t vertexCountOf(const HairAsset& asset, uint32_t strand) {
  return asset.vertexCounts.empty() ? asset.verticesPerStrand : asset.vertexCounts[strand];
}

bool hasHeldVertices(const HairAsset& asset) {
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const size_t first = size_t{s} * asset.verticesPerStrand;
    for (uint32_t i = 2; i < vertexCountOf(asset, s); ++i)
      if (asset.inverseMasses[first + i] <= 0) return true;
  }
  return false;
}

}  // namespace pelage::detail
