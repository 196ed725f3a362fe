// Errors of a row: edges that are too long, vertices inside a collider, strands that are not
// finite.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/result.h"
#include "scenes/scene_run.h"
#include "simulation/workbench.h"

namespace bench {

struct SceneErrors {
  double stretchMax = 0;        ///< change of length of an edge of at least 1 mm, 0..
  uint64_t brokenStrands = 0;   ///< with a coordinate that is not finite, in any sample
  uint64_t judgedVertices = 0;  ///< that penetration was looked for; 0 without colliders
  /// Judged strands, over all samples, whose kinematic vertices are more than 1 mm inside of a
  /// collider. The others are those whose penetration counts.
  uint64_t strandsRootedInside = 0;
  double penetrationMax = 0;  ///< of a vertex into a collider [m]
  double penetrationTop = 0;  ///< 99.9 % of the vertices penetrate less [m]
};

/// Positions of guides at the end of some frames. Taking one only copies; judging them waits until
/// the times of a row are known, so that the GPU does not.
class ErrorSamples {
 public:
  pelage::Result<void> take(Workbench& workbench, const SceneRun& run);
  /// \param judged  vertices of a sample at most whose penetration is looked for, in whole strands
  ///   that are spread over all of them
  SceneErrors judge(uint64_t judged) const;

 private:
  struct HairSample {
    const pelage::HairAsset* asset = nullptr;
    std::vector<pelage::Float4> positions;  // of the guides
  };
  struct Sample {
    std::vector<HairSample> hairs;
    ColliderPose colliders;
  };
  std::vector<Sample> samples_;
};

}  // namespace bench
