// GPU times of passes: a history of the last frames, and a CSV file of all frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace viewer {

class PassHistory {
 public:
  static constexpr size_t kFrames = 120;

  struct PassTime {
    std::string name;
    double milliseconds = 0;  ///< per frame, averaged over the last frames
    int passes = 0;           ///< with its name, in the last frame that had them
    std::vector<float> frames =
        {};  ///< [ms] of the last frames, the oldest first; 0 where it did not run
  };

  /// Adds a frame, unless it has no times.
  void add(std::span<const pelage::PassTiming> timings);
  /// Returns the time of all passes of each frame [ms], the oldest frame first.
  const std::vector<float>& totals() const { return totals_; }
  /// Returns the passes, the slowest first.
  std::vector<PassTime> passes() const;
  void clear();

 private:
  static void push(std::vector<float>& frames, double milliseconds);
  std::vector<float> totals_;
  std::vector<PassTime> passes_;  // in the order of their first frames
};

/// A line for each pass of each frame: frame, pass, passes of this name, milliseconds of all of
/// them; the slowest first. Passes without a time have none.
class TimesFile {
 public:
  /// Errors: a file that cannot be written.
  static pelage::Result<TimesFile> open(const std::filesystem::path& path);
  void add(uint64_t frame, std::span<const pelage::PassTiming> timings);
  const std::filesystem::path& path() const { return path_; }

 private:
  std::ofstream file_;
  std::filesystem::path path_;
};

}  // namespace viewer
