// Guides that are where data says, and no solver: HairObject::setPositions().
#pragma once

#include <cstdint>

#include "pelage/result.h"
#include "pelage/types.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The positions of one object on the GPU. A copy of it is what a frame is taken back to.
class GivenPositions {
 public:
  /// Makes the buffer, or removes it where nothing is given; hair that was given before starts
  /// anew then.
  void prepare(HairFrame& frame);
  /// Adds the pass that writes positions and tangents of the guides, and sends what has changed.
  Result<void> record(const HairFrame& frame);
  /// Nothing is known of the buffer's contents.
  void forget() { version_ = 0; }
  void remove(const BufferFactory& factory) {
    factory.remove(buffer_);
    forget();
  }

 private:
  BufferId buffer_ = BufferId::kInvalid;
  uint64_t version_ = 0;  ///< of what the buffer holds; 0: of nothing
};

}  // namespace pelage::detail
