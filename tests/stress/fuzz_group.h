// The strands, settings and motions of the reference's fuzz, as a scene takes them. Apart from the
// test because the references have a vector type each.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collider.h"
#include "pelage/hair_asset.h"
#include "pelage/simulation_settings.h"

namespace pelage::test {

/// An object whose strands have shapes and turns of their own; settings, colliders, steps and way
/// are those of its first strand. Bone s moves strand s.
struct FuzzGroup {
  HairAsset asset;  ///< processed
  SimulationSettings settings;
  bool heldTips = false;                                ///< inverse mass 0 at all tips
  std::vector<float> steps;                             ///< [frame] seconds
  std::vector<std::vector<AffineTransform>> bones;      ///< [frame + 1][strand]
  std::vector<std::vector<CapsuleCollider>> colliders;  ///< [frame + 1]
};

/// The cases of the seeds from `seed` on, `strands` of them.
/// \param cached  only what lavapipe has in its cache of compiled kernels, see StressTest
FuzzGroup makeFuzzGroup(uint32_t seed, uint32_t strands, int frames, Solver solver, bool cached);

}  // namespace pelage::test
