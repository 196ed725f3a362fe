// Depth maps of opaque geometry among the shadow maps of hair: kernels/shadow/copy_opaque_shadow.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::detail {

/// Where a depth map comes from and goes to.
struct OpaqueShadowPlan {
  BufferId depth = BufferId::kInvalid;  ///< the engine's
  uint32_t words = 0;                   ///< texels of it
  uint32_t firstWord = 0;               ///< in the buffer of all maps
};

/// Adds the pass that copies the map. \param words of all maps, uint32, \param wordCount elements
/// of it. Errors: those of PassBuilder::finish().
Result<void> addOpaqueShadow(PassList& list, const OpaqueShadowPlan& plan, BufferId words,
                             uint64_t wordCount);

}  // namespace pelage::detail
