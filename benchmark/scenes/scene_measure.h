// Runs one row of the scene benchmark: what it cost, and what it got wrong.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/result.h"
#include "scenes/frame_figures.h"
#include "scenes/scene_assets.h"
#include "scenes/scene_counters.h"
#include "scenes/scene_errors.h"
#include "scenes/scene_rows.h"
#include "simulation/copy_load.h"
#include "simulation/workbench.h"

namespace bench {

struct MeasureDef {
  int frames = 240;  ///< that are measured, each of 1/60 s
  int warmUpFrames = 60;
  int samples = 4;  ///< measured frames whose errors are looked at, the last one among them
  uint64_t judgedVertices = 20000;  ///< of a sample, see ErrorSamples::judge()
  int maxRuns = 4;
  double maxDrift = 0.05;  ///< of the reference, above which a row is run again
  /// GPU time of copies before a row [ms]; 0 on a software driver.
  double warmUpMilliseconds = 300;
};

/// One row of the results.
struct SceneResult {
  SceneRow row;
  uint32_t guides = 0, followHairs = 0;
  uint64_t vertices = 0;           ///< of guides
  uint32_t verticesPerStrand = 0;  ///< the most that a strand has
  FrameFigures figures;
  SceneErrors errors;
  std::vector<Counter> counters;  ///< means over the samples
  /// A copy of fixed size before and after the frames [us]; 0 without timestamps.
  double referenceBefore = 0, referenceAfter = 0;
  int runs = 0;
  /// Of median and mean frame to those of the classic baseline in the same scene; 0 without one.
  double ratioOfMedian = 0, ratioOfMean = 0;
};

/// Copies that raise the clocks of a GPU and show how they are.
class CopyReference {
 public:
  explicit CopyReference(Workbench& workbench);
  /// Copies until the GPU has worked this long.
  pelage::Result<void> warmUp(double milliseconds);
  /// Median time of one copy [us]; 0 without timestamps.
  pelage::Result<double> measure();

 private:
  CopyLoad copy_;
};

/// Runs a row from its first frame, several times where the reference drifts; keeps the run in
/// which it did least.
pelage::Result<SceneResult> measureRow(Workbench& workbench, CopyReference& reference,
                                       SceneAssets& assets, const SceneRow& row,
                                       const MeasureDef& def);

/// Wall time of the first frame, from the first pipeline that is made to the end of the frame [ms].
pelage::Result<double> firstFrame(Workbench& workbench, SceneAssets& assets, const SceneRow& row);

}  // namespace bench
