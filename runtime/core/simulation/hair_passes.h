// The passes around a solver: roots before it, stored follow hairs after it, and shifts.
#pragma once

#include <cstdint>

#include "base/rigid_move.h"
#include "contact/follow_contacts.h"
#include "passes/moved_elements.h"
#include "pelage/kernel.h"
#include "pelage/result.h"
#include "simulation/hair_frame.h"

namespace pelage::detail {

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
/// Moves stored follow hairs out of colliders.
Result<void> addFollowCollision(const HairFrame& frame, FollowContacts& contacts);
/// Moves Float4 of a buffer by a shift of the world [m].
Result<void> addShift(const HairFrame& frame, Float3 by, BufferId buffer, uint64_t first,
                      uint64_t count);

/// Moves elements of a room by a rigid motion.
Result<void> addRigidMove(const HairFrame& frame, const RigidMove& move,
                          const MovedElements& elements);

}  // namespace pelage::detail
