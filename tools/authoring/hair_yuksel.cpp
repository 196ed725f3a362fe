// The HAIR format of Cem Yuksel: a header of 128 bytes, then arrays without gaps. Little endian.
// Specification: http://www.cemyuksel.com/research/hairmodels ("HAIR File Format Specification").
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "binary_file.h"
#include "common/errors.h"
#include "pelage/authoring/hair_files.h"

namespace pelage {
namespace {

using tools::fileError;
using tools::readAt;

constexpr uint64_t kHeaderSize = 128, kInfoSize = 88;
constexpr uint64_t kStrandCountAt = 4, kPointCountAt = 8, kArraysAt = 12, kSegmentsAt = 16;
constexpr uint64_t kThicknessAt = 20, kTransparencyAt = 24, kColorAt = 28, kInfoAt = 40;
constexpr uint32_t kMaxSegments = std::numeric_limits<uint16_t>::max();

// Bits of the word at kArraysAt, and the order of the arrays. The last one is an extension that
// LuxCore writes.
enum Array : uint32_t { kSegments, kPoints, kThickness, kTransparency, kColors, kUv, kArrayCount };

struct ArrayFormat {
  const char* name;
  uint64_t elementSize;
};
constexpr ArrayFormat kFormats[kArrayCount] = {{"segments", 2},  {"points", 12},
                                               {"thickness", 4}, {"transparency", 4},
                                               {"colours", 12},  {"UV", 8}};

class YukselReader {
 public:
  YukselReader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : bytes_(bytes), name_(name), report_(report) {}

  Result<HairCurves> read() {
    if (auto r = readHeader(); !r) return r.error();
    if (auto r = readCounts(); !r) return r.error();
    copy(kPoints, curves_.positions);
    readThickness();
    readColors();
    if (has(kUv)) copy(kUv, curves_.vertexUv);
    return std::move(curves_);
  }

 private:
  bool has(Array array) const { return (arrays_ >> array & 1) != 0; }

  Result<void> readHeader() {
    if (bytes_.size() < kHeaderSize)
      return fileError(name_, bytes_.size(), "the file ends inside the 128-byte header");
    if (std::memcmp(bytes_.data(), "HAIR", 4) != 0)
      return fileError(name_, 0, "the file does not start with \"HAIR\"; is it a .hair file?");
    strandCount_ = readAt<uint32_t>(bytes_, kStrandCountAt);
    pointCount_ = readAt<uint32_t>(bytes_, kPointCountAt);
    arrays_ = readAt<uint32_t>(bytes_, kArraysAt);
    if (strandCount_ == 0) return fileError(name_, kStrandCountAt, "the file has no strands");
    if (arrays_ >> kArrayCount != 0)
      return fileError(name_, kArraysAt,
                       fmt::format("the bits {:#x} stand for arrays that this reader does not know",
                                   arrays_ >> kArrayCount << kArrayCount));
    if (!has(kPoints)) return fileError(name_, kArraysAt, "the file has no points (bit 1)");

    uint64_t at = kHeaderSize;
    for (uint32_t i = 0; i < kArrayCount; ++i) {
      offsets_[i] = at;
      if (!has(static_cast<Array>(i))) continue;
      const uint64_t count = i == kSegments ? strandCount_ : pointCount_;
      at += count * kFormats[i].elementSize;
      if (at > bytes_.size())
        return fileError(name_, bytes_.size(),
                         fmt::format("the {} of {} strands with {} points need bytes {} to {}, "
                                     "but the file ends here",
                                     kFormats[i].name, strandCount_, pointCount_, offsets_[i], at));
    }
    if (at < bytes_.size())
      report_.notes.push_back(
          fmt::format("{} bytes behind the arrays are ignored", bytes_.size() - at));
    return {};
  }

  Result<void> readCounts() {
    if (!has(kSegments)) {
      const uint64_t segments = readAt<uint32_t>(bytes_, kSegmentsAt);
      // At most 2^32 x (2^32 + 1).
      if (segments >= pointCount_ || strandCount_ * (segments + 1) != pointCount_)
        return fileError(name_, kPointCountAt,
                         fmt::format("{} strands of {} segments do not have {} points",
                                     strandCount_, segments, pointCount_));
      curves_.vertexCounts.assign(strandCount_, static_cast<uint32_t>(segments + 1));
      return {};
    }
    curves_.vertexCounts.reserve(strandCount_);
    uint64_t sum = 0;
    for (uint64_t i = 0; i < strandCount_; ++i) {
      const uint32_t count = readAt<uint16_t>(bytes_, offsets_[kSegments] + i * 2) + 1u;
      sum += count;
      curves_.vertexCounts.push_back(count);
    }
    if (sum != pointCount_)
      return fileError(name_, kPointCountAt,
                       fmt::format("{} points, but the segments of the {} strands need {}",
                                   pointCount_, strandCount_, sum));
    return {};
  }

  template <class T>
  void copy(Array array, std::vector<T>& out) {
    const uint64_t count = array == kSegments ? strandCount_ : pointCount_;
    out.resize(count);
    std::memcpy(static_cast<void*>(out.data()), bytes_.data() + offsets_[array], count * sizeof(T));
  }

