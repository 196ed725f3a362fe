// Capsules that hair collides with, from frame to frame.
#pragma once

#include <cstddef>
#include <span>

#include "base/bone_moves.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "base/rigid_move.h"
#include "pelage/collider.h"
#include "pelage/gpu_structs.h"

namespace pelage::detail {

/// True for other capsules than before; those that only move are not.
bool areReplaced(std::span<const CapsuleCollider> before, std::span<const CapsuleCollider> now);
/// Writes the capsules that reach a ball in a frame of so many seconds, relative to an origin, as
/// far as there is room. \return their number
size_t packCapsules(std::span<const CapsuleCollider> capsules,
                    std::span<const CapsuleCollider> capsulesBefore, const LocalOrigin& origin,
                    const Ball& ball, float seconds, std::span<Collider> packed = {});
/// The way of the fastest capsule that reaches a ball, over its smaller radius.
/// \param enough  the same: ways up to this one need not be the least of the hair's moves
double wayInRadii(std::span<const CapsuleCollider> capsules,
                  std::span<const CapsuleCollider> capsulesBefore, const Ball& ball,
                  const BoneMoves& moves, double enough);
void moveCapsules(std::span<CapsuleCollider> capsules, const WorldMove& move);
/// After shifts of the world: capsules that moved by no more than an engine's rounding have not
/// moved. \param roundedShift  sum of the largest components of the shifts [m]
void settleCapsules(std::span<CapsuleCollider> before, std::span<const CapsuleCollider> now,
                    double roundedShift);

}  // namespace pelage::detail
