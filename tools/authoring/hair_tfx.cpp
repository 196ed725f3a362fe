// .tfx as curves: the versions of TressFX that are known. Layouts: of 4.0 see
// runtime/core/assets/tfx.cpp; of 3.0 the header TressFXFileFormat.h and the Maya exporter of
// TressFX 3.1; of the text of TressFX 1 and 2 the files that its tools wrote.
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "binary_file.h"
#include "common/errors.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/hair_asset.h"
#include "text_lines.h"

namespace pelage {
namespace {

using detail::clip;
using detail::TextLines;
using tools::fileError;
using tools::readAt;

// The first two vertices of a strand follow the skin, as do the last two when both ends are fixed.
void addMasses(HairCurves& curves, bool bothEndsImmovable) {
  if (!bothEndsImmovable) return;
  for (const uint32_t count : curves.vertexCounts)
    for (uint32_t i = 0; i < count; ++i)
      curves.inverseMasses.push_back(i < 2 || i + 2 >= count ? 0.0f : 1.0f);
}

// Strands of a file of version 4.0 without a vertex that is within kMaxCoordinate. None when the
// positions are not where the header says: loadTfx() reports that.
std::vector<uint32_t> strandsWithoutPositions(std::span<const std::byte> bytes) {
  constexpr uint64_t kHeaderSize = 160;
  if (bytes.size() < kHeaderSize) return {};
  const auto strandCount = readAt<uint32_t>(bytes, 4), vertexCount = readAt<uint32_t>(bytes, 8);
  const uint64_t begin = readAt<uint32_t>(bytes, 12);
  if (begin < kHeaderSize || vertexCount < kMinVerticesPerStrand ||
      vertexCount > kMaxVerticesPerStrand ||
      begin + uint64_t{strandCount} * vertexCount * sizeof(Float4) > bytes.size())
    return {};
  const auto isUsable = [](const Float4& p) {  // false for NaN
    return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
           std::abs(p.z) <= kMaxCoordinate;
  };
  std::vector<uint32_t> strands;
  uint64_t at = begin;
  for (uint32_t strand = 0; strand < strandCount; ++strand) {
    bool usable = false;
    for (uint32_t i = 0; i < vertexCount; ++i, at += sizeof(Float4))
      usable = usable || isUsable(readAt<Float4>(bytes, at));
    if (!usable) strands.push_back(strand);
  }
  return strands;
}

Result<HairCurves> readBinary4(std::span<const std::byte> bytes, std::string_view name,
                               HairFileReport& report) {
  report.format = "TressFX 4.0";
  // Repairing has no place to put a strand without any usable position: such strands are kept from
  // it, and get back what no reader of curves can use.
  const std::vector<uint32_t> unusable = strandsWithoutPositions(bytes);
  std::vector<std::byte> patched;
  if (!unusable.empty()) {
    patched.assign(bytes.begin(), bytes.end());
    const auto vertexCount = readAt<uint32_t>(bytes, 8);
    const uint64_t size = uint64_t{vertexCount} * sizeof(Float4);
    for (const uint32_t strand : unusable)
      std::fill_n(patched.begin() +
                      static_cast<std::ptrdiff_t>(readAt<uint32_t>(bytes, 12) + strand * size),
                  size, std::byte{0});
    bytes = patched;
  }
  TfxLoadReport loaded;
  auto asset = loadTfx(bytes, name, {.repair = true}, &loaded);
  if (!asset) return asset.error();
  if (loaded.repairedCount > 0)
    report.notes.push_back(
        fmt::format("{} values that were no usable numbers were replaced, the "
                    "first at byte {}",
                    loaded.repairedCount, loaded.firstRepairOffset));
  HairCurves curves;
  curves.vertexCounts.assign(asset->strandCount, asset->verticesPerStrand);
  for (const Float4& p : asset->positions) {
    curves.positions.push_back({p.x, p.y, p.z});
    curves.inverseMasses.push_back(p.w);
  }
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const uint32_t strand : unusable)
    std::fill_n(curves.positions.begin() + std::ptrdiff_t{strand} * asset->verticesPerStrand,
                asset->verticesPerStrand, Float3{kNaN, kNaN, kNaN});
  for (const float thickness : asset->strandThickness)
    curves.radii.insert(curves.radii.end(), asset->verticesPerStrand, thickness * kUnitFiberRadius);
  curves.colors = std::move(asset->vertexColor);
  curves.vertexUv = std::move(asset->vertexUv);
  curves.strandUv = std::move(asset->strandUv);
  return curves;
}

class Binary3Reader {
 public:
  Binary3Reader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : bytes_(bytes), name_(name), report_(report) {}

