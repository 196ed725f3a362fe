#include "scenes/scene_measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

namespace bench {

using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using Clock = std::chrono::steady_clock;

namespace {

// 128 MiB are moved by a copy: more than caches hold.
constexpr uint32_t kCopiedVertices = 1 << 20, kSoftwareCopiedVertices = 1 << 14;
constexpr uint64_t kCopiedSets = 4;
constexpr int kReferenceCopies = 60, kSoftwareReferenceCopies = 5;

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
      figures->add(pass.name, buildsSdf(workbench, run, list, pass), time);
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
    if (Result<void> done = reference.warmUp(def_.warmUpMilliseconds); !done) return done.error();
    const auto before = reference.measure();
    if (!before) return before.error();
    if (Result<void> done = measureFrames(**run); !done) return done.error();
    const auto after = reference.measure();
    if (!after) return after.error();
    result_.referenceBefore = *before;
    result_.referenceAfter = *after;
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

double driftOf(const SceneResult& result) {
  if (!(result.referenceBefore > 0)) return 0;
  return std::abs(result.referenceAfter / result.referenceBefore - 1);
}

}  // namespace

CopyReference::CopyReference(Workbench& workbench)
    : copy_(workbench, workbench.device.info().software ? kSoftwareCopiedVertices : kCopiedVertices,
            kCopiedSets) {}

Result<void> CopyReference::warmUp(double milliseconds) {
  const Clock::time_point start = Clock::now();
  double worked = 0;
  // Without timestamps by the clock on the wall.
  while (worked < milliseconds) {
    const auto timings = copy_.run(kReferenceCopies);
    if (!timings) return timings.error();
    bool timed = !timings->empty();
    for (const PassTiming& timing : *timings) {
      timed = timed && timing.milliseconds > 0;
      worked += std::max(timing.milliseconds, 0.0);
    }
    if (!timed) worked = millisecondsSince(start);
  }
  return {};
}

Result<double> CopyReference::measure() {
  const bool small = copy_.bytes() < uint64_t{kCopiedVertices} * 2 * kCopiedSets * 16;
  const auto timings = copy_.run(small ? kSoftwareReferenceCopies : kReferenceCopies);
  if (!timings) return timings.error();
  std::vector<double> us;
  for (const PassTiming& timing : *timings) us.push_back(1000 * timing.milliseconds);
  return std::max(spreadOf(std::move(us)).median, 0.0);
}

Result<SceneResult> measureRow(Workbench& workbench, CopyReference& reference, SceneAssets& assets,
                               const SceneRow& row, const MeasureDef& def) {
  SceneResult best;
  double leastDrift = std::numeric_limits<double>::infinity();
  int runs = 0;
  while (runs < def.maxRuns && leastDrift > def.maxDrift) {
    auto result = RowRun(workbench, def).measure(reference, assets, row);
    if (!result) return result.error();
    ++runs;
    const double drift = driftOf(*result);
    if (drift >= leastDrift) continue;
    leastDrift = drift;
    best = *std::move(result);
  }
  best.runs = runs;
  return best;
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
