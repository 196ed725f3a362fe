// The .tfxmesh file: text, one record per line.
#include "pelage/collision_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>

#include "assets/bone_influences.h"
#include "base/errors.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "pelage/hair_asset.h"

namespace pelage {
namespace {

using detail::invalid;

constexpr size_t kMaxMeshNameLength = 4096;

bool isBlank(char c) { return c == ' ' || c == '\t'; }

// Returns the lines with content, and parses them.
class LineReader {
 public:
  LineReader(std::string_view text, std::string_view name) : rest_(text), name_(name) {}

  /// Goes to the next line that is neither blank nor a comment; false at the end.
  bool next() {
    while (!rest_.empty()) {
      const size_t end = rest_.find('\n');
      line_ = rest_.substr(0, end);
      rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
      ++lineNumber_;
      if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
      skipBlanks();
      if (!line_.empty() && line_.front() != '#') return true;
    }
    ++lineNumber_;
    return false;
  }

  size_t bytesLeft() const { return rest_.size(); }

  std::string_view word() {
    skipBlanks();
    const auto end = std::ranges::find_if(line_, isBlank) - line_.begin();
    const std::string_view result = line_.substr(0, static_cast<size_t>(end));
    line_.remove_prefix(result.size());
    return result;
  }

  /// Returns the rest of the line, without blanks at the ends.
  std::string_view remainder() {
    skipBlanks();
    while (!line_.empty() && isBlank(line_.back())) line_.remove_suffix(1);
    return line_;
  }

  Result<uint32_t> integer(const char* what) {
    const std::string_view text = word();
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      return fail(fmt::format("{}: '{}' is not a whole number of 0 to 2^32-1", what, clip(text)));
    return value;
  }

  /// A number within +-limit.
  Result<float> number(const char* what, float limit) {
    std::string_view text = word();
    // Some exporters write the plus sign, which std::from_chars does not take.
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool complete = end == text.data() + text.size() && !text.empty();
    // Numbers too small for a float are zero.
    if (complete && error == std::errc::result_out_of_range && isTiny(text)) return 0.0f;
    if (!complete || error != std::errc())
      return fail(fmt::format("{}: '{}' is not a number", what, clip(text)));
    if (!(std::abs(value) <= limit))
      return fail(fmt::format("{} is {}; it must be within +-{}", what, value, limit));
    return value;
  }

  Error fail(std::string_view what) const {
    return Error{ErrorCode::kInvalidFile, fmt::format("{}:{}: {}", name_, lineNumber_, what)};
  }

 private:
  void skipBlanks() {
    while (!line_.empty() && isBlank(line_.front())) line_.remove_prefix(1);
  }

  static bool isTiny(std::string_view text) {
    double value = 1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() ? std::abs(value) < 1 : text.find("e-") != std::string_view::npos;
  }

  static std::string_view clip(std::string_view text) { return text.substr(0, 40); }