  Result<HairCurves> read() {
    report_.format = "TressFX 3.0";
    if (bytes_.size() < kHeaderSize)
      return fileError(name_, bytes_.size(), "the file ends inside the 296-byte header of 3.0");
    strandCount_ = readAt<uint32_t>(bytes_, 4);
    vertexCount_ = readAt<uint32_t>(bytes_, 8);
    if (strandCount_ == 0) return fileError(name_, 4, "the file has no strands");
    if (vertexCount_ < kMinVerticesPerStrand || vertexCount_ > kMaxVerticesPerStrand)
      return fileError(name_, 8,
                       fmt::format("{} vertices a strand; it must be 2 to 256", vertexCount_));
    const uint64_t all = strandCount_ * vertexCount_;
    HairCurves curves;
    std::vector<float> thickness;
    if (readAt<uint32_t>(bytes_, kPositionsAt) == 0)
      return fileError(name_, kPositionsAt, "the file has no positions (their offset is 0)");
    if (auto r = copy(kPositionsAt, all, "positions", curves.positions); !r) return r.error();
    if (auto r = copy(kThicknessAt, strandCount_, "strand thickness", thickness); !r)
      return r.error();
    if (auto r = copy(kStrandUvAt, strandCount_, "strand UV", curves.strandUv); !r)
      return r.error();
    if (auto r = copy(kColorAt, all, "vertex colours", curves.colors); !r) return r.error();
    if (auto r = copy(kVertexUvAt, all, "vertex UV", curves.vertexUv); !r) return r.error();
    curves.vertexCounts.assign(strandCount_, static_cast<uint32_t>(vertexCount_));
    for (const float value : thickness)
      curves.radii.insert(curves.radii.end(), vertexCount_, value * kUnitFiberRadius);
    addMasses(curves, readAt<uint8_t>(bytes_, kBothEndsAt) != 0);
    if (const auto follow = readAt<uint32_t>(bytes_, kFollowAt); follow > 0)
      report_.notes.push_back(
          fmt::format("the file asks for {} follow hairs a guide, which are not made", follow));
    if (readAt<uint32_t>(bytes_, kGuidesAt) != 0)
      report_.notes.push_back("which strands are guides is not kept; all are");
    return curves;
  }

 private:
  static constexpr uint64_t kHeaderSize = 296, kFollowAt = 12, kBothEndsAt = 16;
  static constexpr uint64_t kPositionsAt = 144, kThicknessAt = 148, kStrandUvAt = 152,
                            kColorAt = 156, kGuidesAt = 160, kVertexUvAt = 164;

  // The array whose offset is at `at`; none when that is 0.
  template <class T>
  Result<void> copy(uint64_t at, uint64_t count, const char* what, std::vector<T>& out) {
    const uint64_t offset = readAt<uint32_t>(bytes_, at);
    if (offset == 0) return {};
    if (offset < kHeaderSize)
      return fileError(name_, at,
                       fmt::format("the {} at byte {} overlap the header", what, offset));
    if (offset + count * sizeof(T) > bytes_.size())
      return fileError(name_, at,
                       fmt::format("the {} of {} strands x {} vertices need bytes {} to {}, but "
                                   "the file ends at byte {}",
                                   what, strandCount_, vertexCount_, offset,
                                   offset + count * sizeof(T), bytes_.size()));
    out.resize(count);
    std::memcpy(static_cast<void*>(out.data()), bytes_.data() + offset, count * sizeof(T));
    return {};
  }

