// Runs one solver in one scene: what it got wrong, and what it cost.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulation/copy_reference.h"
#include "strand_solver.h"

namespace bench {

/// One row of the results.
struct Measurement {
  std::string scene, solver, setting;
  uint32_t effort = 0;                 ///< the number in the setting
  uint32_t strands = 0, vertices = 0;  ///< vertices a strand
  int frames = 0;
  /// Root mean square distance from the reference in percent of the strand's length; negative where
  /// the scene has none.
  double error = -1;
  /// Largest and root mean square change of length of edges of at least kShortestEdge [%].
  double maxStretch = 0, rmsStretch = 0;
  uint64_t brokenStrands = 0;  ///< with a coordinate that is not a number, in the last frame
  /// All passes of a frame [us]; 0 without timestamps.
  double medianFrame = 0, leastFrame = 0;
  /// The same without the pass that skins the roots, which the baselines do without.
  double medianSolve = 0, leastSolve = 0;
  uint64_t bytes = 0;  ///< that a frame moves at least; 0 when that is not known
  double floor = 0;    ///< [us] that a copy of as many bytes takes
  /// medianFrame over that of the classic baseline with 2 sweeps in the same scene; 0 without one.
  double ratioToBaseline = 0;
  CopyTimes copies;  ///< beside the frames
};

inline constexpr double kShortestEdge = 1e-3;  // m

/// The scene's reference, computed once for all solvers.
struct SceneReference {
  explicit SceneReference(const BenchScene& scene);
  std::optional<Reference> reference;
  double length = 0;  ///< of the first strand [m]
};

/// Runs the scene from its first frame, several times where the copy drifts.
pelage::Result<Measurement> measure(Workbench& workbench, CopyReference& copies,
                                    const BenchScene& scene, const SceneReference& reference,
                                    const SolverChoice& choice);

/// Appends rows to a CSV file, and the header when it is new.
pelage::Result<void> appendCsv(const std::string& path, const std::vector<Measurement>& rows,
                               const pelage::DeviceInfo& device, const std::string& commit);

}  // namespace bench
