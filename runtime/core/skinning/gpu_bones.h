// Bones that an engine has on the GPU: the passes that bring them into the form that skinning
// reads.
#pragma once

#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// Adds the passes that write a method's copy.
Result<void> addBonePasses(SkeletonInternals& skeleton, SkinningMethod method,
                           const ResourceTable& resources, PassList& list);

}  // namespace pelage::detail
