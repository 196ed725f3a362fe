// Checks on bone influences, shared by .tfxbone and .tfxmesh.
#pragma once

#include <cstddef>
#include <span>

#include "pelage/bone_weights.h"

namespace pelage::detail {

/// 0..1e6; sums of four stay exact enough in float.
bool isWeight(float weight);

/// Binds the whole weight to the heaviest bone (the first one when all are zero) when the sum is
/// below 1e-6; true when it did.
bool repairWeights(BoneInfluences& influences);

/// Errors name "`what` `index`".
Result<void> checkInfluences(const BoneInfluences& influences, size_t boneCount, const char* what,
                             size_t index);

/// Each index 0..count-1 once, names shorter than maxLength and without NUL.
Result<void> checkBoneNames(std::span<const BoneName> bones, size_t maxLength);

}  // namespace pelage::detail
