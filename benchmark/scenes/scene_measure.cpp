#include "scenes/scene_measure.h"

#include <algorithm>
#include <chrono>
#include <memory>

namespace bench {

using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using Clock = std::chrono::steady_clock;

namespace {

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Runs the lists of one frame.
Result<void> runFrame(Workbench& workbench, SceneRun& run, std::vector<PassList>& lists,
                      FrameFigures* figures) {
  if (Result<void> done = run.advance(lists); !done) return done;
  if (figures != nullptr) figures->beginFrame();
  for (PassList& list : lists) {
    const auto timings = workbench.run(list);
    if (!timings) return timings.error();
    if (figures == nullptr) continue;
    for (size_t i = 0; i < list.passes.size(); ++i) {
      const pelage::Pass& pass = list.passes[i];
      const double time = i < timings->size() ? (*timings)[i].milliseconds : -1;
      const bool buildsSdf = writesTo(workbench.scene.resources(), list, pass,
                                      [&](std::string_view name) { return run.isSdfBuffer(name); });
      figures->add(pass.name, buildsSdf ? PassGroup::kSdf : PassGroup::kSimulation, time);
    }
  }
  return {};
}

/// One run of a row, from its first frame.
class RowRun {
 public:
  RowRun(Workbench& workbench, const MeasureDef& def) : workbench_(workbench), def_(def) {}

  Result<SceneResult> measure(CopyReference& reference, SceneAssets& assets, const SceneRow& row) {
    auto run = makeSceneRun(workbench_, row, assets);
    if (!run) return run.error();
    for (int frame = 0; frame < def_.warmUpFrames; ++frame)
      if (Result<void> done = runFrame(workbench_, **run, lists_, nullptr); !done)
        return done.error();
    describe(row, **run);
    const auto copies = reference.around([&] { return measureFrames(**run); });
    if (!copies) return copies.error();
    result_.copies = *copies;
    result_.errors = samples_.judge(def_.judgedVertices);
    for (Counter& counter : result_.counters) counter.value /= sampleCount();
    return std::move(result_);
  }

 private:
  int sampleCount() const { return std::clamp(def_.samples, 1, def_.frames); }

  void describe(const SceneRow& row, const SceneRun& run) {
    result_.row = row;
    for (const RunHair& hair : run.hairs()) {
      result_.guides += hair.asset->strandCount;
      result_.followHairs += hair.followHairs;
      result_.vertices += uint64_t{hair.asset->strandCount} * hair.asset->verticesPerStrand;
      result_.verticesPerStrand =
          std::max(result_.verticesPerStrand, hair.asset->verticesPerStrand);
    }
  }

  // Frames without a pause, but for the samples, which are only copied.
  Result<void> measureFrames(SceneRun& run) {
    int taken = 0;
    for (int frame = 1; frame <= def_.frames; ++frame) {
      if (Result<void> done = runFrame(workbench_, run, lists_, &result_.figures); !done)
        return done;
      if (frame * sampleCount() < (taken + 1) * def_.frames) continue;
      ++taken;
      if (Result<void> done = samples_.take(workbench_, run); !done) return done;
      const auto counters = readSceneCounters(workbench_, run);
      if (!counters) return counters.error();
      addCounters(result_.counters, *counters);
    }
    return {};
  }

  Workbench& workbench_;
  const MeasureDef& def_;
  std::vector<PassList> lists_;
  ErrorSamples samples_;
  SceneResult result_;
};

}  // namespace

Result<SceneResult> measureRow(Workbench& workbench, CopyReference& reference, SceneAssets& assets,
                               const SceneRow& row, const MeasureDef& def) {
  return steadiest(reference.clocks(),
                   [&] { return RowRun(workbench, def).measure(reference, assets, row); });
}

Result<double> firstFrame(Workbench& workbench, SceneAssets& assets, const SceneRow& row) {
  const auto run = makeSceneRun(workbench, row, assets);
  if (!run) return run.error();
  std::vector<PassList> lists;
  if (Result<void> done = (*run)->advance(lists); !done) return done.error();
  // Buffers and their contents are no part of it.
  if (Result<void> done = workbench.device.update(workbench.scene.resources()); !done)
    return done.error();
  const Clock::time_point start = Clock::now();
  for (const PassList& list : lists)
    if (Result<void> done = workbench.device.execute(list); !done) return done.error();
  return millisecondsSince(start);
}

}  // namespace bench
