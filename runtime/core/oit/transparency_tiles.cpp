// Sizes of the buffers of strands in tiles.
#include <algorithm>
#include <string>

#include "oit/transparency.h"
#include "pelage/kernels.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kFragmentBytes = 24;     // in a list, and if it is visible
constexpr uint64_t kLargestBytes = 16;      // of these, in one buffer
constexpr uint64_t kPicturePixelBytes = 8;  // colour and opacity as halves
constexpr uint64_t kFragmentsAVertex = 8;   // what a view takes at first, whichever is most
constexpr uint64_t kFragmentsAPixel = 2;
constexpr uint64_t kFragmentsAtLeast = 1 << 18;
constexpr uint64_t kMaxRounds = 16;
constexpr uint64_t kMaxVertices = uint64_t{1} << 30;

// A tile of up to a quarter of a round's fragments always has room.
constexpr uint64_t roundSpan(uint64_t capacity) { return capacity - capacity / 4; }

}  // namespace

StrandTileSizes strandTileSizes(uint32_t width, uint32_t height, uint64_t strandVertices) {
  const ListSizes lists = listSizes(width, height, false);
  StrandTileSizes sizes;
  sizes.columns = lists.columns;
  sizes.tiles = static_cast<uint32_t>(lists.tiles);
  sizes.recordBytes = std::max<uint64_t>(strandVertices, 1) * kRecordBytes;
  sizes.pixelBytes = lists.tiles * kTileEdge * kTileEdge * sizeof(uint32_t);
  sizes.tileBytes = 3 * lists.tiles * sizeof(uint32_t);
  constexpr uint64_t kBlock = kSumStrandTilesGroupSize.x;
  sizes.sumBytes = ((lists.tiles + kBlock - 1) / kBlock + 2) * sizeof(Uint2);
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
  const uint64_t largest = std::max(
      {sizes.recordBytes, sizes.pixelBytes, sizes.tileBytes, sizes.pictureBytes, kLargestBytes});
  if (settings.maxBufferBytes < largest) {
    return refuse("have a buffer of " + std::to_string(largest) + " bytes, but maxBufferBytes is " +
                  std::to_string(settings.maxBufferBytes) + ": use another method");
  }
  const uint64_t fixed = sizes.bytesWithoutFragments();
  if (settings.maxBytes < fixed + kFragmentBytes) {
    return refuse("take " + std::to_string(fixed) + " bytes and their fragments, but maxBytes is " +
                  std::to_string(settings.maxBytes));
  }
  const uint64_t atFirst =
      std::max({strandVertices * kFragmentsAVertex, uint64_t{width} * height * kFragmentsAPixel,
                kFragmentsAtLeast});
  const uint64_t wanted =
      std::min<uint64_t>(settings.nodeCount != 0 ? settings.nodeCount : atFirst, kMaxListNodes);
  const uint64_t room = std::min({wanted, (settings.maxBytes - fixed) / kFragmentBytes,
                                  settings.maxBufferBytes / kLargestBytes});
  TransparencyPlan plan;
  plan.bytes = fixed + room * kFragmentBytes;
  plan.roundCapacity = static_cast<uint32_t>(room);
  if (room < wanted) {
    const uint64_t span = std::max<uint64_t>(roundSpan(room), 1);
    plan.rounds = static_cast<uint32_t>(std::min((wanted + span - 1) / span, kMaxRounds));
  }
  plan.nodeCount = static_cast<uint32_t>(
      plan.rounds == 1 ? room : std::min(wanted, plan.rounds * roundSpan(room)));
  return plan;
}

RoundSizes roundSizes(const TransparencyPlan& plan) {
  RoundSizes sizes;
  sizes.count = plan.rounds;
  sizes.capacity = plan.roundCapacity;
  sizes.span = plan.rounds == 1 ? UINT32_MAX : static_cast<uint32_t>(roundSpan(plan.roundCapacity));
  return sizes;
}

}  // namespace pelage::detail
