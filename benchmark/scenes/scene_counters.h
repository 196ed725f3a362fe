// Reads the counters of kernels, for the rows of the scene benchmark.
#pragma once

#include <string>
#include <vector>

#include "pelage/result.h"
#include "scenes/scene_run.h"
#include "simulation/workbench.h"

namespace bench {

struct Counter {
  std::string name;
  double value = 0;
};

/// The counters of the last frame, summed over the hair objects of a row. What a solver does not
/// count is left out. A counter that is added here appears in every table by itself.
pelage::Result<std::vector<Counter>> readSceneCounters(Workbench& workbench, const SceneRun& run);

/// Adds counters to those of the same name.
void addCounters(std::vector<Counter>& sum, const std::vector<Counter>& counters);

}  // namespace bench
