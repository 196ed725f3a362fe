// The order of a frame of one hair object.
#pragma once

#include <cstdint>
#include <optional>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "scene/hair_store.h"
#include "sdf/sdf_room.h"
#include "simulation/hair_frame.h"

namespace pelage::detail {

/// What a list does with a hair object.
enum class FrameMode : uint8_t {
  kSimulate = 1,  ///< a solver moves it
  kSkin = 2,      ///< bones move it, or given positions
  kPose = 4,      ///< it is shown in its bind pose, and its state stays as it was
  kMove = 8,      ///< it goes where a teleport or a shift of the world brings it
};

/// A part of the time that lists simulate.
struct FrameTime {
  float dt = 0;  ///< [s]
  uint32_t steps = 1;
};

/// A solver moves the object.
bool isSimulated(const HairObject& object);
/// Where an object can collide with the meshes of the scene.
std::optional<HairReach> reachOf(const HairObject& object);
/// Outputs of the object are not where its state is.
bool isMovePending(const HairFrameState& state);
HairFrame frameOf(HairStore& store, HairObject& object, const SimulationSettings& settings,
                  FrameTime time, PassList& list);
/// Adds the passes of one object: those of its mode, in the order that is the same for all.
Result<void> recordHair(HairStore& store, HairObject& object, FrameMode mode, FrameTime time,
                        PassList& list);
/// Adds the passes that place an object between its last two states.
Result<void> interpolateHair(HairStore& store, HairObject& object, float share, PassList& list);

}  // namespace pelage::detail
