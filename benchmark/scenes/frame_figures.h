// GPU times of a row's frames: of all passes together, and by the names that the lists have.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace bench {

/// Median and mean over frames [us].
struct Spread {
  double median = 0, mean = 0;
};
Spread spreadOf(std::vector<double> values);

/// All passes of one name.
struct PassFigure {
  std::string name;
  bool buildsSdf = false;
  uint64_t passes = 0;
  std::vector<double> us;  ///< [frame] of all of them together, 0 in a frame without one
};

class FrameFigures {
 public:
  void beginFrame();
  /// Adds a pass of the frame. \param milliseconds  negative without a timestamp
  void add(const char* name, bool buildsSdf, double milliseconds);

  /// Of all frames that have begun, and their passes.
  uint32_t frames() const { return frames_; }
  const std::vector<PassFigure>& passes() const { return passes_; }
  /// False where a pass had no timestamp; the times are nothing then.
  bool isTimed() const { return timed_ && !passes_.empty(); }
  Spread frame() const { return spreadOf(frame_); }
  Spread simulation() const { return spreadOf(simulation_); }
  Spread sdf() const { return spreadOf(sdf_); }

 private:
  std::vector<PassFigure> passes_;
  std::vector<double> frame_, simulation_, sdf_;  // [frame], us
  uint32_t frames_ = 0;
  bool timed_ = true;
};

}  // namespace bench
