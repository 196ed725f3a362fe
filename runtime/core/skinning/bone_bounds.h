// Where bones put the roots of hair.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/hair_asset.h"
#include "pelage/host_allocator.h"
#include "pelage/types.h"

namespace pelage::detail {

/// Ball around the bind positions of the roots that a bone moves.
struct BoneBounds {
  uint32_t bone = 0;
  Float3 center = {};
  float radius = 0;
};

/// Balls around the roots of every bone; without influences all roots belong to bone 0.
HostArray<BoneBounds> boundsOfRoots(const HairAsset& asset,
                                    std::span<const BoneInfluences> influences);
/// Mean of the balls' centers where bones put them. \param bones  empty: the bind pose
Float3 middleOf(std::span<const BoneBounds> bounds, std::span<const AffineTransform> bones);

}  // namespace pelage::detail
