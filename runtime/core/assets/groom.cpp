#include "assets/groom.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace pelage::detail {

namespace {

// Describes the error in an array of floats for each vertex; empty if there is none.
template <class T>
std::string faultOf(const HairAsset& asset, const char* name, const std::vector<T>& array) {
  const size_t vertices = size_t{asset.strandCount} * asset.verticesPerStrand;
  if (array.size() != vertices) {
    return "HairAsset::" + std::string(name) + " has " + std::to_string(array.size()) +
           " elements instead of " + std::to_string(vertices);
  }
  constexpr size_t kFloats = sizeof(T) / sizeof(float);
  const auto* values = reinterpret_cast<const float*>(array.data());
  for (size_t i = 0; i < vertices * kFloats; ++i) {
    if (std::isfinite(values[i])) continue;
    const size_t vertex = i / kFloats;
    return "HairAsset::" + std::string(name) + " of strand " +
           std::to_string(vertex / asset.verticesPerStrand) + ", vertex " +
           std::to_string(vertex % asset.verticesPerStrand) + " is not finite";
  }
  return {};
}

}  // namespace

Result<void> checkRestData(const HairAsset& asset) {
  for (const std::string& fault : {faultOf(asset, "restLengths", asset.restLengths),
                                   faultOf(asset, "restFrames", asset.restFrames),
                                   faultOf(asset, "restVectors", asset.restVectors),
                                   faultOf(asset, "tangents", asset.tangents),
                                   faultOf(asset, "inverseMasses", asset.inverseMasses),
                                   faultOf(asset, "vertexThickness", asset.vertexThickness)}) {
    if (!fault.empty())
      return Error{ErrorCode::kInvalidArgument, fault + ": call process() on the asset"};
  }
  return {};
}

void clearRestData(HairAsset& asset) {
  asset.restLengths.clear();
  asset.restFrames.clear();
  asset.restVectors.clear();
  asset.tangents.clear();
  asset.inverseMasses.clear();
  asset.vertexThickness.clear();
  asset.degenerateSegmentCount = 0;
}

std::vector<Float4> bindRootsOf(const HairAsset& asset) {
  std::vector<Float4> roots;
  roots.reserve(asset.strandCount);
  for (size_t i = 0; i < asset.strandCount; ++i)
    roots.push_back(asset.positions[i * asset.verticesPerStrand]);
  return roots;
}

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