  // Thickness 1, opaque and white in a header stand for "none": the format's own library writes
  // them where nothing was set.
  void readThickness() {
    if (has(kThickness)) {
      copy(kThickness, curves_.radii);
      for (float& radius : curves_.radii) radius *= 0.5f;
      return;
    }
    const auto thickness = readAt<float>(bytes_, kThicknessAt);
    if (thickness == 1) return;
    if (thickness > 0 && std::isfinite(thickness))
      curves_.radii.assign(pointCount_, 0.5f * thickness);
    else
      report_.notes.push_back(
          fmt::format("the thickness {} of all strands is not kept: it is not above 0", thickness));
  }

  void readColors() {
    const auto color = readAt<Float3>(bytes_, kColorAt);
    const auto transparency = readAt<float>(bytes_, kTransparencyAt);
    if (!has(kColors) && !has(kTransparency)) {
      if (color == Float3{1, 1, 1} && transparency == 0) return;
      const auto isShare = [](float value) { return value >= 0 && value <= 1; };
      if (!isShare(color.x) || !isShare(color.y) || !isShare(color.z) || !isShare(transparency)) {
        report_.notes.push_back(
            fmt::format("the color {} {} {} and the transparency {} of all strands are not kept: "
                        "they are not 0 to 1",
                        color.x, color.y, color.z, transparency));
        return;
      }
    }
    curves_.colors.assign(pointCount_, {color.x, color.y, color.z, 1 - transparency});
    for (uint64_t i = 0; i < pointCount_; ++i) {
      if (has(kColors)) {
        const auto c = readAt<Float3>(bytes_, offsets_[kColors] + i * sizeof(Float3));
        curves_.colors[i] = {c.x, c.y, c.z, curves_.colors[i].w};
      }
      if (has(kTransparency))
        curves_.colors[i].w =
            1 - readAt<float>(bytes_, offsets_[kTransparency] + i * sizeof(float));
    }
  }

  std::span<const std::byte> bytes_;
  std::string_view name_;
  HairFileReport& report_;
  uint64_t strandCount_ = 0, pointCount_ = 0;
  uint32_t arrays_ = 0;
  uint64_t offsets_[kArrayCount] = {};
  HairCurves curves_;
};

template <class T>
void appendAll(std::vector<std::byte>& bytes, const std::vector<T>& values) {
  const auto data = std::as_bytes(std::span(values));
  bytes.insert(bytes.end(), data.begin(), data.end());
}

Result<std::vector<std::byte>> writeYuksel(const HairCurves& curves) {
  if (auto r = validate(curves); !r) return r.error();
  const auto refuse = [](std::string what) {
    return Error{ErrorCode::kInvalidArgument, "a .hair file: " + std::move(what)};
  };
  if (curves.vertexCounts.empty()) return refuse("there are no curves");
  if (curves.positions.size() > std::numeric_limits<uint32_t>::max())
    return refuse("more than 2^32 - 1 vertices; split the groom");
  const auto [fewest, most] =
      std::minmax_element(curves.vertexCounts.begin(), curves.vertexCounts.end());
  if (*most > kMaxSegments + 1)
    return refuse(fmt::format("a curve of {} vertices; it can have 65536", *most));

  uint32_t arrays = 1u << kPoints;
  if (*fewest != *most) arrays |= 1u << kSegments;
  if (!curves.radii.empty()) arrays |= 1u << kThickness;
  const bool opaque = std::all_of(curves.colors.begin(), curves.colors.end(),
                                  [](const Float4& color) { return color.w == 1; });
  if (!opaque) arrays |= 1u << kTransparency;
  if (!curves.colors.empty()) arrays |= 1u << kColors;
  if (!curves.vertexUv.empty()) arrays |= 1u << kUv;

  std::vector<std::byte> bytes;
  for (const char c : std::string_view("HAIR")) bytes.push_back(static_cast<std::byte>(c));
  tools::append(bytes, curves.curveCount());
  tools::append(bytes, static_cast<uint32_t>(curves.positions.size()));
  tools::append(bytes, arrays);
  tools::append(bytes, *most - 1);
  // Defaults of arrays that are not there: thickness 1, opaque, white.
  for (const float value : {1.0f, 0.0f, 1.0f, 1.0f, 1.0f}) tools::append(bytes, value);
  constexpr std::string_view kInfo = "written by pelage";
  static_assert(kInfo.size() < kInfoSize && kInfoAt + kInfoSize == kHeaderSize);
  for (const char c : kInfo) bytes.push_back(static_cast<std::byte>(c));
  bytes.resize(kHeaderSize);

  if ((arrays >> kSegments & 1) != 0)
    for (const uint32_t count : curves.vertexCounts)
      tools::append(bytes, static_cast<uint16_t>(count - 1));
  appendAll(bytes, curves.positions);
  for (const float radius : curves.radii) tools::append(bytes, 2 * radius);
  if (!opaque)
    for (const Float4& color : curves.colors) tools::append(bytes, 1 - color.w);
  for (const Float4& color : curves.colors) tools::append(bytes, Float3{color.x, color.y, color.z});
  appendAll(bytes, curves.vertexUv);
  return bytes;
}

}  // namespace

Result<HairCurves> loadYukselHair(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kHair, "HAIR", bytes.size(), {}};
    auto curves = YukselReader(bytes, name, found).read();
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

Result<std::vector<std::byte>> saveYukselHair(const HairCurves& curves) {
  return tools::guarded([&] { return writeYuksel(curves); });
}

Result<void> saveYukselHair(const HairCurves& curves, const std::filesystem::path& path) {
  return tools::guarded([&]() -> Result<void> {
    auto bytes = writeYuksel(curves);
    if (!bytes) return bytes.error();
    return tools::writeFile(path, *bytes);
  });
}

}  // namespace pelage
