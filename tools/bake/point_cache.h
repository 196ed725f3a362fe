// Point caches of a mesh, .pc2: the positions of all vertices, sample by sample, as modeling
// programs write them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage::bake {

/// Reads samples as they are asked for, and keeps two. Threads: one at a time.
class PointCache {
 public:
  /// Errors name the byte: no .pc2 file of version 1, a number of points or samples below 1, a
  /// sample rate that is not positive, a file that is shorter or longer than they say.
  static Result<PointCache> open(const std::filesystem::path& path);
  /// The same from any source; `name` names it in errors.
  static Result<PointCache> open(std::unique_ptr<ByteSource> source, std::string name);

  uint32_t pointCount() const { return pointCount_; }
  uint32_t sampleCount() const { return sampleCount_; }
  double framesPerSample() const { return framesPerSample_; }

  /// Positions [point] at a time in frames from the first sample, in the unit of the file; before
  /// it and behind the last one they are those. Between two samples vertices are on the line
  /// between their positions. Errors name the byte: a coordinate that is not finite or beyond
  /// +-1e6, a file that cannot be read any more. \param frames  any finite number
  Result<std::vector<Float3>> positionsAt(double frames);

 private:
  struct Sample {
    uint64_t number = UINT64_MAX;
    std::vector<Float3> positions;
  };
  PointCache(std::unique_ptr<ByteSource> source, std::string name)
      : source_(std::move(source)), name_(std::move(name)) {}
  Error fail(uint64_t byte, std::string_view what) const;
  Result<void> readAt(uint64_t offset, std::span<std::byte> out);
  Result<const Sample*> sample(uint64_t number);

  std::unique_ptr<ByteSource> source_;
  std::string name_;
  uint32_t pointCount_ = 0, sampleCount_ = 0;
  double framesPerSample_ = 1;
  std::array<Sample, 2> samples_;  ///< [number % 2]
};

}  // namespace pelage::bake
