#include "pelage/sdf_collider.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>

#include "base/file_io.h"
#include "base/finite.h"
#include "base/guard.h"
#include "pelage/constants.h"

namespace pelage {
namespace {

constexpr uint32_t kSdfMagic = 0x46445350;  // "PSDF"
constexpr uint32_t kSdfVersion = 1;
constexpr uint64_t kWordsAnElement = 4;
constexpr uint64_t kWordsARecord = kWordsAnElement * sdf::kSdfStillRecord;
constexpr uint64_t kNeighborWord = kWordsAnElement * sdf::kSdfNeighbors;
constexpr uint64_t kMaxFileNodes = uint64_t{1} << 30;

struct SdfHeader {
  uint32_t magic = kSdfMagic;
  uint32_t version = kSdfVersion;
  Float3 origin = {};
  float cellSize = 0;
  std::array<uint32_t, 3> nodes = {};
  float band = 0;
  float farRange = 0;
  uint32_t triangleBits = 0;
  uint32_t triangleCount = 0;
};
static_assert(sizeof(SdfHeader) == 52);

uint64_t nodeCount(const std::array<uint32_t, 3>& nodes) {
  // No product of three numbers below 2^21 overflows.
  for (const uint32_t n : nodes)
    if (n == 0 || n >= (1u << 21)) return 0;
  const uint64_t count = uint64_t{nodes[0]} * nodes[1] * nodes[2];
  return count <= kMaxFileNodes ? count : 0;
}

// Returns the error of a header, or nothing.
std::string faultOf(const SdfHeader& h) {
  if (nodeCount(h.nodes) == 0 || h.nodes[0] % 4 != 0)
    return "the grid of " + std::to_string(h.nodes[0]) + " x " + std::to_string(h.nodes[1]) +
           " x " + std::to_string(h.nodes[2]) + " nodes is none that pelage makes";
  if (!detail::isFinite(h.origin) || !std::isfinite(h.farRange) || !(h.cellSize > 0) ||
      !std::isfinite(h.cellSize) || !(h.band >= 1 && h.band <= 8) || !(h.farRange >= 0))
    return "the origin, the cell size, the band or the depth is out of range";
  if (h.triangleBits < 1 || h.triangleBits > 29 || h.triangleCount >= (1u << h.triangleBits))
    return std::to_string(h.triangleCount) + " triangles do not fit " +
           std::to_string(h.triangleBits) + " bits";
  return {};
}

Result<void> save(const SdfData& data, const std::filesystem::path& path) {
  const SdfHeader header = {.origin = data.grid.origin,
                            .cellSize = data.grid.cellSize,
                            .nodes = data.grid.nodes,
                            .band = data.band,
                            .farRange = data.farRange,
                            .triangleBits = data.triangleBits,
                            .triangleCount = data.triangleCount};
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "field for " + path.string() + ": " + what};
  };
  if (const std::string fault = faultOf(header); !fault.empty()) return refuse(fault);
  if (data.keys.size() != nodeCount(header.nodes) ||
      data.surface.size() != kWordsARecord * data.triangleCount)
    return refuse("has another number of keys or records than nodes or triangles");
  std::vector<std::byte> bytes;
  detail::append(bytes, header);
  for (const std::vector<uint32_t>* words : {&data.keys, &data.surface}) {
    const auto part = std::as_bytes(std::span(*words));
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  return detail::writeFile(path, bytes);
}

Result<SdfData> load(std::span<const std::byte> bytes, std::string_view name) {
  if (bytes.size() < sizeof(SdfHeader))
    return detail::fileError(name, bytes.size(), "ends within the header; is it a .psdf file?");
  const auto header = detail::readAt<SdfHeader>(bytes, 0);
  if (header.magic != kSdfMagic) return detail::fileError(name, 0, "is no .psdf file");
  if (header.version != kSdfVersion) {
    return detail::fileError(name, 4,
                             "has version " + std::to_string(header.version) +
                                 ", but this library reads " + std::to_string(kSdfVersion) +
                                 "; save the field again");
  }
  if (const std::string fault = faultOf(header); !fault.empty())
    return detail::fileError(name, offsetof(SdfHeader, origin), fault);
  const uint64_t keyBytes = nodeCount(header.nodes) * sizeof(uint32_t);
  const uint64_t recordBytes = kWordsARecord * header.triangleCount * sizeof(uint32_t);
  const uint64_t size = sizeof(SdfHeader) + keyBytes + recordBytes;
  if (bytes.size() != size) {
    return detail::fileError(name, std::min<uint64_t>(bytes.size(), size),
                             "has " + std::to_string(bytes.size()) +
                                 " bytes, but its header asks for " + std::to_string(size));
  }
  SdfData data;
  data.grid = {.origin = header.origin, .cellSize = header.cellSize, .nodes = header.nodes};
  data.band = header.band;
  data.farRange = header.farRange;
  data.triangleBits = header.triangleBits;
  data.triangleCount = header.triangleCount;
  data.keys.resize(keyBytes / sizeof(uint32_t));
  data.surface.resize(recordBytes / sizeof(uint32_t));
  std::memcpy(data.keys.data(), bytes.data() + sizeof(SdfHeader), keyBytes);
  if (recordBytes > 0)
    std::memcpy(data.surface.data(), bytes.data() + sizeof(SdfHeader) + keyBytes, recordBytes);

  const uint32_t mask = (1u << header.triangleBits) - 1;
  for (size_t i = 0; i < data.keys.size(); ++i) {
    const uint32_t key = data.keys[i] & sdf_key::kSdfUnset;
    // Inside, all bits set are no triangle.
    const bool none = key != data.keys[i] && (key & mask) == mask;
    if (key != sdf_key::kSdfUnset && !none && (key & mask) >= data.triangleCount) {
      return detail::fileError(name, sizeof(SdfHeader) + i * sizeof(uint32_t),
                               "node " + std::to_string(i) + " refers to triangle " +
                                   std::to_string(key & mask) + " of " +
                                   std::to_string(data.triangleCount));
    }
  }
  for (size_t t = 0; t < data.triangleCount; ++t) {
    for (size_t edge = 0; edge < 3; ++edge) {
      const size_t word = t * kWordsARecord + kNeighborWord + edge;
      const uint32_t neighbor = data.surface[word];
      if (neighbor != sdf::kSdfNone && neighbor >= data.triangleCount) {
        return detail::fileError(name, sizeof(SdfHeader) + keyBytes + word * sizeof(uint32_t),
                                 "triangle " + std::to_string(t) + " has triangle " +
                                     std::to_string(neighbor) + " of " +
                                     std::to_string(data.triangleCount) + " beside it");
      }
    }
  }
  return data;
}

}  // namespace

Result<void> saveSdf(const SdfData& data, const std::filesystem::path& path) {
  return detail::guarded([&] { return save(data, path); });
}

Result<SdfData> loadSdf(std::span<const std::byte> bytes, std::string_view name) {
  return detail::guarded([&] { return load(bytes, name); });
}

Result<SdfData> loadSdf(ByteSource& source, std::string_view name) {
  auto bytes = readAll(source, name);
  if (!bytes) return bytes.error();
  return loadSdf(*bytes, name);
}

Result<SdfData> loadSdf(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<SdfData> {
    auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return load(*bytes, path.string());
  });
}

}  // namespace pelage
