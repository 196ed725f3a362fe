// The .tfx file: header, then arrays at the offsets that the header gives. Little endian.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "assets/groom.h"
#include "assets/tfx_layout.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/stream_reader.h"
#include "pelage/hair_asset.h"

namespace pelage {
namespace {

using detail::fileError;
using detail::isCoordinate;
using detail::readAt;
using detail::StreamReader;

constexpr float kTfxVersion = 4.0f;
constexpr uint64_t kTfxHeaderSize = 160;
constexpr uint64_t kStrandCountAt = 4, kVertexCountAt = 8, kOffsetsAt = 12, kTfxReservedAt = 32;

enum Array { kPositions, kStrandUv, kVertexUv, kStrandThickness, kVertexColor, kArrayCount };

struct ArrayFormat {
  const char* name;
  uint64_t elementSize;
  bool perVertex;
};
constexpr std::array<ArrayFormat, kArrayCount> kArrayFormats = {{
    {"positions", sizeof(Float4), true},
    {"strand UV", sizeof(Float2), false},
    {"vertex UV", sizeof(Float2), true},
    {"strand thickness", sizeof(float), false},
    {"vertex colors", sizeof(Float4), true},
}};

// Counts are at most 2^32 and 2^8, elements 16 bytes: 64 bits do not overflow.
uint64_t arraySize(int array, uint64_t strandCount, uint64_t verticesPerStrand) {
  const ArrayFormat& format = kArrayFormats[static_cast<size_t>(array)];
  return strandCount * (format.perVertex ? verticesPerStrand : 1) * format.elementSize;
}

struct Section {
  uint64_t begin, end;
  int array;  // -1: header
};

// The header and the arrays in the file, ascending.
std::vector<Section> sectionsOf(const uint32_t (&offsets)[kArrayCount], uint64_t strandCount,
                                uint64_t verticesPerStrand) {
  std::vector<Section> sections = {{0, kTfxHeaderSize, -1}};
  for (int i = 0; i < kArrayCount; ++i)
    if (offsets[i] != 0)
      sections.push_back(
          {offsets[i], offsets[i] + arraySize(i, strandCount, verticesPerStrand), i});
  std::sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) {
    return std::pair(a.begin, a.array) < std::pair(b.begin, b.array);
  });
  return sections;
}

bool isPosition(const Float4& p) {
  return isCoordinate(p.x) && isCoordinate(p.y) && isCoordinate(p.z);
}

// Reads the arrays and checks their values.
class ValueReader {
 public:
  ValueReader(StreamReader& stream, const HairAsset& asset, const TfxLoadOptions& options)
      : stream_(stream), asset_(asset), options_(options) {}

  Result<void> readPositions(std::vector<Float4>& out) {
    const uint64_t offset = asset_.fileLayout.offsets[kPositions];
    const uint32_t vertexCount = asset_.verticesPerStrand;
    if (auto r = fetch(kPositions, out); !r) return r;
    for (uint64_t strand = 0; strand < asset_.strandCount; ++strand) {
      Float4* vertices = out.data() + strand * vertexCount;
      const uint64_t strandOffset = offset + strand * vertexCount * sizeof(Float4);
      uint32_t firstGood = 0;
      while (firstGood < vertexCount && !isPosition(vertices[firstGood])) ++firstGood;
      if (firstGood == vertexCount && options_.repair)
        return fileError(stream_.name(), strandOffset,
                         fmt::format("strand {} has no vertex with a usable position; remove the "
                                     "strand",
                                     strand));
      for (uint32_t i = 0; i < vertexCount; ++i) {
        Float4& vertex = vertices[i];
        const uint64_t vertexOffset = strandOffset + i * sizeof(Float4);
        if (!isPosition(vertex)) {
          const float worst = !isCoordinate(vertex.x)   ? vertex.x
                              : !isCoordinate(vertex.y) ? vertex.y
                                                        : vertex.z;
          const uint64_t component = !isCoordinate(vertex.x) ? 0 : !isCoordinate(vertex.y) ? 1 : 2;
          if (!options_.repair)
            return refuse(vertexOffset + component * sizeof(float), "position", strand, i, worst,
                          "finite and within +-1e6 m");
          repaired(vertexOffset + component * sizeof(float));
          const Float4& good = i > firstGood ? vertices[i - 1] : vertices[firstGood];
          vertex = {good.x, good.y, good.z, vertex.w};
        }
        if (!std::isfinite(vertex.w) || vertex.w < 0) {
          if (!options_.repair)
            return refuse(vertexOffset + 3 * sizeof(float), "inverse mass", strand, i, vertex.w,
                          "finite and not negative");
          repaired(vertexOffset + 3 * sizeof(float));
          vertex.w = i < 2 ? 0.0f : 1.0f;
        }
      }
    }
    return {};
  }