  std::span<const std::byte> bytes_;
  std::string_view name_;
  HairFileReport& report_;
  uint64_t strandCount_ = 0, vertexCount_ = 0;
};

// Header lines "keyword values", then for each strand "strand I numVerts N texcoord U V" and N
// lines "x, y, z". Version 1 begins with numStrands and has no other header.
class TextReader {
 public:
  TextReader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : lines_(detail::asText(bytes), name), report_(report) {}

  Result<HairCurves> read() {
    report_.format = "TressFX 1 text";
    while (lines_.next()) {
      if (lines_.atEnd()) continue;
      const std::string_view keyword = lines_.word();
      const auto done = keyword == "strand" ? readStrand() : readHeaderLine(keyword);
      if (!done) return done.error();
    }
    if (!strandCount_) return lines_.fail("the file ends without 'numStrands'");
    if (curves_.vertexCounts.size() != *strandCount_)
      return lines_.fail(fmt::format("the file ends after {} strands; 'numStrands' says {}",
                                     curves_.vertexCounts.size(), *strandCount_));
    if (curves_.vertexCounts.empty()) return lines_.fail("the file has no strands");
    if (!hasUv_) curves_.strandUv.clear();
    slot();
    addMasses(curves_, bothEndsImmovable_);
    return std::move(curves_);
  }

 private:
  Result<void> readHeaderLine(std::string_view keyword) {
    if (!curves_.vertexCounts.empty() && keyword != "strand")
      return lines_.fail(fmt::format("expected 'strand', found '{}'", clip(keyword)));
    if (keyword == "version") return readVersion();
    if (keyword == "scale") return readNumbers(&scale_, 1);
    if (keyword == "rotation") return readNumbers(rotation_.data(), 3);
    if (keyword == "translation") return readNumbers(translation_.data(), 3);
    // "is sorted 1", and a hint for allocation.
    if (keyword == "is" || keyword == "maxNumVerticesInStrand") return {};
    if (keyword == "maxRadiusAroundGuideHair") return {};
    if (keyword == "numFollowHairsPerGuideHair") {
      auto count = lines_.count("the number of follow hairs");
      if (!count) return count.error();
      if (*count > 0)
        report_.notes.push_back(
            fmt::format("the file asks for {} follow hairs a guide, which are not made", *count));
      return {};
    }
    if (keyword == "bothEndsImmovable") {
      auto value = lines_.count("bothEndsImmovable");
      if (!value) return value.error();
      bothEndsImmovable_ = *value != 0;
      return {};
    }
    if (keyword == "numStrands") {
      auto count = lines_.count("numStrands");
      if (!count) return count.error();
      strandCount_ = *count;
      return {};
    }
    return lines_.fail(fmt::format("'{}' is no keyword of a .tfx text", clip(keyword)));
  }

  Result<void> readVersion() {
    auto version = lines_.number("the version");
    if (!version) return version.error();
    if (*version != 2)
      return lines_.fail(fmt::format("text of version {}; only 1 and 2.0 are known", *version));
    report_.format = "TressFX 2.0 text";
    return {};
  }

  Result<void> readNumbers(double* out, int count) {
    for (int i = 0; i < count; ++i) {
      auto value = lines_.number("a number of the header");
      if (!value) return value.error();
      if (!(std::abs(*value) <= std::numeric_limits<float>::max()))
        return lines_.fail("a number of the header is not finite");
      out[i] = *value;
    }
    return {};
  }

