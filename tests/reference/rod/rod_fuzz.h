// Random strands, materials, forces, steps and root motions, for stress tests of a solver.
#pragma once

#include <cstdint>
#include <vector>

#include "rod_settings.h"

namespace pelage::rod {

/// One strand with everything that happens to it. Segments of 1e-6 m to 3 m, some of zero length,
/// folded or all coincident; B from 0 to 100; gravity to 1e4 m/s2; wind to 1e3 m/s; steps of 1/240
/// to 1/15 s; turns of the root to 180 degrees a frame and teleports of metres.
struct FuzzCase {
  std::vector<Vector3d> points;  ///< 3 to 128
  RodSettings settings;          ///< colliders are in `colliders`
  std::vector<RodCollider> colliders;
  std::vector<double> steps;    ///< [frame], seconds
  std::vector<RootPose> poses;  ///< [frame + 1]; the first is the start
};

/// The case of a seed: the same on every platform.
FuzzCase makeFuzzCase(uint32_t seed, int frames);

}  // namespace pelage::rod
