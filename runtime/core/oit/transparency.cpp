#include "pelage/transparency.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "oit/transparency.h"
#include "pelage/assert.h"
#include "shading/lit_kernels.h"

namespace pelage {

static_assert(kMaxListNodes == fragment_packing::kMaxNodes);

namespace {

constexpr uint32_t kNodesAPixel = 8;
constexpr uint64_t kMaxPixels = uint64_t{1} << 28;

}  // namespace

Result<TransparencyPlan> planTransparency(uint32_t width, uint32_t height,
                                          const TransparencySettings& settings,
                                          uint64_t strandVertices) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "transparency: " + what};
  };
  if (settings.method > Transparency::kTiles)
    return refuse("TransparencySettings::method is " +
                  std::to_string(static_cast<uint32_t>(settings.method)) +
                  ", which is no Transparency; take one of its values");
  const uint64_t pixels = uint64_t{width} * height;
  if (pixels == 0) return refuse("the view has no pixels");
  if (pixels > kMaxPixels)
    return refuse("a view of " + std::to_string(width) + " x " + std::to_string(height) +
                  " pixels is too large: draw it in parts");
  if (!(settings.epsilon >= 0 && settings.epsilon <= 1))
    return refuse("epsilon is " + std::to_string(settings.epsilon) + ", but must be 0 to 1");
  if (detail::layerCount(settings.method) > 0) return detail::planLayers(width, height, settings);
  if (settings.method == Transparency::kTiles)
    return detail::planStrandTiles(width, height, settings, strandVertices);
  TransparencyPlan plan;
  if (settings.method != Transparency::kWindowed) return plan;

  const detail::ListSizes sizes = detail::listSizes(width, height, settings.spillTail);
  const uint64_t fixed = sizes.bytesWithoutNodes();
  const uint64_t nodeBytes = detail::nodeBytes(settings);
  // UV of nodes come in fours.
  const uint64_t step = nodeBytes > detail::kNodeBytes ? 4 : 1;
  const uint64_t largest = std::max({sizes.headBytes, sizes.tailBytes, step * nodeBytes});
  if (settings.maxBufferBytes < largest) {
    return refuse("lists for " + std::to_string(width) + " x " + std::to_string(height) +
                  " pixels have a buffer of " + std::to_string(largest) +
                  " bytes, but maxBufferBytes is " + std::to_string(settings.maxBufferBytes) +
                  (settings.spillTail ? "; without spillTail it is a quarter" : ""));
  }
  if (settings.maxBytes < fixed + step * nodeBytes) {
    return refuse("lists for " + std::to_string(width) + " x " + std::to_string(height) +
                  " pixels take " + std::to_string(fixed) +
                  " bytes and their nodes, but maxBytes is " + std::to_string(settings.maxBytes));
  }
  uint64_t nodes = settings.nodeCount != 0 ? settings.nodeCount : pixels * kNodesAPixel;
  nodes = std::min({nodes, uint64_t{kMaxListNodes}, (settings.maxBytes - fixed) / nodeBytes,
                    settings.maxBufferBytes / nodeBytes});
  nodes = std::max(nodes / step, uint64_t{1}) * step;
  plan.nodeCount = static_cast<uint32_t>(nodes);
  plan.bytes = fixed + nodes * nodeBytes;
  return plan;
}

TransparencyCounters readTransparencyCounters(std::span<const std::byte> words,
                                              uint32_t nodeCount) {
  TransparencyCounters counters;
  PELAGE_ASSERT(words.size() >= detail::kCounterBytes, "the counters have 32 bytes");
  if (words.size() < detail::kCounterBytes) return counters;
  uint32_t values[detail::kCounterBytes / sizeof(uint32_t)];
  std::memcpy(values, words.data(), sizeof(values));
  counters.tiles = values[ppll_counters::kCounterTiles];
  counters.fragments = values[ppll_counters::kCounterNodes];
  counters.spilled = counters.fragments - std::min(counters.fragments, nodeCount);
  return counters;
}

uint32_t growNodes(const TransparencyCounters& counters, uint32_t nodeCount) {
  const uint64_t wanted = uint64_t{counters.fragments} + counters.fragments / 4;
  const bool roomy = uint64_t{counters.fragments} * 3 < nodeCount;
  if (counters.spilled == 0 && !roomy) return nodeCount;
  constexpr uint64_t kStep = 1 << 16;  // small changes ask for the same number
  const uint64_t rounded = (std::max<uint64_t>(wanted, 1) + kStep - 1) / kStep * kStep;
  return static_cast<uint32_t>(std::min<uint64_t>(rounded, kMaxListNodes));
}

namespace detail {

uint64_t nodeBytes(const TransparencySettings& settings) {
  return kNodeBytes + (readsRootUv(settings.engineLights) ? kNodeUvBytes : 0);
}

ListSizes listSizes(uint32_t width, uint32_t height, bool tail) {
  ListSizes sizes;
  sizes.columns = (width + kTileEdge - 1) / kTileEdge;
  sizes.tiles = uint64_t{sizes.columns} * ((height + kTileEdge - 1) / kTileEdge);
  sizes.headBytes = uint64_t{width} * height * sizeof(uint32_t);
  sizes.tileBytes = 2 * sizes.tiles * sizeof(uint32_t);
  sizes.tailBytes = tail ? 4 * sizes.headBytes : 0;
  return sizes;
}

}  // namespace detail
}  // namespace pelage
