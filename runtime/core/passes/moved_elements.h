// How a rigid motion of an object changes the data that rooms have of it on the GPU.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "pelage/constants.h"
#include "pelage/pass_list.h"

namespace pelage::detail {

/// Elements of a buffer of Float4. They are in blocks of one kind; the kinds repeat.
struct MovedElements {
  /// \param kindsOfBlocks  move_rigidly::kMoves... of each block of a period
  MovedElements(BufferId ofBuffer, uint64_t firstElement, uint64_t elements, uint64_t blockElements,
                std::initializer_list<uint32_t> kindsOfBlocks, bool inTheWorld = false)
      : buffer(ofBuffer),
        first(firstElement),
        count(elements),
        block(blockElements),
        period(static_cast<uint32_t>(kindsOfBlocks.size())),
        inWorld(inTheWorld) {
    uint32_t shift = 0;
    for (const uint32_t kind : kindsOfBlocks) {
      kinds |= kind << shift;
      shift += move_rigidly::kMovedKindBits;
    }
  }

  BufferId buffer;
  uint64_t first, count, block;
  uint32_t period;
  uint32_t kinds = 0;
  bool inWorld;  ///< in world space; else relative to the object's origin
};

}  // namespace pelage::detail
