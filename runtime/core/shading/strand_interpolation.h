// Strands between the last two states of the simulation, for engines that simulate in fixed steps.
#pragma once

#include <cstdint>

#include "base/bounds.h"
#include "base/rigid_move.h"
#include "passes/buffer_factory.h"
#include "pelage/binding.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "shading/strand_motion.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The input of interpolation for one object.
struct InterpolatedHair {
  const MotionHair& positions;  ///< of the last state
  uint32_t vertices = 0;        ///< of a strand
  uint32_t guides = 0;
  BufferRange roots = {};  ///< [2][guide] RootTransform, of the last state and the one before
};

/// Interpolated strands, which draws read in place of the last state.
struct StrandsBetween {
  BufferId positions = BufferId::kInvalid;  ///< kInvalid: nothing was interpolated
  BufferId tangents = BufferId::kInvalid;
  BufferId roots = BufferId::kInvalid;  ///< kInvalid where nothing reads them
};

/// The state of one object; a plain value. There are buffers only while interpolation is wanted.
class StrandInterpolation {
 public:
  /// Makes the buffers, or removes them.
  void prepare(HairFrame& frame);
  bool isOn() const { return before_ != BufferId::kInvalid; }
  void remove(const BufferFactory& factory);

  /// Adds the pass that keeps the state before a simulation; behind one that resets the hair.
  Result<void> keep(const MotionHair& hair, PassList& list) const;
  /// Notes that it was kept. \param ball  around the hair behind the simulation
  void finishState(bool reset, const Ball& ball);

  /// Adds the passes that place the strands. \param share 0..1, \param known false: the state
  /// before means nothing, and the last one is drawn. \param restarts nothing was drawn before
  Result<void> record(const InterpolatedHair& hair, float share, bool known, bool restarts,
                      PassList& list) const;
  /// Notes that they were placed. \param frame HairStore::frame
  void finish(uint64_t frame) {
    frame_ = frame;
    drawn_ = true;
  }
  /// The strands that draws of a frame read.
  StrandsBetween drawn(uint64_t frame) const {
    if (frame_ != frame || frame_ == 0) return {};
    return {positions_, tangents_, roots_};
  }
  /// The last drawn strands mean nothing for motion: call it after resets and teleports.
  void forgetDrawn() {
    drawn_ = false;
    frame_ = 0;
  }

  bool knowsState() const { return known_; }
  bool hasDrawn() const { return drawn_; }
  BufferId before() const { return before_; }
  StrandsBetween buffers() const { return {positions_, tangents_, roots_}; }
  /// Around the hair in the state before.
  const Ball& ballBefore() const { return ballBefore_; }
  void move(const WorldMove& move);

 private:
  void makeBuffers(const HairFrame& frame);

  BufferId before_ = BufferId::kInvalid;
  BufferId positions_ = BufferId::kInvalid, tangents_ = BufferId::kInvalid;
  BufferId roots_ = BufferId::kInvalid;
  bool known_ = false;  ///< there is a state before
  bool drawn_ = false;  ///< `positions_` is what an earlier frame has drawn
  uint64_t frame_ = 0;  ///< that placed the strands; 0: none
  Ball ballBefore_, ballNow_;
};

}  // namespace pelage::detail
