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
#include "simulation/copy_reference.h"
#include "simulation/workbench.h"

namespace bench {

struct MeasureDef {
  int frames = 240;  ///< that are measured, each of 1/60 s
  int warmUpFrames = 60;
  int samples = 4;  ///< measured frames whose errors are looked at, the last one among them
  uint64_t judgedVertices = 20000;  ///< of a sample, see ErrorSamples::judge()
  ClockDef clocks;
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
  CopyTimes copies;               ///< beside the frames
  /// Median and mean frame over those of the classic baseline in the same scene; 0 without one.
  double ratioOfMedian = 0, ratioOfMean = 0;
};

/// Runs a row from its first frame, several times where the reference drifts.
pelage::Result<SceneResult> measureRow(Workbench& workbench, CopyReference& reference,
                                       SceneAssets& assets, const SceneRow& row,
                                       const MeasureDef& def);

/// Wall time of the first frame, from the first pipeline that is made to the end of the frame [ms].
pelage::Result<double> firstFrame(Workbench& workbench, SceneAssets& assets, const SceneRow& row);

}  // namespace bench
