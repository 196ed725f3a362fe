// Times on a GPU whose clocks rise with work and fall without: copies before a row raise them, a
// copy beside it shows how they were, and a row during which they changed runs again.
#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "simulation/copy_load.h"

namespace bench {

struct ClockDef {
  int maxRuns = 4;                  ///< of a row
  double maxDrift = 0.05;           ///< of the copy beside a row, above which it runs again
  double warmUpMilliseconds = 300;  ///< GPU time of copies before a row
};
/// For a device: a software driver has no clocks that rise, and is never alone. It gets one run and
/// no warm-up.
ClockDef clocksOf(const pelage::DeviceInfo& device, const ClockDef& def = {});

/// Runs once, for tests that ignore times.
inline constexpr ClockDef kOnce = {.maxRuns = 1, .warmUpMilliseconds = 0};

/// The copy beside a row. Rows have one as their member `copies`.
struct CopyTimes {
  double before = 0, after = 0;  ///< time of a copy of fixed size [us]; 0 without timestamps
  int runs = 0;                  ///< of the row
  /// By which the copy took longer or shorter after the row, as a share; 0 without timestamps.
  double drift() const;
};

/// Copies on a device. Its buffers are removed with it.
class CopyReference {
 public:
  CopyReference(pelage::HeadlessDevice& device, pelage::Scene& scene, const ClockDef& def);
  const ClockDef& clocks() const { return def_; }
  /// Raises the clocks, and times a copy right before and right after what `timed` runs.
  template <class Timed>
  pelage::Result<CopyTimes> around(const Timed& timed);
  /// Keeps the clocks up in a row whose frames have pauses between them, in which the host works:
  /// copies for some milliseconds. Nothing where nothing is warmed up.
  pelage::Result<void> afterPause();

 private:
  pelage::Result<void> warmUp();
  /// Median time of one copy [us]; 0 without timestamps.
  pelage::Result<double> measure();

  ClockDef def_;
  CopyLoad copy_;
  int copies_;
};

/// Runs a row until the copy beside it drifts by no more than it may; keeps the run in which it
/// drifted least.
/// \param attempt  returns Result<Row> with Row::copies from CopyReference::around()
template <class Attempt>
auto steadiest(const ClockDef& def, const Attempt& attempt) -> decltype(attempt()) {
  auto best = attempt();
  // Not a number drifts by more than anything.
  const auto driftOf = [](const CopyTimes& copies) {
    const double drift = copies.drift();
    return drift >= 0 ? drift : std::numeric_limits<double>::infinity();
  };
  int runs = 1;
  for (; best && runs < def.maxRuns && driftOf(best->copies) > def.maxDrift; ++runs) {
    auto row = attempt();
    if (!row) return row;
    if (driftOf(row->copies) < driftOf(best->copies)) best = std::move(row);
  }
  if (best) best->copies.runs = runs;
  return best;
}

template <class Timed>
pelage::Result<CopyTimes> CopyReference::around(const Timed& timed) {
  if (pelage::Result<void> done = warmUp(); !done) return done.error();
  const auto before = measure();
  if (!before) return before.error();
  if (pelage::Result<void> done = timed(); !done) return done.error();
  const auto after = measure();
  if (!after) return after.error();
  return CopyTimes{*before, *after, 1};
}

}  // namespace bench
