// Checks on bone influences, shared by .tfxbone and .tfxmesh.
#pragma once

#include <cstddef>
#include <span>

#include "pelage/bone_weights.h"

namespace pelage::detail {

/// Range 0..1e6; sums of four stay exact enough in float.
bool isWeight(float weight);

/// If the sum is below 1e-6, gives the whole weight to the heaviest bone (the first one if all are
/// zero) and returns true.
bool repairWeights(BoneInfluences& influences);

/// Errors name "`what` `index`".
Result<void> checkInfluences(const BoneInfluences& influences, size_t boneCount, const char* what,
                             size_t index);

/// Checks that each index 0..count-1 occurs once, and that names are shorter than maxLength and
/// have no NUL.
Result<void> checkBoneNames(std::span<const BoneName> bones, size_t maxLength);

}  // namespace pelage::detail
