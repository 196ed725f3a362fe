// Where the strands of an object were in the last frame, for motion vectors.
#pragma once

#include <cstdint>
#include <string>

#include "passes/buffer_factory.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/types.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The positions of an object in a frame, as StrandMotion takes them.
struct MotionHair {
  const std::string& name;
  BufferId positions = BufferId::kInvalid;
  uint64_t elements = 0;  ///< Float4 that are stored
  uint64_t movedFrom =
      ~uint64_t{0};  ///< elements from here on are still where they were before a shift
  Float3 move = {};  ///< of these [m]
  float tipSeparation = 1;
};

/// Adds the pass that copies the positions to a buffer of as many elements.
Result<void> addKeepPass(const MotionHair& hair, BufferId to, PassList& list);

/// Strands of the frame before, for draws. Without positions nothing has moved in the world.
struct StrandsBefore {
  BufferId positions = BufferId::kInvalid;
  float tipSeparation = 1;
};

/// The state of one object; a plain value. There is a buffer only while motion is wanted.
class StrandMotion {
 public:
  /// Makes the buffer, or removes it.
  void prepare(HairFrame& frame);
  /// Adds the pass that keeps the positions. Call it before the simulation moves them; in a frame
  /// that is a reset behind it, so that nothing has moved.
  Result<void> keep(const MotionHair& hair, PassList& list) const;
  /// Notes what was kept. \param frame HairStore::frame
  void finish(const MotionHair& hair, bool reset, uint64_t frame);
  /// Strands before the motion of this frame: only if it has simulated.
  StrandsBefore before(uint64_t frame) const;
  void remove(const BufferFactory& factory) { factory.remove(positions_); }

 private:
  BufferId positions_ = BufferId::kInvalid;
  uint64_t frame_ = 0;       ///< that kept them; 0: none
  float tipSeparation_ = 1;  ///< of the frame before
  float nextTipSeparation_ = 1;
};

}  // namespace pelage::detail