  std::string_view rest_, line_, name_;
  uint64_t lineNumber_ = 0;
};

// Reads "<keyword> N" with N lines to follow, of at least `lineSize` bytes each.
Result<uint32_t> readCount(LineReader& lines, std::string_view keyword, uint64_t lineSize) {
  if (!lines.next()) return lines.fail(fmt::format("the text ends where '{}' should be", keyword));
  const std::string_view found = lines.word();
  if (found != keyword)
    return lines.fail(fmt::format("expected '{}', found '{}'", keyword, found.substr(0, 40)));
  auto count = lines.integer("the count");
  if (!count) return count.error();
  if (!lines.remainder().empty()) return lines.fail("text after the count");
  if (*count == 0) return lines.fail(fmt::format("'{}' is 0; it must be at least 1", keyword));
  // The last line may have no line end.
  if (*count > (lines.bytesLeft() + 1) / lineSize)
    return lines.fail(fmt::format("'{}' is {}, but only {} bytes of text are left", keyword, *count,
                                  lines.bytesLeft()));
  return count;
}

// Reads the index at the start of a record: in range, and not used before.
Result<uint32_t> readIndex(LineReader& lines, const char* what, std::vector<bool>& seen) {
  auto index = lines.integer(what);
  if (!index) return index.error();
  if (*index >= seen.size())
    return lines.fail(fmt::format("{} is {}; it must be 0 to {}", what, *index, seen.size() - 1));
  if (seen[*index]) return lines.fail(fmt::format("{} {} is there twice", what, *index));
  seen[*index] = true;
  return index;
}

Result<void> readBones(LineReader& lines, CollisionMesh& mesh) {
  auto count = readCount(lines, "numOfBones", 4);
  if (!count) return count.error();
  std::vector<bool> seen(*count);
  mesh.bones.reserve(*count);
  for (uint32_t i = 0; i < *count; ++i) {
    if (!lines.next()) return lines.fail(fmt::format("the text ends after {} bones", i));
    auto index = readIndex(lines, "the bone index", seen);
    if (!index) return index.error();
    const std::string_view name = lines.remainder();
    if (name.empty() || name.size() >= kMaxMeshNameLength ||
        name.find_first_of(std::string_view("\0\r", 2)) != std::string_view::npos)
      return lines.fail(
          "a bone needs a name of at most 4095 characters, without NUL or carriage return");
    mesh.bones.push_back({*index, std::string(name)});
  }
  return {};
}

Result<void> readVertices(LineReader& lines, CollisionMesh& mesh) {
  auto count = readCount(lines, "numOfVertices", 30);
  if (!count) return count.error();
  std::vector<bool> seen(*count);
  mesh.positions.resize(*count);
  mesh.normals.resize(*count);
  mesh.influences.resize(*count);
  for (uint32_t i = 0; i < *count; ++i) {
    if (!lines.next()) return lines.fail(fmt::format("the text ends after {} vertices", i));
    auto index = readIndex(lines, "the vertex index", seen);
    if (!index) return index.error();
    float vector[6];
    for (int k = 0; k < 6; ++k) {
      auto value = lines.number(k < 3 ? "a coordinate" : "a normal's component", kMaxCoordinate);
      if (!value) return value.error();
      vector[k] = *value;
    }
    mesh.positions[*index] = {vector[0], vector[1], vector[2]};
    mesh.normals[*index] = {vector[3], vector[4], vector[5]};
    BoneInfluences& influences = mesh.influences[*index];
    for (uint32_t& bone : influences.bones) {
      auto value = lines.integer("a bone");
      if (!value) return value.error();
      if (*value >= mesh.bones.size())
        return lines.fail(
            fmt::format("bone {}; it must be 0 to {}", *value, mesh.bones.size() - 1));
      bone = *value;
    }
    for (float& weight : influences.weights) {
      auto value = lines.number("a weight", kMaxCoordinate);
      if (!value) return value.error();
      if (!detail::isWeight(*value))
        return lines.fail(fmt::format("the weight {}; it must be 0 to 1e6", *value));
      weight = *value;
    }
    if (!lines.remainder().empty()) return lines.fail("text after the vertex");
    if (detail::repairWeights(influences)) ++mesh.repairedVertexCount;
  }
  return {};
}

Result<void> readTriangles(LineReader& lines, CollisionMesh& mesh) {
  auto count = readCount(lines, "numOfTriangles", 8);
  if (!count) return count.error();
  std::vector<bool> seen(*count);
  mesh.indices.resize(size_t{*count} * 3);
  for (uint32_t i = 0; i < *count; ++i) {
    if (!lines.next()) return lines.fail(fmt::format("the text ends after {} triangles", i));
    auto index = readIndex(lines, "the triangle index", seen);
    if (!index) return index.error();
    for (size_t k = 0; k < 3; ++k) {
      auto vertex = lines.integer("a vertex of the triangle");
      if (!vertex) return vertex.error();
      if (*vertex >= mesh.positions.size())
        return lines.fail(
            fmt::format("vertex {}; it must be 0 to {}", *vertex, mesh.positions.size() - 1));
      mesh.indices[size_t{*index} * 3 + k] = *vertex;
    }
    if (!lines.remainder().empty()) return lines.fail("text after the triangle");
  }
  return {};
}

Result<CollisionMesh> load(std::string_view text, std::string_view name) {
  LineReader lines(text, name);
  CollisionMesh mesh;
  if (auto r = readBones(lines, mesh); !r) return r.error();
  if (auto r = readVertices(lines, mesh); !r) return r.error();
  if (auto r = readTriangles(lines, mesh); !r) return r.error();
  if (lines.next()) return lines.fail("text after the last triangle");
  return mesh;
}

Result<void> checkMesh(const CollisionMesh& mesh) {
  const size_t vertexCount = mesh.positions.size();
  if (mesh.bones.empty() || vertexCount == 0 || mesh.indices.empty())
    return invalid("a collision mesh needs bones, vertices and triangles");
  if (mesh.normals.size() != vertexCount || mesh.influences.size() != vertexCount)
    return invalid(fmt::format("a collision mesh has {} positions, {} normals and {} influences",
                               vertexCount, mesh.normals.size(), mesh.influences.size()));
  if (mesh.indices.size() % 3 != 0)
    return invalid(fmt::format("{} indices are no triangles", mesh.indices.size()));
  if (auto r = detail::checkBoneNames(mesh.bones, kMaxMeshNameLength); !r) return r;
  for (const BoneName& bone : mesh.bones) {
    const bool trimmed = !bone.name.empty() && !isBlank(bone.name.front()) &&
                         !isBlank(bone.name.back()) &&
                         bone.name.find_first_of("\r\n") == std::string::npos;
    if (!trimmed)
      return invalid(
          fmt::format("bone {}: a name of a text file must not be empty, start or end "
                      "with a blank, or have line ends",
                      bone.index));
  }
  for (size_t i = 0; i < vertexCount; ++i) {
    const Float3& p = mesh.positions[i];
    const Float3& n = mesh.normals[i];
    for (const float value : {p.x, p.y, p.z, n.x, n.y, n.z})
      if (!(std::abs(value) <= kMaxCoordinate))
        return invalid(fmt::format("vertex {} has the coordinate {}", i, value));
    if (auto r = detail::checkInfluences(mesh.influences[i], mesh.bones.size(), "vertex", i); !r)
      return r;
  }
  for (size_t i = 0; i < mesh.indices.size(); ++i)
    if (mesh.indices[i] >= vertexCount)
      return invalid(fmt::format("triangle {} refers to vertex {} of {}", i / 3, mesh.indices[i],
                                 vertexCount));
  return {};
}

Result<std::string> save(const CollisionMesh& mesh) {
  if (auto r = checkMesh(mesh); !r) return r.error();
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# collision mesh: metres, bind pose\nnumOfBones {}\n# index name\n",
                 mesh.bones.size());
  for (const BoneName& bone : mesh.bones) fmt::format_to(out, "{} {}\n", bone.index, bone.name);
  fmt::format_to(out, "numOfVertices {}\n# index, position, normal, 4 bones, 4 weights\n",
                 mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Float3& p = mesh.positions[i];
    const Float3& n = mesh.normals[i];
    const auto& b = mesh.influences[i].bones;
    const auto& w = mesh.influences[i].weights;
    fmt::format_to(out, "{} {} {} {} {} {} {} {} {} {} {} {} {} {} {}\n", i, p.x, p.y, p.z, n.x,
                   n.y, n.z, b[0], b[1], b[2], b[3], w[0], w[1], w[2], w[3]);
  }
  fmt::format_to(out, "numOfTriangles {}\n# index, 3 vertices\n", mesh.indices.size() / 3);
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    fmt::format_to(out, "{} {} {} {}\n", i / 3, mesh.indices[i], mesh.indices[i + 1],
                   mesh.indices[i + 2]);
  return std::string(text.data(), text.size());
}

}  // namespace

Result<CollisionMesh> loadTfxMesh(std::string_view text, std::string_view name) {
  return detail::guarded([&] { return load(text, name); });
}

Result<CollisionMesh> loadTfxMesh(ByteSource& source, std::string_view name) {
  return detail::guarded([&]() -> Result<CollisionMesh> {
    auto bytes = readAll(source, name);
    if (!bytes) return bytes.error();
    return load({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, name);
  });
}

Result<CollisionMesh> loadTfxMesh(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<CollisionMesh> {
    auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return load({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path.string());
  });
}

Result<std::string> saveTfxMesh(const CollisionMesh& mesh) {
  return detail::guarded([&] { return save(mesh); });
}

Result<void> saveTfxMesh(const CollisionMesh& mesh, const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    auto text = save(mesh);
    if (!text) return text.error();
    return detail::writeFile(path, std::as_bytes(std::span(text->data(), text->size())));
  });
}

}  // namespace pelage
