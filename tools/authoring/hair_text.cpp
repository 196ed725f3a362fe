// .hairtxt: hair curves as text, a vertex a line.
#include <fmt/format.h>

#include <array>
#include <iterator>
#include <limits>

#include "binary_file.h"
#include "common/errors.h"
#include "pelage/authoring/hair_files.h"
#include "text_lines.h"

namespace pelage {
namespace {

using detail::clip;
using detail::TextLines;

constexpr uint32_t kVersion = 1;

enum Column { kX, kY, kZ, kInverseMass, kRadius, kR, kG, kB, kA, kU, kV, kColumnCount };
constexpr std::array<std::string_view, kColumnCount> kColumns = {
    "x", "y", "z", "inverseMass", "radius", "r", "g", "b", "a", "u", "v"};

class HairTextReader {
 public:
  HairTextReader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : lines_(detail::asText(bytes), name), report_(report) {}

  Result<HairCurves> read() {
    if (auto r = readHeader(); !r) return r.error();
    while (lines_.next()) {
      if (lines_.atEnd()) {
        // A line with a comment alone does not end a curve.
        if (!lines_.hasComment()) endCurve();
        continue;
      }
      auto r = readRecord();
      if (!r) return r.error();
    }
    endCurve();
    if (rootWaits_) return lines_.fail("the file ends after 'root', which needs a curve");
    if (curves_.vertexCounts.empty()) return lines_.fail("the file has no curves");
    if (rootCount_ > 0) curves_.strandUv.resize(curves_.vertexCounts.size());
    if (rootCount_ > 0 && rootCount_ < curves_.vertexCounts.size())
      report_.notes.push_back(
          fmt::format("{} curves have no 'root'; they are at 0 0 of the texture",
                      curves_.vertexCounts.size() - rootCount_));
    return std::move(curves_);
  }

 private:
  Result<void> readHeader() {
    do {
      if (!lines_.next()) return lines_.fail("expected 'hairtxt 1', found nothing");
    } while (lines_.atEnd());
    if (const std::string_view magic = lines_.word(); magic != "hairtxt")
      return lines_.fail(fmt::format("expected 'hairtxt 1', found '{}'", clip(magic)));
    auto version = lines_.count("the version");
    if (!version) return version.error();
    if (*version != kVersion)
      return lines_.fail(fmt::format("version {}; this reader knows version 1", *version));
    if (lines_.atEnd()) {
      columns_ = {kX, kY, kZ};
      return {};
    }
    std::array<bool, kColumnCount> seen{};
    while (!lines_.atEnd()) {
      const std::string_view word = lines_.word();
      size_t column = 0;
      while (column < kColumnCount && kColumns[column] != word) ++column;
      if (column == kColumnCount)
        return lines_.fail(fmt::format(
            "no column is called '{}'; they are x y z inverseMass radius r g b a u v", clip(word)));
      if (seen[column]) return lines_.fail(fmt::format("the column '{}' is there twice", word));
      seen[column] = true;
      columns_.push_back(static_cast<Column>(column));
    }
    if (!seen[kX] || !seen[kY] || !seen[kZ])
      return lines_.fail("the columns x, y and z must be there");
    if (seen[kR] != seen[kG] || seen[kR] != seen[kB] || (seen[kA] && !seen[kR]))
      return lines_.fail("a colour needs the columns r, g and b; a alone is none");
    if (seen[kU] != seen[kV]) return lines_.fail("the columns u and v go together");
    hasMass_ = seen[kInverseMass];
    hasRadius_ = seen[kRadius];
    hasColor_ = seen[kR];
    hasUv_ = seen[kU];
    return {};
  }

  Result<void> readRecord() {
    std::array<float, kColumnCount> values{};
    values[kA] = 1;
    bool first = true;
    for (const Column column : columns_) {
      const std::string_view word = lines_.word();
      if (first && word == "root") return readRoot();
      first = false;
      const std::optional<float> value = detail::parseFloat(word);
      if (word.empty())
        return lines_.fail(fmt::format("'{}' is missing; a vertex has {} numbers", kColumns[column],
                                       columns_.size()));
      if (!value)
        return lines_.fail(fmt::format("{}: '{}' is not a number", kColumns[column], clip(word)));
      values[column] = *value;
    }
    if (!lines_.atEnd())
      return lines_.fail(fmt::format("more than the {} numbers of a vertex", columns_.size()));
    if (count_ == std::numeric_limits<uint32_t>::max())
      return lines_.fail("a curve of more than 2^32 - 1 vertices");
    ++count_;
    rootWaits_ = false;
    curves_.positions.push_back({values[kX], values[kY], values[kZ]});
    if (hasMass_) curves_.inverseMasses.push_back(values[kInverseMass]);
    if (hasRadius_) curves_.radii.push_back(values[kRadius]);
    if (hasColor_) curves_.colors.push_back({values[kR], values[kG], values[kB], values[kA]});
    if (hasUv_) curves_.vertexUv.push_back({values[kU], values[kV]});
    return {};
  }

