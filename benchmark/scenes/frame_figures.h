// GPU times of a row's frames: of all passes together, of groups of passes, and by the names that
// the lists have.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bench {

/// Median and mean over frames [us].
struct Spread {
  double median = 0, mean = 0;
};
Spread spreadOf(std::vector<double> values);

/// Purpose of a pass.
enum class PassGroup : uint8_t {
  kSimulation,     ///< all that move hair, but for those of the next two
  kSdf,            ///< writes to a buffer of an SDF
  kKept,           ///< keeps positions, for motion vectors and interpolation
  kInterpolation,  ///< places hair between two states
  kShadow,         ///< fills a shadow map
  kPicture,        ///< draws hair by a transparency method
  kDepth,          ///< draws depth and motion of hair
  kOpaque,         ///< draws the mesh, which is the engine's work
};
inline constexpr size_t kPassGroups = 8;
const char* passGroupName(PassGroup group);

/// Groups that drawing adds, without the shadow, which all rows have.
inline constexpr PassGroup kDrawingGroups[] = {PassGroup::kKept, PassGroup::kInterpolation,
                                               PassGroup::kPicture, PassGroup::kDepth};

/// All passes of one name.
struct PassFigure {
  std::string name;
  PassGroup group = PassGroup::kSimulation;
  uint64_t passes = 0;
  std::vector<double> us;  ///< [frame] of all of them together, 0 in a frame without one
};

class FrameFigures {
 public:
  void beginFrame();
  /// Adds a pass of the frame. \param milliseconds  negative without a timestamp
  void add(const char* name, PassGroup group, double milliseconds);

  /// Number of frames that have begun, and the sums of their passes.
  uint32_t frames() const { return frames_; }
  const std::vector<PassFigure>& passes() const { return passes_; }
  double perFrame(const PassFigure& pass) const {
    return static_cast<double>(pass.passes) / frames_;
  }
  /// Whether a pass of the group ran.
  bool has(PassGroup group) const;
  /// False where a pass had no timestamp; the times are nothing then.
  bool isTimed() const { return timed_ && !passes_.empty(); }
  /// All groups but kOpaque.
  Spread frame() const;
  Spread of(PassGroup group) const { return of(std::span(&group, 1)); }
  /// The passes of several groups together.
  Spread of(std::span<const PassGroup> groups) const;

 private:
  std::vector<PassFigure> passes_;
  std::array<std::vector<double>, kPassGroups> us_;  // [group][frame]
  uint32_t frames_ = 0;
  bool timed_ = true;
};

}  // namespace bench
