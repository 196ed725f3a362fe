#include "scenes/scene_counters.h"

#include <algorithm>

namespace bench {

using pelage::Result;

namespace {

constexpr uint64_t kSolverCounterBytes = 32;  // see pelage::readCounters()

Result<std::vector<Counter>> readSolverCounters(Workbench& workbench, const RunHair& hair) {
  if (hair.buffers.sleep == pelage::BufferId::kInvalid) return std::vector<Counter>();
  const auto words = workbench.device.read(hair.buffers.sleep, 0, kSolverCounterBytes);
  if (!words) return words.error();
  const pelage::SimulationCounters counters = pelage::readCounters(*words);
  return std::vector<Counter>{{"awake_strands", static_cast<double>(counters.awakeStrands)},
                              {"second_passes", static_cast<double>(counters.secondPasses)}};
}

}  // namespace

void addCounters(std::vector<Counter>& sum, const std::vector<Counter>& counters) {
  for (const Counter& counter : counters) {
    const auto found = std::find_if(sum.begin(), sum.end(),
                                    [&](const Counter& c) { return c.name == counter.name; });
    if (found == sum.end())
      sum.push_back(counter);
    else
      found->value += counter.value;
  }
}

Result<std::vector<Counter>> readSceneCounters(Workbench& workbench, const SceneRun& run) {
  std::vector<Counter> sum;
  for (const RunHair& hair : run.hairs()) {
    const auto counters = readSolverCounters(workbench, hair);
    if (!counters) return counters.error();
    addCounters(sum, *counters);
  }
  return sum;
}

}  // namespace bench
