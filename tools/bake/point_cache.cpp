#include "point_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pelage/hair_asset.h"
#include "sample_time.h"

namespace pelage::bake {
namespace {

struct CacheHeader {
  std::array<char, 12> magic = {};
  int32_t version = 0, points = 0;
  float startFrame = 0, framesPerSample = 0;
  int32_t samples = 0;
};
static_assert(sizeof(CacheHeader) == 32);
static_assert(sizeof(Float3) == 12);

constexpr std::array<char, 12> kMagic = {'P', 'O', 'I', 'N', 'T', 'C',
                                         'A', 'C', 'H', 'E', '2', '\0'};

}  // namespace

Error PointCache::fail(uint64_t byte, std::string_view what) const {
  return {ErrorCode::kInvalidFile, fmt::format("{}: byte {}: {}", name_, byte, what)};
}

Result<void> PointCache::readAt(uint64_t offset, std::span<std::byte> out) {
  for (size_t at = 0; at < out.size();) {
    const size_t got = source_->read(offset + at, out.subspan(at));
    if (got == 0) return fail(offset + at, "cannot be read");
    at += got;
  }
  return {};
}

Result<PointCache> PointCache::open(const std::filesystem::path& path) {
  auto file = FileSource::open(path);
  if (!file) return file.error();
  return open(std::make_unique<FileSource>(*std::move(file)), path.string());
}

Result<PointCache> PointCache::open(std::unique_ptr<ByteSource> source, std::string name) {
  const uint64_t size = source->size();
  PointCache cache(std::move(source), std::move(name));
  CacheHeader header;
  if (size < sizeof(header)) return cache.fail(size, "ends within its header of 32 bytes");
  if (auto done = cache.readAt(0, std::as_writable_bytes(std::span(&header, 1))); !done)
    return done.error();
  if (header.magic != kMagic) return cache.fail(0, "is no point cache: POINTCACHE2 is missing");
  if (header.version != 1) return cache.fail(12, "is of another version than 1");
  if (header.points < 1) return cache.fail(16, fmt::format("has {} points", header.points));
  if (!(header.framesPerSample > 0 && header.framesPerSample <= 1e6f))
    return cache.fail(24, fmt::format("has {} frames a sample, which must be above 0 and at most "
                                      "1000000",
                                      header.framesPerSample));
  if (header.samples < 1) return cache.fail(28, fmt::format("has {} samples", header.samples));
  cache.pointCount_ = static_cast<uint32_t>(header.points);
  cache.sampleCount_ = static_cast<uint32_t>(header.samples);
  cache.framesPerSample_ = header.framesPerSample;
  const uint64_t expected =
      sizeof(header) + sizeof(Float3) * uint64_t{cache.pointCount_} * cache.sampleCount_;
  if (size != expected)
    return cache.fail(std::min(size, expected),
                      fmt::format("{} samples of {} points have {} bytes, and the file has {}",
                                  cache.sampleCount_, cache.pointCount_, expected, size));
  return cache;
}

Result<const PointCache::Sample*> PointCache::sample(uint64_t number) {
  Sample& sample = samples_[number % samples_.size()];
  if (sample.number == number) return &sample;
  sample.number = UINT64_MAX;
  sample.positions.resize(pointCount_);
  const uint64_t offset = sizeof(CacheHeader) + number * pointCount_ * sizeof(Float3);
  if (auto done = readAt(offset, std::as_writable_bytes(std::span(sample.positions))); !done)
    return done.error();
  for (size_t i = 0; i < sample.positions.size(); ++i) {
    const Float3& p = sample.positions[i];
    // A number that is none fails all comparisons.
    if (!(std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
          std::abs(p.z) <= kMaxCoordinate))
      return fail(offset + i * sizeof(Float3),
                  fmt::format("sample {}: point {} is not finite, or beyond 1000000", number, i));
  }
  sample.number = number;
  return &sample;
}

Result<std::vector<Float3>> PointCache::positionsAt(double frames) {
  const SampleTime at = sampleAt(frames / framesPerSample_, sampleCount_);
  const auto first = sample(at.sample);
  if (!first) return first.error();
  std::vector<Float3> positions = (*first)->positions;
  if (at.share == 0) return positions;
  const auto second = sample(at.sample + 1);
  if (!second) return second.error();
  const auto share = static_cast<float>(at.share);
  for (size_t i = 0; i < positions.size(); ++i) {
    Float3& p = positions[i];
    const Float3& q = (*second)->positions[i];
    p = {p.x + (q.x - p.x) * share, p.y + (q.y - p.y) * share, p.z + (q.z - p.z) * share};
  }
  return positions;
}

}  // namespace pelage::bake
