#include "scenes/frame_figures.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "simulation/median.h"

namespace bench {

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  const double mean =
      std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  return {medianOf(std::move(values)), mean};
}

void FrameFigures::beginFrame() {
  ++frames_;
  for (PassFigure& pass : passes_) pass.us.resize(frames_);
  for (std::vector<double>* sum : {&frame_, &simulation_, &sdf_}) sum->resize(frames_);
}

void FrameFigures::add(const char* name, bool buildsSdf, double milliseconds) {
  auto pass = std::find_if(passes_.begin(), passes_.end(), [&](const PassFigure& p) {
    return p.name == name && p.buildsSdf == buildsSdf;
  });
  if (pass == passes_.end())
    pass = passes_.insert(pass, {name, buildsSdf, 0, std::vector<double>(frames_)});
  ++pass->passes;
  if (milliseconds < 0) {
    timed_ = false;
    return;
  }
  const double us = 1000 * milliseconds;
  pass->us.back() += us;
  frame_.back() += us;
  (buildsSdf ? sdf_ : simulation_).back() += us;
}

}  // namespace bench
