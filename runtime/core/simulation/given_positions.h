// Guides that are where data says, and no solver: HairObject::setPositions().
#pragma once

#include <cstdint>

#include "base/bounds.h"
#include "pelage/host_allocator.h"
#include "pelage/result.h"
#include "pelage/types.h"
#include "simulation/hair_frame.h"

namespace pelage::detail {

/// What the application has set.
struct GivenShape {
  HostArray<Float4> positions;  ///< [guide][vertex] in world space; empty: the solver's
  uint64_t version = 0;         ///< of the positions
  Ball ball;                    ///< around them
  bool isOn() const { return !positions.empty(); }
};

/// The positions of one object on the GPU. A copy of it is what a frame is taken back to.
class GivenPositions {
 public:
  /// Makes the buffer, or removes it where nothing is given.
  /// \return whether the frame before was given, and this one is not: the hair starts anew.
  bool prepare(const HairFrame& frame, const GivenShape& shape);
  /// Adds the pass that writes positions and tangents of the guides, and sends what has changed.
  Result<void> place(const HairFrame& frame, const GivenShape& shape);
  /// Whether the last pass had these positions.
  bool has(const GivenShape& shape) const { return version_ == shape.version; }
  /// Nothing is known of the buffer's contents.
  void forget() { version_ = 0; }
  void remove(const RoomBuffers& room) {
    room.remove(buffer_);
    forget();
  }

 private:
  BufferId buffer_ = BufferId::kInvalid;
  uint64_t version_ = 0;  ///< of what the buffer holds; 0: of nothing
};

}  // namespace pelage::detail
