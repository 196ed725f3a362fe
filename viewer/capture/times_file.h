// GPU times of the passes as CSV, for spreadsheets and plots.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace viewer {

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
