// Sizes of the buffers of strands in tiles.
#include <algorithm>
#include <string>

#include "oit/transparency.h"
#include "pelage/kernels.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kReferenceBytes = 4;     // of a segment in a tile
constexpr uint64_t kPicturePixelBytes = 8;  // colour and opacity as halves
constexpr uint64_t kReferencesAVertex = 6;  // what a view takes at first
constexpr uint64_t kReferencesAtLeast = 4096;
constexpr uint64_t kMaxVertices = uint64_t{1} << 30;

}  // namespace

StrandTileSizes strandTileSizes(uint32_t width, uint32_t height, uint64_t strandVertices) {
  const ListSizes lists = listSizes(width, height, false);
  StrandTileSizes sizes;
  sizes.columns = lists.columns;
  sizes.tiles = static_cast<uint32_t>(lists.tiles);
  sizes.recordBytes = std::max<uint64_t>(strandVertices, 1) * kRecordBytes;
  sizes.tileBytes = 3 * lists.tiles * sizeof(uint32_t);
  constexpr uint64_t kBlock = kSumStrandTilesGroupSize.x;
  sizes.sumBytes = (lists.tiles + kBlock - 1) / kBlock * sizeof(Uint2);
  sizes.pictureBytes = uint64_t{width} * height * kPicturePixelBytes;
  return sizes;
}

Result<TransparencyPlan> planStrandTiles(uint32_t width, uint32_t height,
                                         const TransparencySettings& settings,
                                         uint64_t strandVertices) {
  const StrandTileSizes sizes = strandTileSizes(width, height, strandVertices);
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument,
                 "transparency: tiles of " + std::to_string(strandVertices) + " vertices in " +
                     std::to_string(width) + " x " + std::to_string(height) + " pixels " + what};
  };
  if (strandVertices > kMaxVertices) return refuse("are too many: draw fewer strands");
  const uint64_t largest = std::max({sizes.recordBytes, sizes.tileBytes, sizes.pictureBytes});
  if (settings.maxBufferBytes < largest) {
    return refuse("have a buffer of " + std::to_string(largest) + " bytes, but maxBufferBytes is " +
                  std::to_string(settings.maxBufferBytes) + ": use another method");
  }
  const uint64_t fixed = sizes.bytesWithoutReferences();
  if (settings.maxBytes < fixed + kReferenceBytes) {
    return refuse("take " + std::to_string(fixed) +
                  " bytes and their references, but maxBytes is " +
                  std::to_string(settings.maxBytes));
  }
  uint64_t references = settings.nodeCount != 0
                            ? settings.nodeCount
                            : std::max(strandVertices * kReferencesAVertex, kReferencesAtLeast);
  references =
      std::min({references, uint64_t{kMaxListNodes}, (settings.maxBytes - fixed) / kReferenceBytes,
                settings.maxBufferBytes / kReferenceBytes});
  TransparencyPlan plan;
  plan.nodeCount = static_cast<uint32_t>(references);
  plan.bytes = fixed + references * kReferenceBytes;
  return plan;
}

}  // namespace pelage::detail
