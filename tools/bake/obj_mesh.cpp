#include "obj_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "pelage/hair_asset.h"

namespace pelage::bake {
namespace {

// Words of a line, between blanks.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(word.size());
    return word;
  }

 private:
  std::string_view rest_;
};

template <class T>
std::optional<T> numberOf(std::string_view text) {
  T value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// A corner "7", "7/1", "7//2" or "7/1/2"; below 0 it counts from the last vertex.
std::optional<uint32_t> cornerOf(std::string_view word, size_t vertices) {
  const auto number = numberOf<int64_t>(word.substr(0, word.find('/')));
  if (!number) return std::nullopt;
  const int64_t index = *number > 0 ? *number - 1 : static_cast<int64_t>(vertices) + *number;
  if (*number == 0 || index < 0 || index >= static_cast<int64_t>(vertices)) return std::nullopt;
  return static_cast<uint32_t>(index);
}

// Returns the error of a line, or nullptr.
const char* readLine(std::string_view line, CollisionMesh& mesh) {
  Words words(line);
  const std::string_view kind = words.next();
  if (kind == "v") {
    std::array<float, 3> p = {};
    for (float& coordinate : p) {
      const auto number = numberOf<float>(words.next());
      if (!number || !(std::abs(*number) <= kMaxCoordinate))
        return "a vertex needs three numbers within +-1000000";
      coordinate = *number;
    }
    mesh.positions.push_back({p[0], p[1], p[2]});
  } else if (kind == "f") {
    std::vector<uint32_t> corners;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const auto corner = cornerOf(word, mesh.positions.size());
      if (!corner) return "a corner is none of the vertices before it";
      corners.push_back(*corner);
    }
    if (corners.size() < 3) return "a face needs three corners";
    for (size_t i = 2; i < corners.size(); ++i)
      for (const uint32_t corner : {corners[0], corners[i - 1], corners[i]})
        mesh.indices.push_back(corner);
  }
  return nullptr;
}

}  // namespace

Result<CollisionMesh> readObjMesh(std::string_view text, std::string_view name) {
  CollisionMesh mesh;
  for (uint64_t line = 1; !text.empty(); ++line) {
    const size_t end = std::min(text.find('\n'), text.size());
    if (const char* fault = readLine(text.substr(0, end), mesh); fault != nullptr)
      return Error{ErrorCode::kInvalidFile, fmt::format("{}:{}: {}", name, line, fault)};
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (mesh.indices.empty())
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: has no faces", name)};
  mesh.normals.resize(mesh.positions.size());
  return mesh;
}

}  // namespace pelage::bake