  Result<void> readStrand() {
    if (!strandCount_) return lines_.fail("'strand' before 'numStrands'");
    if (curves_.vertexCounts.size() == *strandCount_)
      return lines_.fail(fmt::format("more than the {} strands of 'numStrands'", *strandCount_));
    auto index = lines_.count("the strand's number");
    if (!index) return index.error();
    if (lines_.word() != "numVerts") return lines_.fail("expected 'numVerts' behind the number");
    auto count = lines_.count("numVerts");
    if (!count) return count.error();
    if (*count == 0) return lines_.fail("a strand without vertices");
    // A vertex has at least 6 characters; the last line may lack its end.
    if (*count > (lines_.bytesLeft() + 1) / 6)
      return lines_.fail(fmt::format("numVerts is {}, but only {} bytes of text are left", *count,
                                     lines_.bytesLeft()));
    Float2 uv;
    const bool texcoord = lines_.word() == "texcoord";
    if (texcoord) {
      auto u = lines_.number("the strand's u");
      if (!u) return u.error();
      auto v = lines_.number("the strand's v");
      if (!v) return v.error();
      uv = {*u, *v};
    }
    for (uint32_t i = 0; i < *count; ++i) {
      if (!lines_.next())
        return lines_.fail(fmt::format("the file ends after {} of {} vertices", i, *count));
      float p[3];
      for (float& coordinate : p) {
        auto value = lines_.number("a coordinate");
        if (!value) return value.error();
        coordinate = *value;
      }
      curves_.positions.push_back({p[0], p[1], p[2]});
    }
    curves_.vertexCounts.push_back(*count);
    curves_.strandUv.push_back(uv);
    hasUv_ = hasUv_ || texcoord;
    return {};
  }

  // Scale, then roll about z, pitch about x and yaw about y [rad], then the translation.
  void slot() {
    using Eigen::AngleAxisd, Eigen::Vector3d;
    const Eigen::Matrix3d turn = (AngleAxisd(rotation_.y(), Vector3d::UnitY()) *
                                  AngleAxisd(rotation_.x(), Vector3d::UnitX()) *
                                  AngleAxisd(rotation_.z(), Vector3d::UnitZ()))
                                     .toRotationMatrix();
    if (scale_ == 1 && rotation_.isZero(0) && translation_.isZero(0)) return;
    report_.notes.push_back("the file's scale, rotation and translation were applied");
    for (Float3& p : curves_.positions) {
      const Vector3d moved = turn * (scale_ * Vector3d(p.x, p.y, p.z)) + translation_;
      p = {static_cast<float>(moved.x()), static_cast<float>(moved.y()),
           static_cast<float>(moved.z())};
    }
  }

  TextLines lines_;
  HairFileReport& report_;
  std::optional<uint32_t> strandCount_;
  double scale_ = 1;
  Eigen::Vector3d rotation_ = Eigen::Vector3d::Zero(), translation_ = Eigen::Vector3d::Zero();
  bool bothEndsImmovable_ = false, hasUv_ = false;
  HairCurves curves_;
};

bool startsLikeText(std::span<const std::byte> bytes) {
  std::string_view text = detail::asText(bytes.first(std::min<size_t>(bytes.size(), 64)));
  if (text.starts_with(detail::kByteOrderMark)) text.remove_prefix(detail::kByteOrderMark.size());
  const size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return false;
  const std::string_view rest = text.substr(begin);
  // A file that was cut off inside the first word is text, too.
  const auto starts = [&](std::string_view word) {
    return !rest.empty() && rest.substr(0, word.size()) == word.substr(0, rest.size());
  };
  return starts("version") || starts("numStrands");
}

Result<HairCurves> load(std::span<const std::byte> bytes, std::string_view name,
                        HairFileReport& report) {
  if (std::filesystem::path(name).extension() == ".tfxb")
    return fileError(
        name, 0,
        "a .tfxb file holds what TressFX 2 or 3 derived from a .tfx, without a version; "
        "convert the .tfx");
  if (startsLikeText(bytes)) return TextReader(bytes, name, report).read();
  if (bytes.size() < sizeof(float))
    return fileError(name, bytes.size(), "the file ends before its version");
  const auto version = readAt<float>(bytes, 0);
  if (version == 4.0f) return readBinary4(bytes, name, report);
  if (version == 3.0f) return Binary3Reader(bytes, name, report).read();
  return fileError(name, 0,
                   fmt::format("the version is {}; text of 1 and 2.0, binary 3.0 and 4.0 can be "
                               "read (is this a .tfx file?)",
                               version));
}

}  // namespace

Result<HairCurves> loadTfxCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kTfx, "", bytes.size(), {}};
    auto curves = load(bytes, name, found);
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

}  // namespace pelage
