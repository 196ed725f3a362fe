// Weighted means of bone influences.
#pragma once

#include <cstdint>
#include <span>

#include "pelage/bone_weights.h"

namespace pelage::detail {

struct WeightedInfluences {
  const BoneInfluences* influences;
  double weight;  ///< >= 0
};

/// The mean, each side's weights scaled to the sum 1 first; the `maxBones` (1..4) heaviest bones,
/// heaviest first, of equal weights the lower index; their sum is 1. `lost` gets the share of the
/// others. At least one weight is above 0.
BoneInfluences blendInfluences(std::span<const WeightedInfluences> parts, uint32_t maxBones,
                               double* lost = nullptr);

}  // namespace pelage::detail