  // An array of `components` floats an element; each must be in [lowest, highest].
  template <class T>
  Result<void> read(Array array, std::vector<T>& out, float lowest, float highest,
                    const char* allowed, float replacement) {
    const uint64_t offset = asset_.fileLayout.offsets[array];
    if (offset == 0) return {};
    if (auto r = fetch(array, out); !r) return r;
    constexpr uint64_t kComponents = sizeof(T) / sizeof(float);
    const ArrayFormat& format = kArrayFormats[array];
    const uint64_t perStrand = format.perVertex ? asset_.verticesPerStrand : 1;
    for (uint64_t i = 0; i < out.size(); ++i) {
      std::array<float, kComponents> values;
      std::memcpy(values.data(), &out[i], sizeof(T));
      bool changed = false;
      for (uint64_t c = 0; c < kComponents; ++c) {
        if (values[c] >= lowest && values[c] <= highest) continue;
        const uint64_t at = offset + i * sizeof(T) + c * sizeof(float);
        if (!options_.repair)
          return refuse(at, format.name, i / perStrand, static_cast<uint32_t>(i % perStrand),
                        values[c], allowed);
        repaired(at);
        values[c] = replacement;
        changed = true;
      }
      if (changed) std::memcpy(static_cast<void*>(&out[i]), values.data(), sizeof(T));
    }
    return {};
  }

  TfxLoadReport report() const { return report_; }

 private:
  // The elements of the asset's strands; the file may have more.
  template <class T>
  Result<void> fetch(Array array, std::vector<T>& out) {
    const uint64_t size = arraySize(array, asset_.strandCount, asset_.verticesPerStrand);
    return stream_.readArray(asset_.fileLayout.offsets[array], size / sizeof(T), out);
  }

  Error refuse(uint64_t offset, const char* what, uint64_t strand, uint32_t vertex, float value,
               const char* allowed) const {
    return fileError(stream_.name(), offset,
                     fmt::format("{} of strand {}, vertex {} is {}; it must be {} "
                                 "(TfxLoadOptions::repair replaces such values)",
                                 what, strand, vertex, value, allowed));
  }

  void repaired(uint64_t offset) {
    if (report_.repairedCount == 0) report_.firstRepairOffset = offset;
    ++report_.repairedCount;
  }

  StreamReader& stream_;
  const HairAsset& asset_;
  const TfxLoadOptions& options_;
  TfxLoadReport report_;
};

// The header, checked against the size of the file; no arrays yet.
Result<HairAsset> readHeader(StreamReader& stream) {
  const std::string_view name = stream.name();
  if (stream.size() < kTfxHeaderSize)
    return fileError(
        name, stream.size(),
        "the file ends inside the 160-byte header; pelage-convert groom converts older "
        "versions, and other files with hair");
  std::array<std::byte, kTfxHeaderSize> bytes;
  if (auto r = stream.read(0, bytes); !r) return r.error();
  const float version = readAt<float>(bytes, 0);
  if (version != kTfxVersion)
    return fileError(
        name, 0,
        fmt::format("the version is {}; only 4.0 can be read; pelage-convert groom converts "
                    "older versions, and other files with hair",
                    version));
  HairAsset asset;
  asset.strandCount = readAt<uint32_t>(bytes, kStrandCountAt);
  asset.verticesPerStrand = readAt<uint32_t>(bytes, kVertexCountAt);
  if (asset.strandCount == 0) return fileError(name, kStrandCountAt, "the file has no strands");
  if (asset.verticesPerStrand < kMinVerticesPerStrand ||
      asset.verticesPerStrand > kMaxVerticesPerStrand)
    return fileError(
        name, kVertexCountAt,
        fmt::format("{} vertices a strand; it must be 2 to 256", asset.verticesPerStrand));

  TfxFileLayout& layout = asset.fileLayout;
  layout.strandCount = asset.strandCount;
  layout.verticesPerStrand = asset.verticesPerStrand;
  layout.fileSize = stream.size();
  std::memcpy(layout.reserved, bytes.data() + kTfxReservedAt, sizeof(layout.reserved));
  std::memcpy(layout.offsets, bytes.data() + kOffsetsAt, sizeof(layout.offsets));
  if (layout.offsets[kPositions] == 0)
    return fileError(name, kOffsetsAt, "the file has no positions (their offset is 0)");
  for (uint64_t i = 0; i < kArrayCount; ++i) {
    const uint64_t begin = layout.offsets[i];
    const uint64_t size =
        arraySize(static_cast<int>(i), asset.strandCount, asset.verticesPerStrand);
    if (begin == 0 || begin + size <= stream.size()) continue;
    return fileError(name, kOffsetsAt + i * sizeof(uint32_t),
                     fmt::format("the {} of {} strands x {} vertices need bytes {} to {}, but the "
                                 "file ends at byte {}",
                                 kArrayFormats[i].name, asset.strandCount, asset.verticesPerStrand,
                                 begin, begin + size, stream.size()));
  }
  return asset;
}

