#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <system_error>
#include <utility>

#include "assets/hair_cache_codec.h"
#include "assets/hair_cache_file.h"
#include "assets/hair_cache_format.h"
#include "base/file_io.h"
#include "base/finite.h"
#include "base/guard.h"
#include "base/hash.h"
#include "base/workers.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_cache.h"

namespace pelage {
namespace detail::hair_cache {
namespace {

using Bytes = std::vector<std::byte>;

Error invalid(const HairCacheDef& def, std::string_view what) {
  return Error{ErrorCode::kInvalidArgument, fmt::format("hair cache '{}': {}", def.name, what)};
}

// The step with which each vertex of a frame stays within the bound; 0 where only exact floats do.
//
// A coordinate x becomes n = round(x / step), and n * step in floats. The distance of a vertex is
// at most sqrt(3) times the error of a coordinate, which is step / 2 and the rounding of the
// product, at most an ulp of the largest coordinate. A step that is a power of two has no rounding:
// n is below 2^24, or x is a multiple of the step. It is taken where an ulp is too much of the
// bound.
float stepFor(double maxCoordinate, double errorBound) {
  if (errorBound == 0) return 0;
  const double perAxis = errorBound / std::numbers::sqrt3;
  const double powerOfTwo = std::exp2(std::floor(std::log2(2 * perAxis)));
  const double ulp = std::exp2(std::ilogb(std::max(maxCoordinate, 1e-30)) - 23);
  // The floor keeps one step for all frames of usual hair.
  const double finest = 2 * (perAxis - std::max(ulp, errorBound / 32)) * (1 - 1e-6);
  const double step = std::max(finest, powerOfTwo);
  return maxCoordinate <= step * 0x1p30 ? static_cast<float>(step) : 0.0f;
}

}  // namespace

struct FrameWriter {
  /// Memory of one thread.
  struct Worker {
    Encoder encoder;
    Bytes contents;  ///< of the chunks that it has encoded of the frame
  };
  /// One chunk of the frame in its compressed form.
  struct Encoded {
    ChunkHeader header;
    uint32_t worker = 0;
    size_t offset = 0;  ///< in its contents
  };
  /// Extremes of the positions of a chunk.
  struct Extent {
    float maxCoordinate = 0;
    size_t notFinite = SIZE_MAX;  ///< the first vertex that is not; SIZE_MAX: all are
  };

  HairCacheDef def;
  std::vector<Chunk> chunks;
  OutputFile file;
  std::vector<IndexEntry> index;
  Workers threads;
  std::vector<Worker> workers;  ///< [thread]
  std::vector<Encoded> encoded;
  std::vector<Extent> extents;
  std::vector<uint32_t> values, last, beforeLast;
  float step = 0;
  Bytes record;
  bool closed = false;

  FrameWriter(HairCacheDef d, OutputFile f, uint32_t threadCount)
      : def(std::move(d)),
        chunks(chunksOf(def)),
        file(std::move(f)),
        threads(std::clamp(threadCount, 1u, static_cast<uint32_t>(chunks.size()))),
        workers(threads.count()),
        encoded(chunks.size()),
        extents(chunks.size()) {}

