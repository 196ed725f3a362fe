// Sizes of what transparency keeps a pixel, as in kernels/layouts/ppll_build.hlsli.
#pragma once

#include <cstdint>

#include "pelage/gpu_structs.h"
#include "pelage/transparency.h"

namespace pelage::detail {

inline constexpr uint32_t kTileEdge = 8;       ///< [pixels]
inline constexpr uint64_t kNodeBytes = 16;     ///< of a list's node
inline constexpr uint64_t kCounterBytes = 32;  ///< of the counters

struct ListSizes {
  uint32_t columns = 0;  ///< of tiles
  uint64_t tiles = 0;
  uint64_t headBytes = 0, tileBytes = 0, tailBytes = 0;
  uint64_t bytesWithoutNodes() const { return headBytes + tileBytes + tailBytes + kCounterBytes; }
};

ListSizes listSizes(uint32_t width, uint32_t height, bool tail);

/// Fragments that a pixel keeps, of methods with a fixed number of them; else 0.
uint32_t layerCount(Transparency method);

/// What they keep a pixel, as in kernels/layouts/hybrid_depths.hlsli, hybrid_colors.hlsli and
/// short_cut_depths_alpha.hlsli.
struct LayerSizes {
  uint32_t columns = 0;  ///< of tiles
  uint64_t tiles = 0;
  uint64_t depthBytes = 0, colorBytes = 0, tailBytes = 0, tileBytes = 0;
  uint64_t bytes() const { return depthBytes + colorBytes + tailBytes + tileBytes + kCounterBytes; }
};

LayerSizes layerSizes(uint32_t width, uint32_t height, uint32_t layers);
Result<TransparencyPlan> planLayers(uint32_t width, uint32_t height,
                                    const TransparencySettings& settings);

/// What tiles of strands take, as in kernels/layouts/strand_tiles.hlsli.
struct StrandTileSizes {
  uint32_t columns = 0;  ///< of tiles
  uint32_t tiles = 0;
  uint64_t recordBytes = 0, tileBytes = 0, sumBytes = 0, pictureBytes = 0;
  uint64_t bytesWithoutReferences() const {
    return recordBytes + tileBytes + sumBytes + pictureBytes + kCounterBytes;
  }
};

StrandTileSizes strandTileSizes(uint32_t width, uint32_t height, uint64_t strandVertices);
Result<TransparencyPlan> planStrandTiles(uint32_t width, uint32_t height,
                                         const TransparencySettings& settings,
                                         uint64_t strandVertices);

/// Where the list of tiles begins behind their flags, and how to draw them.
OitTileConstants tileConstants(uint32_t width, uint32_t height);

}  // namespace pelage::detail
