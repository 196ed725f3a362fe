// The order of a frame of one hair object.
#pragma once

#include <cstdint>
#include <optional>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "scene/hair_store.h"
#include "sdf/sdf_room.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The time of a frame.
struct FrameTime {
  float dt = 0;  ///< [s]
  uint32_t steps = 1;
  float share = 0;  ///< FrameMode::kBetween: 0 is the state before, 1 the last one
};

/// A solver moves the object.
bool isSimulated(const HairObject& object);
/// Where an object can collide with the meshes of the scene.
std::optional<HairReach> reachOf(const HairObject& object);
/// Outputs of the object are not where its state is.
bool isMovePending(const HairFrameState& state);
HairFrame frameOf(HairStore& store, HairObject& object, const SimulationSettings& settings,
                  FrameMode mode, FrameTime time, PassList& list);
/// Adds the passes of one object: those of its mode, in the order that is the same for all.
Result<void> recordHair(HairStore& store, HairObject& object, FrameMode mode, FrameTime time,
                        PassList& list);

}  // namespace pelage::detail
