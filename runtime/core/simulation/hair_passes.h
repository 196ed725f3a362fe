// The passes around a solver: roots before it, stored follow hairs after it, and shifts.
#pragma once

#include <cstdint>

#include "base/rigid_move.h"
#include "passes/moved_elements.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernel.h"
#include "pelage/result.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// Constants of every kernel of the group "simulation".
SimulationConstants constantsOf(const HairFrame& frame);

/// Groups along an axis of a dispatch that every device takes.
inline constexpr uint64_t kMaxGroups = 65535;
/// Threads in x of update_follow_hairs.
uint32_t followThreads(uint32_t strands);
/// Most follow hairs that one dispatch places.
uint64_t maxStoredFollows();
/// Where g_sleep has the groups of the follow strands [bytes].
inline constexpr uint64_t kFollowArguments = exact::kSleepFollowArguments * sizeof(uint32_t);

/// Puts the roots where the bones are.
Result<void> addRootPass(const HairFrame& frame, SkinningMethod skinning);
/// Places stored follow hairs beside their guides.
Result<void> addFollowPass(const HairFrame& frame);
/// Moves Float4 of a buffer by a shift of the world [m].
Result<void> addShift(const HairFrame& frame, Float3 by, BufferId buffer, uint64_t first,
                      uint64_t count);

/// Moves elements of a room by a rigid motion.
Result<void> addRigidMove(const HairFrame& frame, const RigidMove& move,
                          const MovedElements& elements);

}  // namespace pelage::detail
