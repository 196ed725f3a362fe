// The frames of a scene's hair.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/scene.h"
#include "scene/frame_journal.h"
#include "scene/hair_store.h"

namespace pelage::detail {

/// Writes lists that simulate hair, pose it, or move it. Scene documents functions of the same
/// name.
class HairSimulation {
 public:
  HairSimulation(HairStore& store, FrameJournal& journal) : store_(store), journal_(journal) {}
  Result<void> simulate(float dt, PassList& list);
  Result<void> interpolate(float share, PassList& list);
  /// Adds the passes of pending shifts and teleports to a list that does not simulate.
  Result<void> movePending(PassList& list);
  /// Call it once a list has all that movePending() or a simulation adds.
  void finishMoves();

 private:
  Result<void> checkHairs(bool onlyNew) const;
  Result<void> simulateFrame(float dt, uint32_t steps, PassList& list);
  Result<void> poseNewHair(PassList& list);

  HairStore& store_;
  FrameJournal& journal_;
  std::vector<HairReach> reaches_;  ///< of a frame; kept for its memory
};

}  // namespace pelage::detail
