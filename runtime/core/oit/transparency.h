// Sizes of the buffers of the transparency methods.
#pragma once

#include <cstdint>

#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/transparency.h"

namespace pelage::detail {

inline constexpr uint32_t kTileEdge = pixel_tiles::kTileEdge;  ///< [pixels]
/// Bytes of a list's node, of its UV for lights that read it, and of the counters.
inline constexpr uint64_t kNodeBytes = fragment_packing::kNodeWords * sizeof(uint32_t);
inline constexpr uint64_t kNodeUvBytes = sizeof(uint32_t);
inline constexpr uint64_t kCounterBytes = ppll_counters::kCounterWords * sizeof(uint32_t);

struct ListSizes {
  uint32_t columns = 0;  ///< of tiles
  uint64_t tiles = 0;
  uint64_t headBytes = 0, tileBytes = 0, tailBytes = 0;
  uint64_t bytesWithoutNodes() const { return headBytes + tileBytes + tailBytes + kCounterBytes; }
};

/// Size of a node, by TransparencySettings::engineLights.
uint64_t nodeBytes(const TransparencySettings& settings);
ListSizes listSizes(uint32_t width, uint32_t height, bool tail);

/// Fragments that a pixel keeps, of methods with a fixed number of them; else 0.
uint32_t layerCount(Transparency method);

/// Sizes of the buffers of methods with a fixed number of layers.
struct LayerSizes {
  uint32_t columns = 0;  ///< of tiles
  uint64_t tiles = 0;
  uint64_t depthBytes = 0, colorBytes = 0, tailBytes = 0, tileBytes = 0;
  uint64_t bytes() const { return depthBytes + colorBytes + tailBytes + tileBytes + kCounterBytes; }
};

LayerSizes layerSizes(uint32_t width, uint32_t height, uint32_t layers);
Result<TransparencyPlan> planLayers(uint32_t width, uint32_t height,
                                    const TransparencySettings& settings);

/// Sizes of the buffers of strands in tiles.
struct StrandTileSizes {
  uint32_t columns = 0;  ///< of tiles
  uint32_t tiles = 0;
  uint64_t recordBytes = 0, pixelBytes = 0, tileBytes = 0, sumBytes = 0, pictureBytes = 0;
  uint64_t bytesWithoutFragments() const {
    return recordBytes + pixelBytes + tileBytes + sumBytes + pictureBytes + kCounterBytes;
  }
};

/// How rounds over tiles share the fragments of a view.
struct RoundSizes {
  uint32_t count = 1;
  uint32_t capacity = 0;  ///< fragments that a round has room for
  /// A round takes the tiles whose first fragment is in a range of so many. The rest of the
  /// capacity is for the last of them.
  uint32_t span = 0;
};
RoundSizes roundSizes(const TransparencyPlan& plan);

StrandTileSizes strandTileSizes(uint32_t width, uint32_t height, uint64_t strandVertices);
Result<TransparencyPlan> planStrandTiles(uint32_t width, uint32_t height,
                                         const TransparencySettings& settings,
                                         uint64_t strandVertices);

/// How tiles are drawn.
OitTileConstants tileConstants(uint32_t width, uint32_t height);
/// The list of tiles that are drawn: the vertex inputs of oit_tile_vertex. \param tablesBefore
/// tables with a word a tile that come before it in the buffer.
BufferRange tileList(BufferId buffer, uint32_t width, uint32_t height, uint64_t tablesBefore = 1);

}  // namespace pelage::detail
