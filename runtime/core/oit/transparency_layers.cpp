// Sizes of the methods that keep a fixed number of fragments a pixel.
#include <algorithm>
#include <string>

#include "oit/transparency.h"

namespace pelage::detail {

uint32_t layerCount(Transparency method) {
  switch (method) {
    case Transparency::kAlphaTest:
    case Transparency::kStochastic:
    case Transparency::kWindowed:
    case Transparency::kTiles:
      return 0;
    case Transparency::kHybrid4:
      return 4;
    case Transparency::kHybrid8:
      return 8;
    case Transparency::kHybrid16:
      return 16;
    case Transparency::kShortCut:
      return 3;
  }
  return 0;
}

LayerSizes layerSizes(uint32_t width, uint32_t height, uint32_t layers) {
  const ListSizes lists = listSizes(width, height, true);
  LayerSizes sizes;
  sizes.columns = lists.columns;
  sizes.tiles = lists.tiles;
  sizes.tileBytes = lists.tileBytes;
  const uint64_t words = uint64_t{width} * height * sizeof(uint32_t);
  // ShortCut's fourth word of depths is the transmittance of all.
  const bool hybrid = layers > 3;
  sizes.depthBytes = words * (hybrid ? layers : 4);
  sizes.colorBytes = words * layers;
  sizes.tailBytes = hybrid ? lists.tailBytes : 0;
  return sizes;
}

Result<TransparencyPlan> planLayers(uint32_t width, uint32_t height,
                                    const TransparencySettings& settings) {
  const LayerSizes sizes = layerSizes(width, height, layerCount(settings.method));
  const uint64_t largest = std::max({sizes.depthBytes, sizes.colorBytes, sizes.tailBytes});
  const auto refuse = [&](uint64_t bytes, const char* what, const char* cap, uint64_t limit) {
    return Error{ErrorCode::kInvalidArgument,
                 "transparency: " + std::to_string(layerCount(settings.method)) + " layers for " +
                     std::to_string(width) + " x " + std::to_string(height) + " pixels " + what +
                     std::to_string(bytes) + " bytes, but " + cap + " is " + std::to_string(limit) +
                     ": use a method of fewer layers"};
  };
  if (settings.maxBufferBytes < largest)
    return refuse(largest, "have a buffer of ", "maxBufferBytes", settings.maxBufferBytes);
  if (settings.maxBytes < sizes.bytes())
    return refuse(sizes.bytes(), "take ", "maxBytes", settings.maxBytes);
  TransparencyPlan plan;
  plan.bytes = sizes.bytes();
  return plan;
}

OitTileConstants tileConstants(uint32_t width, uint32_t height) {
  const ListSizes sizes = listSizes(width, height, false);
  OitTileConstants tiles = {};
  tiles.tileColumns = sizes.columns;
  tiles.targetWidth = width;
  tiles.targetHeight = height;
  return tiles;
}

BufferRange tileList(BufferId buffer, uint32_t width, uint32_t height, uint64_t tablesBefore) {
  const uint64_t bytes = listSizes(width, height, false).tiles * sizeof(uint32_t);
  return {buffer, bytes, tablesBefore * bytes};
}

}  // namespace pelage::detail
