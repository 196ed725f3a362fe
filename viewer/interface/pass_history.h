// GPU times of the passes of the last frames.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "pelage/headless.h"

namespace viewer {

class PassHistory {
 public:
  static constexpr size_t kFrames = 120;

  struct PassTime {
    std::string name;
    double milliseconds = 0;         ///< of a frame, averaged over the last frames
    int passes = 0;                  ///< of its name in the last frame that had it
    std::vector<float> frames = {};  ///< [ms] of the last frames, the oldest first; 0 without it
  };

  /// Adds a frame; nothing where it has no times.
  void add(std::span<const pelage::PassTiming> timings);
  /// Of all passes together [ms], the oldest frame first.
  const std::vector<float>& totals() const { return totals_; }
  /// The slowest first.
  std::vector<PassTime> passes() const;
  void clear();

 private:
  static void push(std::vector<float>& frames, double milliseconds);
  std::vector<float> totals_;
  std::vector<PassTime> passes_;  // in the order in which they came first
};

}  // namespace viewer
