#include "simulation/copy_reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "simulation/median.h"

namespace bench {

using pelage::PassTiming;
using pelage::Result;
using Clock = std::chrono::steady_clock;

namespace {

// 128 MiB are moved by a copy: more than caches hold.
constexpr uint32_t kCopiedVertices = 1 << 20, kSoftwareCopiedVertices = 1 << 14;
constexpr uint64_t kCopiedSets = 4;
constexpr int kCopies = 60, kSoftwareCopies = 5;

}  // namespace

ClockDef clocksOf(const pelage::DeviceInfo& device, const ClockDef& def) {
  ClockDef clocks = def;
  if (device.software) {
    clocks.maxRuns = 1;
    clocks.warmUpMilliseconds = 0;
  }
  return clocks;
}

double CopyTimes::drift() const { return before > 0 ? std::abs(after / before - 1) : 0; }

CopyReference::CopyReference(pelage::HeadlessDevice& device, pelage::Scene& scene,
                             const ClockDef& def)
    : def_(clocksOf(device.info(), def)),
      copy_(device, scene, device.info().software ? kSoftwareCopiedVertices : kCopiedVertices,
            kCopiedSets),
      copies_(device.info().software ? kSoftwareCopies : kCopies) {}

Result<void> CopyReference::warmUp() {
  const Clock::time_point start = Clock::now();
  double worked = 0;
  // Without timestamps by the clock on the wall.
  while (worked < def_.warmUpMilliseconds) {
    const auto timings = copy_.run(copies_);
    if (!timings) return timings.error();
    bool timed = !timings->empty();
    for (const PassTiming& timing : *timings) {
      timed = timed && timing.milliseconds > 0;
      worked += std::max(timing.milliseconds, 0.0);
    }
    if (!timed) worked = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }
  return {};
}

Result<void> CopyReference::afterPause() {
  if (!(def_.warmUpMilliseconds > 0)) return {};
  const auto timings = copy_.run(copies_);
  if (!timings) return timings.error();
  return {};
}

Result<double> CopyReference::measure() {
  const auto timings = copy_.run(copies_);
  if (!timings) return timings.error();
  std::vector<double> us;
  for (const PassTiming& timing : *timings) us.push_back(1000 * timing.milliseconds);
  return std::max(medianOf(std::move(us)), 0.0);
}

}  // namespace bench
