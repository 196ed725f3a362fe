#include "scenes/frame_figures.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "simulation/median.h"

namespace bench {

namespace {

constexpr PassGroup kFrameGroups[] = {
    PassGroup::kSimulation, PassGroup::kSdf,     PassGroup::kKept, PassGroup::kInterpolation,
    PassGroup::kShadow,     PassGroup::kPicture, PassGroup::kDepth};

}  // namespace

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  const double mean =
      std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  return {medianOf(std::move(values)), mean};
}

const char* passGroupName(PassGroup group) {
  switch (group) {
    case PassGroup::kSimulation:
      return "simulation";
    case PassGroup::kSdf:
      return "sdf";
    case PassGroup::kKept:
      return "kept";
    case PassGroup::kInterpolation:
      return "interpolation";
    case PassGroup::kShadow:
      return "shadow";
    case PassGroup::kPicture:
      return "picture";
    case PassGroup::kDepth:
      return "depth";
    case PassGroup::kOpaque:
      return "opaque";
  }
  return "unknown";
}

void FrameFigures::beginFrame() {
  ++frames_;
  for (PassFigure& pass : passes_) pass.us.resize(frames_);
  for (std::vector<double>& sums : us_) sums.resize(frames_);
}

void FrameFigures::add(const char* name, PassGroup group, double milliseconds) {
  auto pass = std::find_if(passes_.begin(), passes_.end(),
                           [&](const PassFigure& p) { return p.name == name && p.group == group; });
  if (pass == passes_.end())
    pass = passes_.insert(pass, {name, group, 0, std::vector<double>(frames_)});
  ++pass->passes;
  if (milliseconds < 0) {
    timed_ = false;
    return;
  }
  const double us = 1000 * milliseconds;
  pass->us.back() += us;
  us_[static_cast<size_t>(group)].back() += us;
}

bool FrameFigures::has(PassGroup group) const {
  return std::any_of(passes_.begin(), passes_.end(),
                     [&](const PassFigure& pass) { return pass.group == group; });
}

Spread FrameFigures::frame() const { return of(kFrameGroups); }

Spread FrameFigures::of(std::span<const PassGroup> groups) const {
  std::vector<double> sums(frames_);
  for (const PassGroup group : groups)
    for (uint32_t frame = 0; frame < frames_; ++frame)
      sums[frame] += us_[static_cast<size_t>(group)][frame];
  return spreadOf(std::move(sums));
}

}  // namespace bench