  Extent extentOf(std::span<const Float3> positions);
  void quantize(const Chunk& chunk, std::span<const Float3> positions);
  void encodeFrame(uint32_t fromKey, std::span<const Float3> positions);
  Result<void> append(std::span<const Float3> positions);
  Result<void> close();
};

FrameWriter::Extent FrameWriter::extentOf(std::span<const Float3> positions) {
  threads.run(chunks.size(), [&](size_t i, uint32_t) {
    Extent extent;
    for (size_t v = 0; v < chunks[i].vertexCount; ++v) {
      const Float3& p = positions[chunks[i].firstVertex + v];
      if (!isFinite(p)) {
        extent.notFinite = chunks[i].firstVertex + v;
        break;
      }
      extent.maxCoordinate =
          std::max({extent.maxCoordinate, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    extents[i] = extent;
  });
  Extent all;
  for (const Extent& extent : extents) {
    all.maxCoordinate = std::max(all.maxCoordinate, extent.maxCoordinate);
    all.notFinite = std::min(all.notFinite, extent.notFinite);
  }
  return all;
}

// Fills `values` of a chunk.
void FrameWriter::quantize(const Chunk& chunk, std::span<const Float3> positions) {
  const double inverse = step > 0 ? 1 / static_cast<double>(step) : 0;
  const auto integer = [&](float x) {
    return step > 0 ? static_cast<uint32_t>(std::llrint(x * inverse)) : orderedBits(x);
  };
  for (size_t i = chunk.firstVertex; i < size_t{chunk.firstVertex} + chunk.vertexCount; ++i) {
    values[3 * i] = integer(positions[i].x);
    values[3 * i + 1] = integer(positions[i].y);
    values[3 * i + 2] = integer(positions[i].z);
  }
}

// Fills `values`, and makes `record` of them. Which thread encodes a chunk changes no byte.
void FrameWriter::encodeFrame(uint32_t fromKey, std::span<const Float3> positions) {
  const auto maxTimeOrder = static_cast<uint8_t>(std::min(fromKey, 2u));
  values.resize(3 * positions.size());
  for (Worker& worker : workers) worker.contents.clear();
  threads.run(chunks.size(), [&](size_t i, uint32_t thread) {
    quantize(chunks[i], positions);
    const size_t at = size_t{3} * chunks[i].firstVertex;
    const History history = {fromKey > 0 ? last.data() + at : nullptr,
                             fromKey > 1 ? beforeLast.data() + at : nullptr};
    Worker& worker = workers[thread];
    encoded[i] = {{}, thread, worker.contents.size()};
    encoded[i].header = worker.encoder.encode(def, chunks[i], values.data() + at, history,
                                              maxTimeOrder, worker.contents);
  });
  record.clear();
  detail::append(record, FrameHeader{.isKey = fromKey == 0 ? 1u : 0u,
                                     .step = step,
                                     .chunkCount = static_cast<uint32_t>(chunks.size())});
  for (const Encoded& chunk : encoded) detail::append(record, chunk.header);
  for (const Encoded& chunk : encoded) {
    const auto from = workers[chunk.worker].contents.begin() + static_cast<ptrdiff_t>(chunk.offset);
    record.insert(record.end(), from, from + chunk.header.byteCount);
  }
}

Result<void> FrameWriter::append(std::span<const Float3> positions) {
  if (closed) return invalid(def, "the writer is closed");
  if (positions.size() != countVertices(def))
    return invalid(
        def, fmt::format("{} positions for {} vertices", positions.size(), countVertices(def)));
  const int64_t number = def.firstFrame + static_cast<int64_t>(index.size());
  const Extent extent = extentOf(positions);
  if (extent.notFinite != SIZE_MAX)
    return invalid(def, fmt::format("frame {}: vertex {} is not finite", number, extent.notFinite));
  const float newStep = stepFor(extent.maxCoordinate, def.errorBound);
  const bool isKey = index.empty() || number % def.keyInterval == 0 || newStep != step;
  step = newStep;
  IndexEntry entry;
  entry.fromKey = isKey ? 0 : index.back().fromKey + 1;
  encodeFrame(entry.fromKey, positions);
  entry.offset = file.size();
  entry.byteCount = static_cast<uint32_t>(record.size());
  entry.checksum = hash64(record);
  if (auto r = file.write(record); !r) return r;
  index.push_back(entry);
  // values -> last -> beforeLast
  beforeLast.swap(last);
  last.swap(values);
  return {};
}

Result<void> FrameWriter::close() {
  if (closed) return invalid(def, "the writer is closed");
  closed = true;
  if (auto r = file.write(packIndex(index, file.size())); !r) return r;
  return file.close();
}

}  // namespace detail::hair_cache

Result<void> validate(const HairCacheDef& def) {
  using namespace detail::hair_cache;
  if (def.name.size() > kMaxNameLength)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("hair cache: the name has {} bytes; at most {}", def.name.size(),
                             kMaxNameLength)};
  if (const char* fault = faultOf(def)) return invalid(def, fault);
  return {};
}

uint32_t vertexCountOf(const HairCacheDef& def) {
  return static_cast<uint32_t>(detail::hair_cache::countVertices(def));
}

struct HairCacheWriter::Impl : detail::hair_cache::FrameWriter {
  using FrameWriter::FrameWriter;
};

HairCacheWriter::HairCacheWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HairCacheWriter::HairCacheWriter(HairCacheWriter&&) noexcept = default;
HairCacheWriter& HairCacheWriter::operator=(HairCacheWriter&&) noexcept = default;
HairCacheWriter::~HairCacheWriter() = default;

Result<HairCacheWriter> HairCacheWriter::create(const std::filesystem::path& path, HairCacheDef def,
                                                uint32_t threads) {
  return detail::guarded([&]() -> Result<HairCacheWriter> {
    if (auto r = validate(def); !r) return r.error();
    auto file = detail::hair_cache::OutputFile::create(path);
    if (!file) return file.error();
    auto impl = std::make_unique<Impl>(std::move(def), std::move(*file), threads);
    if (auto r = impl->file.write(detail::hair_cache::packHeader(impl->def)); !r) return r.error();
    return HairCacheWriter(std::move(impl));
  });
}

Result<void> HairCacheWriter::append(std::span<const Float3> positions) {
  return detail::guarded([&] { return impl_->append(positions); });
}
Result<void> HairCacheWriter::close() {
  return detail::guarded([&] { return impl_->close(); });
}
uint64_t HairCacheWriter::frameCount() const { return impl_->index.size(); }
uint64_t HairCacheWriter::byteCount() const { return impl_->file.size(); }

}  // namespace pelage