  // "root u v" before the first vertex of a curve.
  Result<void> readRoot() {
    if (count_ > 0 || rootWaits_)
      return lines_.fail("'root' comes once, before the first vertex of a curve");
    auto u = lines_.number("u");
    if (!u) return u.error();
    auto v = lines_.number("v");
    if (!v) return v.error();
    if (!lines_.atEnd()) return lines_.fail("text after 'root u v'");
    curves_.strandUv.resize(curves_.vertexCounts.size());
    curves_.strandUv.push_back({*u, *v});
    rootWaits_ = true;
    ++rootCount_;
    return {};
  }

  void endCurve() {
    if (count_ > 0) curves_.vertexCounts.push_back(count_);
    count_ = 0;
  }

  TextLines lines_;
  HairFileReport& report_;
  std::vector<Column> columns_;
  bool hasMass_ = false, hasRadius_ = false, hasColor_ = false, hasUv_ = false;
  uint32_t count_ = 0;      // vertices of the curve so far
  bool rootWaits_ = false;  // for the curve's vertices
  uint64_t rootCount_ = 0;
  HairCurves curves_;
};

Result<std::string> writeText(const HairCurves& curves) {
  if (auto r = validate(curves); !r) return r.error();
  if (curves.vertexCounts.empty())
    return Error{ErrorCode::kInvalidArgument, "a .hairtxt file: there are no curves"};
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "hairtxt {} x y z", kVersion);
  if (!curves.inverseMasses.empty()) fmt::format_to(out, " inverseMass");
  if (!curves.radii.empty()) fmt::format_to(out, " radius");
  if (!curves.colors.empty()) fmt::format_to(out, " r g b a");
  if (!curves.vertexUv.empty()) fmt::format_to(out, " u v");
  fmt::format_to(out, "\n");
  size_t vertex = 0;
  for (size_t curve = 0; curve < curves.vertexCounts.size(); ++curve) {
    if (curve > 0) fmt::format_to(out, "\n");
    if (!curves.strandUv.empty())
      fmt::format_to(out, "root {} {}\n", curves.strandUv[curve].x, curves.strandUv[curve].y);
    for (const size_t end = vertex + curves.vertexCounts[curve]; vertex < end; ++vertex) {
      const Float3& p = curves.positions[vertex];
      fmt::format_to(out, "{} {} {}", p.x, p.y, p.z);
      if (!curves.inverseMasses.empty()) fmt::format_to(out, " {}", curves.inverseMasses[vertex]);
      if (!curves.radii.empty()) fmt::format_to(out, " {}", curves.radii[vertex]);
      if (!curves.colors.empty()) {
        const Float4& c = curves.colors[vertex];
        fmt::format_to(out, " {} {} {} {}", c.x, c.y, c.z, c.w);
      }
      if (!curves.vertexUv.empty())
        fmt::format_to(out, " {} {}", curves.vertexUv[vertex].x, curves.vertexUv[vertex].y);
      fmt::format_to(out, "\n");
    }
  }
  return std::string(text.data(), text.size());
}

}  // namespace

Result<HairCurves> loadHairText(std::span<const std::byte> bytes, std::string_view name,
                                HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kHairText, "hairtxt 1", bytes.size(), {}};
    auto curves = HairTextReader(bytes, name, found).read();
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

Result<std::string> saveHairText(const HairCurves& curves) {
  return tools::guarded([&] { return writeText(curves); });
}

Result<void> saveHairText(const HairCurves& curves, const std::filesystem::path& path) {
  return tools::guarded([&]() -> Result<void> {
    auto text = writeText(curves);
    if (!text) return text.error();
    return tools::writeFile(path, std::as_bytes(std::span(*text)));
  });
}

}  // namespace pelage
