#include "assets/hair_cache_codec.h"

#include <zstd.h>

#include <algorithm>
#include <bit>
#include <new>

#include "pelage/assert.h"

namespace pelage::detail::hair_cache {
namespace {

// Residuals have their sizes in common, and little else: short matches cost more time to decode
// than they save, and higher levels find none.
constexpr int kLevel = 1, kMinMatch = 7;
constexpr uint32_t kSampleVertices = 1024;

uint32_t zigzag(uint32_t value) {
  return (value << 1) ^ static_cast<uint32_t>(static_cast<int32_t>(value) >> 31);
}
uint32_t unzigzag(uint32_t value) { return (value >> 1) ^ (0u - (value & 1)); }

// A strand predicts from the one before it in the chunk: its values and their number of vertices.
struct Neighbor {
  const uint32_t* values = nullptr;
  uint32_t vertexCount = 0;
};

// Calls code(values of the strand, vertices, neighbor) for each strand of a chunk.
template <class Function>
void forEachStrand(const HairCacheDef& def, const Chunk& chunk, uint32_t* values, Function&& code) {
  Neighbor neighbor;
  for (uint32_t s = 0; s < chunk.strandCount; ++s) {
    const uint32_t vertices = verticesOf(def, chunk.firstStrand + s);
    code(values, vertices, neighbor);
    neighbor = {values, vertices};
    values += size_t{3} * vertices;
  }
}

// values += prediction by the values before, in ascending order.
void addPrediction(uint32_t* values, uint32_t vertices, Neighbor neighbor, uint8_t spaceOrder) {
  uint32_t last[3], change[3] = {0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    values[k] += neighbor.values ? neighbor.values[k] : 0;
    last[k] = values[k];
  }
  const uint32_t shared = std::min(vertices, neighbor.vertexCount);
  uint32_t v = 1;
  if (spaceOrder == kNeighbor) {
    for (; v < shared; ++v) {
      const uint32_t* beside = neighbor.values + size_t{3} * v;
      for (int k = 0; k < 3; ++k) {
        last[k] += values[3 * v + k] + beside[k] - beside[k - 3];
        values[3 * v + k] = last[k];
      }
    }
  }
  if (spaceOrder == kLinear) {
    for (; v < vertices; ++v) {
      for (int k = 0; k < 3; ++k) {
        change[k] += values[3 * v + k];
        last[k] += change[k];
        values[3 * v + k] = last[k];
      }
    }
  }
  for (; v < vertices; ++v) {
    for (int k = 0; k < 3; ++k) {
      last[k] += values[3 * v + k];
      values[3 * v + k] = last[k];
    }
  }
}

// residuals = values - prediction.
void subtractPrediction(const uint32_t* values, uint32_t* residuals, uint32_t vertices,
                        Neighbor neighbor, uint8_t spaceOrder) {
  for (int k = 0; k < 3; ++k) residuals[k] = values[k] - (neighbor.values ? neighbor.values[k] : 0);
  const uint32_t shared = spaceOrder == kNeighbor ? std::min(vertices, neighbor.vertexCount) : 0;
  for (uint32_t i = 3; i < 3 * vertices; ++i) {
    uint32_t predicted = values[i - 3];
    if (i < 3 * shared) predicted += neighbor.values[i] - neighbor.values[i - 3];
    if (spaceOrder == kLinear && i >= 6) predicted += values[i - 3] - values[i - 6];
    residuals[i] = values[i] - predicted;
  }
}

// Residuals of time, [3 * vertex].
void subtractHistory(const uint32_t* values, History history, uint8_t timeOrder, size_t count,
                     uint32_t* out) {
  for (size_t i = 0; i < count; ++i) {
    uint32_t predicted = 0;
    if (timeOrder > 0) predicted = history.last[i];
    if (timeOrder > 1) predicted += history.last[i] - history.beforeLast[i];
    out[i] = values[i] - predicted;
  }
}

// An estimate of the bits that residuals cost.
uint64_t costOf(std::span<const uint32_t> residuals) {
  uint64_t bits = 0;
  for (const uint32_t r : residuals) bits += static_cast<uint64_t>(std::bit_width(zigzag(r)));
  return bits;
}

// The first strands of a chunk, on which predictions are tried: neighbors of theirs are among them.
Chunk sampleOf(const HairCacheDef& def, const Chunk& chunk) {
  Chunk sample = {.firstStrand = chunk.firstStrand, .firstVertex = chunk.firstVertex};
  while (sample.strandCount < chunk.strandCount && sample.vertexCount < kSampleVertices)
    sample.vertexCount += verticesOf(def, sample.firstStrand + sample.strandCount++);
  return sample;
}

template <int kPlanes>
void joinPlanes(const uint8_t* planes, size_t count, uint32_t* out) {
  for (size_t i = 0; i < count; ++i) {
    uint32_t value = planes[i];
    if constexpr (kPlanes > 1) value |= uint32_t{planes[count + i]} << 8;
    if constexpr (kPlanes > 2) value |= uint32_t{planes[2 * count + i]} << 16;
    if constexpr (kPlanes > 3) value |= uint32_t{planes[3 * count + i]} << 24;
    out[i] = unzigzag(value);
  }
}

}  // namespace

struct Encoder::Context {
  Context() : zstd(ZSTD_createCCtx()) {
    if (!zstd) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(zstd, ZSTD_c_compressionLevel, kLevel);
    ZSTD_CCtx_setParameter(zstd, ZSTD_c_minMatch, kMinMatch);
  }
  ~Context() { ZSTD_freeCCtx(zstd); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ZSTD_CCtx* zstd;
};

Encoder::Encoder() : context_(std::make_unique<Context>()) {}
Encoder::~Encoder() = default;

void Encoder::predict(const HairCacheDef& def, const Chunk& chunk, const uint32_t* values,
                      History history, Prediction prediction) {
  const size_t count = size_t{3} * chunk.vertexCount;
  temporal_.resize(count);
  subtractHistory(values, history, prediction.timeOrder, count, temporal_.data());
  if (prediction.spaceOrder == kNoSpace) {
    residuals_ = temporal_;
    return;
  }
  residuals_.resize(count);
  forEachStrand(def, chunk, temporal_.data(),
                [&](uint32_t* strand, uint32_t vertices, Neighbor neighbor) {
                  subtractPrediction(strand, residuals_.data() + (strand - temporal_.data()),
                                     vertices, neighbor, prediction.spaceOrder);
                });
}

Encoder::Prediction Encoder::choose(const HairCacheDef& def, const Chunk& chunk,
                                    const uint32_t* values, History history, uint8_t maxTimeOrder) {
  Prediction best;
  uint64_t bestCost = UINT64_MAX;
  const Chunk sample = sampleOf(def, chunk);
  // Behind a key frame, a frame is always coded by the one before it.
  for (uint8_t time = maxTimeOrder > 0 ? 1 : 0; time <= maxTimeOrder; ++time) {
    for (uint8_t space = 0; space < kSpaceOrderCount; ++space) {
      predict(def, sample, values, history, {time, space});
      const uint64_t cost = costOf(residuals_);
      if (cost >= bestCost) continue;
      bestCost = cost;
      best = {time, space};
    }
  }
  return best;
}

ChunkHeader Encoder::encode(const HairCacheDef& def, const Chunk& chunk, const uint32_t* values,
                            History history, uint8_t maxTimeOrder, std::vector<std::byte>& out) {
  const Prediction prediction = choose(def, chunk, values, history, maxTimeOrder);
  predict(def, chunk, values, history, prediction);
  ChunkHeader header;
  header.timeOrder = prediction.timeOrder;
  header.spaceOrder = prediction.spaceOrder;
  uint32_t all = 0;
  for (uint32_t& r : residuals_) {
    r = zigzag(r);
    all |= r;
  }
  header.planeCount = static_cast<uint8_t>((std::bit_width(all) + 7) / 8);
  const size_t count = residuals_.size();
  plane_.resize(count);
  for (uint8_t p = 0; p < header.planeCount; ++p) {
    for (size_t i = 0; i < count; ++i) plane_[i] = static_cast<uint8_t>(residuals_[i] >> (8 * p));
    // A plane has its own frame of zstd: its bytes are distributed in another way.
    const size_t at = out.size();
    out.resize(at + ZSTD_compressBound(count));
    const size_t size =
        ZSTD_compress2(context_->zstd, out.data() + at, out.size() - at, plane_.data(), count);
    if (ZSTD_isError(size)) throw std::bad_alloc();  // the only reason that is left
    out.resize(at + size);
    header.byteCount += static_cast<uint32_t>(size);
  }
  return header;
}

struct Decoder::Context {
  Context() : zstd(ZSTD_createDCtx()) {
    if (!zstd) throw std::bad_alloc();
  }
  ~Context() { ZSTD_freeDCtx(zstd); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ZSTD_DCtx* zstd;
};

Decoder::Decoder() : context_(std::make_unique<Context>()) {}
Decoder::~Decoder() = default;

bool Decoder::decode(const HairCacheDef& def, const Chunk& chunk, const ChunkHeader& header,
                     std::span<const std::byte> bytes, const uint32_t* last, uint32_t* values) {
  const size_t count = size_t{3} * chunk.vertexCount;
  residuals_.resize(count);
  uint32_t* residuals = residuals_.data();
  if (header.planeCount == 0) {
    if (!bytes.empty()) return false;
    std::fill(residuals_.begin(), residuals_.end(), 0u);
  } else {
    planes_.resize(header.planeCount * count);
    // As many frames of zstd as there are planes give this number of bytes: no more fit.
    const size_t size = ZSTD_decompressDCtx(context_->zstd, planes_.data(), planes_.size(),
                                            bytes.data(), bytes.size());
    if (ZSTD_isError(size) || size != planes_.size()) return false;
    switch (header.planeCount) {
      case 1:
        joinPlanes<1>(planes_.data(), count, residuals);
        break;
      case 2:
        joinPlanes<2>(planes_.data(), count, residuals);
        break;
      case 3:
        joinPlanes<3>(planes_.data(), count, residuals);
        break;
      default:
        joinPlanes<4>(planes_.data(), count, residuals);
        break;
    }
  }
  if (header.spaceOrder != kNoSpace)
    forEachStrand(def, chunk, residuals,
                  [&](uint32_t* strand, uint32_t vertices, Neighbor neighbor) {
                    addPrediction(strand, vertices, neighbor, header.spaceOrder);
                  });
  if (header.timeOrder == 0) {
    std::copy(residuals, residuals + count, values);
  } else if (header.timeOrder == 1) {
    for (size_t i = 0; i < count; ++i) values[i] = residuals[i] + last[i];
  } else {
    for (size_t i = 0; i < count; ++i) values[i] = residuals[i] + 2 * last[i] - values[i];
  }
  return true;
}

}  // namespace pelage::detail::hair_cache
