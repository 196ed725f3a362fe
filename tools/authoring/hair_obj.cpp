// Lines of a Wavefront .obj file. Formats: "Advanced Visualizer" manual, appendix B1 (elements v,
// vt, l; negative references; continuation lines). Colors behind the coordinates are a custom of
// many programs.
#include <fmt/format.h>

#include <limits>
#include <utility>

#include "common/errors.h"
#include "line_chains.h"
#include "pelage/authoring/hair_files.h"
#include "text_lines.h"

namespace pelage {
namespace {

using detail::clip;
using detail::TextLines;

constexpr uint32_t kNoUv = std::numeric_limits<uint32_t>::max();

class ObjReader {
 public:
  ObjReader(std::span<const std::byte> bytes, std::string_view name, HairFileReport& report)
      : lines_(detail::asText(bytes), name, true), name_(name), report_(report) {}

  Result<HairCurves> read() {
    while (lines_.next()) {
      const std::string_view keyword = lines_.word();
      Result<void> done;
      if (keyword == "v")
        done = readVertex();
      else if (keyword == "vt")
        done = readUv();
      else if (keyword == "l")
        done = readLine();
      else if (keyword == "f")
        ++faceCount_;
      else if (keyword == "curv" || keyword == "curv2")
        ++splineCount_;
      if (!done) return done.error();
    }
    joinPairs();
    if (curves_.vertexCounts.empty())
      return Error{
          ErrorCode::kInvalidFile,
          fmt::format("{}:{}: the file has no lines ('l' elements){}", name_, lines_.lineNumber(),
                      splineCount_ > 0 ? "; convert its free-form curves to polylines"
                                       : "; export the hair as curves or edges")};
    if (faceCount_ > 0) report_.notes.push_back(fmt::format("{} faces are ignored", faceCount_));
    if (splineCount_ > 0)
      report_.notes.push_back(fmt::format("{} free-form curves are ignored", splineCount_));
    return std::move(curves_);
  }

 private:
  Result<void> readVertex() {
    float values[8];
    size_t count = 0;
    for (; !lines_.atEnd(); ++count) {
      if (count == 8) return lines_.fail("a vertex has at most 8 numbers");
      auto value = lines_.number("a coordinate");
      if (!value) return value.error();
      values[count] = *value;
    }
    if (count < 3) return lines_.fail("a vertex needs x, y and z");
    if (vertices_.size() >= kNoUv)
      return lines_.fail("more than 2^32 - 1 vertices; split the file");
    vertices_.push_back({values[0], values[1], values[2]});
    // x y z [w], x y z r g b [a], x y z w r g b a: w is for rational curves only.
    if (count < 6) {
      if (!colors_.empty()) colors_.push_back({1, 1, 1, 1});
      return {};
    }
    colors_.resize(vertices_.size() - 1, {1, 1, 1, 1});
    const float* color = values + (count == 8 ? 4 : 3);
    colors_.push_back({color[0], color[1], color[2], count == 6 ? 1 : color[3]});
    return {};
  }

  Result<void> readUv() {
    auto u = lines_.number("u");
    if (!u) return u.error();
    float v = 0;
    if (!lines_.atEnd()) {
      auto value = lines_.number("v");
      if (!value) return value.error();
      v = *value;
    }
    uv_.push_back({*u, v});
    return {};
  }

  // A reference of an element: from 1, or from the end when it is negative.
  Result<uint32_t> resolve(std::string_view text, size_t count, const char* what) {
    const std::optional<int64_t> number = detail::parseInteger(text);
    if (!number || *number == 0)
      return lines_.fail(fmt::format("'{}' is not the number of a {}", clip(text), what));
    const auto size = static_cast<int64_t>(count);
    const int64_t index = *number > 0 ? *number - 1 : size + *number;
    // *number can be as low as -2^63; adding a size does not overflow.
    if (index < 0 || index >= size)
      return lines_.fail(
          fmt::format("{} {}, but there are {} above this line", what, *number, count));
    return static_cast<uint32_t>(index);
  }

  Result<void> readLine() {
    const size_t begin = slots_.size();
    while (!lines_.atEnd()) {
      const std::string_view word = lines_.word();
      const size_t slash = word.find('/');
      auto vertex = resolve(word.substr(0, slash), vertices_.size(), "vertex");
      if (!vertex) return vertex.error();
      uint32_t uv = kNoUv;
      if (slash != std::string_view::npos && slash + 1 < word.size()) {
        auto index = resolve(word.substr(slash + 1), uv_.size(), "texture coordinate");
        if (!index) return index.error();
        uv = *index;
        hasUv_ = true;
      }
      slots_.push_back({*vertex, uv});
    }
    const size_t count = slots_.size() - begin;
    if (count == 0) return lines_.fail("a line without vertices");
    if (count > kNoUv) return lines_.fail("a line of more than 2^32 - 1 vertices");
    if (count == 2) {
      const Location a = slots_[begin], b = slots_[begin + 1];
      slots_.resize(begin);
      pairs_.push_back({a.vertex, b.vertex});
      if (a.uv != kNoUv || b.uv != kNoUv) {
        pairUv_.resize(vertices_.size(), kNoUv);
        pairUv_[a.vertex] = a.uv;
        pairUv_[b.vertex] = b.uv;
      }
    } else {
      curves_.vertexCounts.push_back(static_cast<uint32_t>(count));
    }
    return {};
  }

  void joinPairs() {
    const detail::LineChains chains =
        detail::joinSegments(pairs_, static_cast<uint32_t>(vertices_.size()));
    for (const Location& slot : slots_) addVertex(slot);
    for (const uint32_t vertex : chains.vertices)
      addVertex({vertex, vertex < pairUv_.size() ? pairUv_[vertex] : kNoUv});
    curves_.vertexCounts.insert(curves_.vertexCounts.end(), chains.counts.begin(),
                                chains.counts.end());
    if (!chains.counts.empty() && chains.counts.size() < pairs_.size())
      report_.notes.push_back(fmt::format("{} lines of two vertices were joined to {} curves",
                                          pairs_.size(), chains.counts.size()));
  }

  struct Location {
    uint32_t vertex, uv;
  };

  void addVertex(const Location& slot) {
    curves_.positions.push_back(vertices_[slot.vertex]);
    if (!colors_.empty()) curves_.colors.push_back(colors_[slot.vertex]);
    if (hasUv_) curves_.vertexUv.push_back(slot.uv == kNoUv ? Float2{} : uv_[slot.uv]);
  }

  TextLines lines_;
  std::string_view name_;
  HairFileReport& report_;
  std::vector<Float3> vertices_;
  std::vector<Float4> colors_;  // [vertex]; empty until the first one comes
  std::vector<Float2> uv_;
  std::vector<Location> slots_;  // of the lines of more than two vertices
  std::vector<std::pair<uint32_t, uint32_t>> pairs_;
  std::vector<uint32_t> pairUv_;  // [vertex] texture coordinate in pairs
  bool hasUv_ = false;
  uint64_t faceCount_ = 0, splineCount_ = 0;
  HairCurves curves_;
};

}  // namespace

Result<HairCurves> loadObjCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    HairFileReport found{HairFileKind::kObj, "Wavefront OBJ lines", bytes.size(), {}};
    auto curves = ObjReader(bytes, name, found).read();
    if (report != nullptr) *report = std::move(found);
    return curves;
  });
}

}  // namespace pelage
