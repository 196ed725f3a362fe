#include "capture/pass_times.h"

#include <fmt/format.h>

#include <algorithm>

namespace viewer {

namespace {

constexpr double kWeight = 0.1;      // of the last frame in the averages
constexpr double kForgotten = 1e-4;  // [ms]; drops passes that no longer run

}  // namespace

void PassHistory::add(std::span<const pelage::PassTiming> timings) {
  std::vector<PassTime> frame;
  double total = 0;
  for (const pelage::PassTiming& timing : timings) {
    if (!(timing.milliseconds >= 0)) continue;  // without timestamps
    auto known = std::find_if(frame.begin(), frame.end(),
                              [&](const PassTime& pass) { return pass.name == timing.name; });
    if (known == frame.end()) known = frame.insert(frame.end(), {timing.name, 0, 0, {}});
    known->milliseconds += timing.milliseconds;
    ++known->passes;
    total += timing.milliseconds;
  }
  if (frame.empty()) return;
  push(totals_, total);
  for (PassTime& pass : passes_) pass.milliseconds *= 1 - kWeight;
  for (PassTime& pass : passes_) push(pass.frames, 0);
  for (const PassTime& now : frame) {
    const auto known = std::find_if(passes_.begin(), passes_.end(),
                                    [&](const PassTime& pass) { return pass.name == now.name; });
    if (known == passes_.end()) {
      passes_.push_back(now);
      passes_.back().frames.assign(totals_.size(), 0);
      passes_.back().frames.back() = static_cast<float>(now.milliseconds);
    } else {
      known->milliseconds += kWeight * now.milliseconds;
      known->passes = now.passes;
      known->frames.back() = static_cast<float>(now.milliseconds);
    }
  }
  std::erase_if(passes_, [](const PassTime& pass) { return pass.milliseconds < kForgotten; });
}

void PassHistory::push(std::vector<float>& frames, double milliseconds) {
  if (frames.size() == kFrames) frames.erase(frames.begin());
  frames.push_back(static_cast<float>(milliseconds));
}

std::vector<PassHistory::PassTime> PassHistory::passes() const {
  std::vector<PassTime> sorted = passes_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const PassTime& a, const PassTime& b) {
    return a.milliseconds > b.milliseconds;
  });
  return sorted;
}

void PassHistory::clear() {
  totals_.clear();
  passes_.clear();
}

pelage::Result<TimesFile> TimesFile::open(const std::filesystem::path& path) {
  TimesFile times;
  times.path_ = path;
  times.file_.open(path);
  if (!times.file_)
    return pelage::Error{pelage::ErrorCode::kFileNotFound,
                         path.string() + ": the times cannot be written"};
  times.file_ << "frame,pass,passes,milliseconds\n";
  return times;
}

void TimesFile::add(uint64_t frame, std::span<const pelage::PassTiming> timings) {
  PassHistory own;
  own.add(timings);
  for (const PassHistory::PassTime& pass : own.passes())
    file_ << fmt::format("{},{},{},{:.6f}\n", frame, pass.name, pass.passes, pass.milliseconds);
  file_.flush();
}

}  // namespace viewer