// Reads the bytes between the arrays. Errors: overlapping arrays, and reading, if they are wanted.
Result<void> readExtras(StreamReader& stream, bool wanted, HairAsset& asset) {
  TfxFileLayout& layout = asset.fileLayout;
  const std::vector<Section> sections =
      sectionsOf(layout.offsets, asset.strandCount, asset.verticesPerStrand);
  for (size_t i = 0; i < sections.size(); ++i) {
    const uint64_t next = i + 1 < sections.size() ? sections[i + 1].begin : stream.size();
    if (next < sections[i].end) {
      const auto later = static_cast<size_t>(sections[i + 1].array);
      const int earlier = sections[i].array;
      return fileError(
          stream.name(), kOffsetsAt + later * sizeof(uint32_t),
          fmt::format("the {} at byte {} overlap the {}", kArrayFormats[later].name,
                      layout.offsets[later],
                      earlier < 0 ? "header" : kArrayFormats[static_cast<size_t>(earlier)].name));
    }
    if (next == sections[i].end || !wanted) continue;
    TfxFileLayout::Extra extra{.offset = sections[i].end, .bytes = {}};
    if (auto r = stream.readArray(extra.offset, next - sections[i].end, extra.bytes); !r) return r;
    layout.extras.push_back(std::move(extra));
  }
  return {};
}

Result<HairAsset> load(StreamReader& stream, const TfxLoadOptions& options, TfxLoadReport* report) {
  if (report != nullptr) *report = {};
  if (options.maxStrands == 0)
    return Error{ErrorCode::kInvalidArgument, "TfxLoadOptions::maxStrands is 0"};
  auto header = readHeader(stream);
  if (!header) return header;
  HairAsset& asset = *header;
  TfxFileLayout& layout = asset.fileLayout;
  const bool wanted[kArrayCount] = {true, options.strandUv, options.vertexUv,
                                    options.strandThickness, options.vertexColor};
  bool whole = options.maxStrands >= asset.strandCount;
  for (size_t i = 0; i < kArrayCount; ++i) whole = whole && (wanted[i] || layout.offsets[i] == 0);
  if (auto r = readExtras(stream, whole, asset); !r) return r.error();
  asset.strandCount = std::min(asset.strandCount, options.maxStrands);
  for (size_t i = 0; i < kArrayCount; ++i)
    if (!wanted[i]) layout.offsets[i] = 0;

  constexpr float kMax = std::numeric_limits<float>::max();
  ValueReader reader(stream, asset, options);
  if (auto r = reader.readPositions(asset.positions); !r) return r.error();
  if (auto r = reader.read(kStrandUv, asset.strandUv, -kMax, kMax, "finite", 0); !r)
    return r.error();
  if (auto r = reader.read(kVertexUv, asset.vertexUv, -kMax, kMax, "finite", 0); !r)
    return r.error();
  if (auto r =
          reader.read(kStrandThickness, asset.strandThickness, 0, kMaxCoordinate, "0 to 1e6", 1);
      !r)
    return r.error();
  if (auto r = reader.read(kVertexColor, asset.vertexColor, -kMax, kMax, "finite", 0); !r)
    return r.error();
  if (!whole) {
    // A part of a file is saved as its own file.
    TfxFileLayout part;
    std::copy(std::begin(layout.reserved), std::end(layout.reserved), part.reserved);
    layout = std::move(part);
  }
  if (report != nullptr) *report = reader.report();
  return header;
}

struct ArrayBytes {
  const void* data;
  uint64_t size;
};

std::array<ArrayBytes, kArrayCount> arraysOf(const HairAsset& asset) {
  const auto bytesOf = [](const auto& v) { return ArrayBytes{v.data(), v.size() * sizeof(v[0])}; };
  return {bytesOf(asset.positions), bytesOf(asset.strandUv), bytesOf(asset.vertexUv),
          bytesOf(asset.strandThickness), bytesOf(asset.vertexColor)};
}

Result<std::vector<std::byte>> save(const HairAsset& asset) {
  if (auto r = validate(asset); !r) return r.error();
  const auto arrays = arraysOf(asset);
  TfxFileLayout fresh;
  const bool keep = detail::tfxLayoutFits(asset);
  if (!keep) {
    fresh.fileSize = kTfxHeaderSize;
    for (size_t i = 0; i < kArrayCount; ++i) {
      if (arrays[i].size == 0) continue;
      if (fresh.fileSize > std::numeric_limits<uint32_t>::max())
        return Error{
            ErrorCode::kInvalidArgument,
            fmt::format("the {} would start beyond 4 GB, which a .tfx file cannot express; "
                        "split the groom",
                        kArrayFormats[i].name)};
      fresh.offsets[i] = static_cast<uint32_t>(fresh.fileSize);
      fresh.fileSize += arrays[i].size;
    }
    std::copy(std::begin(asset.fileLayout.reserved), std::end(asset.fileLayout.reserved),
              fresh.reserved);
  }
  const TfxFileLayout& layout = keep ? asset.fileLayout : fresh;
  std::vector<std::byte> bytes(layout.fileSize);
  std::memcpy(bytes.data(), &kTfxVersion, sizeof(kTfxVersion));
  std::memcpy(bytes.data() + kStrandCountAt, &asset.strandCount, sizeof(uint32_t));
  std::memcpy(bytes.data() + kVertexCountAt, &asset.verticesPerStrand, sizeof(uint32_t));
  std::memcpy(bytes.data() + kOffsetsAt, layout.offsets, sizeof(layout.offsets));
  std::memcpy(bytes.data() + kTfxReservedAt, layout.reserved, sizeof(layout.reserved));
  for (const TfxFileLayout::Extra& extra : layout.extras)
    std::copy(extra.bytes.begin(), extra.bytes.end(),
              bytes.begin() + static_cast<std::ptrdiff_t>(extra.offset));
  for (size_t i = 0; i < kArrayCount; ++i)
    if (arrays[i].size != 0)
      std::memcpy(bytes.data() + layout.offsets[i], arrays[i].data, arrays[i].size);
  return bytes;
}

}  // namespace

bool detail::tfxLayoutFits(const HairAsset& asset) {
  const TfxFileLayout& layout = asset.fileLayout;
  if (layout.fileSize < kTfxHeaderSize || layout.strandCount != asset.strandCount ||
      layout.verticesPerStrand != asset.verticesPerStrand)
    return false;
  const auto arrays = arraysOf(asset);
  uint64_t covered = kTfxHeaderSize;
  for (size_t i = 0; i < kArrayCount; ++i) {
    if ((layout.offsets[i] != 0) != (arrays[i].size != 0)) return false;
    if (layout.offsets[i] + arrays[i].size > layout.fileSize) return false;
    covered += arrays[i].size;
  }
  for (const TfxFileLayout::Extra& extra : layout.extras) {
    if (extra.offset > layout.fileSize || extra.bytes.size() > layout.fileSize - extra.offset)
      return false;
    covered += extra.bytes.size();
  }
  return layout.fileSize <= covered;
}

Result<HairAsset> loadTfx(ByteSource& source, std::string_view name, const TfxLoadOptions& options,
                          TfxLoadReport* report) {
  return detail::guarded([&] {
    StreamReader stream(source, name);
    return load(stream, options, report);
  });
}

Result<HairAsset> loadTfx(std::span<const std::byte> bytes, std::string_view name,
                          const TfxLoadOptions& options, TfxLoadReport* report) {
  MemorySource source(bytes);
  return loadTfx(source, name, options, report);
}

Result<HairAsset> loadTfx(const std::filesystem::path& path, const TfxLoadOptions& options,
                          TfxLoadReport* report) {
  return detail::guarded([&]() -> Result<HairAsset> {
    auto file = FileSource::open(path);
    if (!file) return file.error();
    return loadTfx(*file, path.string(), options, report);
  });
}

Result<std::vector<std::byte>> saveTfx(const HairAsset& asset) {
  return detail::guarded([&] { return save(asset); });
}

Result<void> saveTfx(const HairAsset& asset, const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    auto bytes = save(asset);
    if (!bytes) return bytes.error();
    return detail::writeFile(path, *bytes);
  });
}

}  // namespace pelage
