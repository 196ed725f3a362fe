// The .tfxskin file, and roots that follow a deformed mesh.
#include "pelage/skin_table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "base/errors.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/triangle_frame.h"
#include "pelage/hair_asset.h"

namespace pelage {
namespace {

using detail::append;
using detail::ByteReader;
using detail::fileError;
using detail::invalid;
using detail::toVector;
using detail::TriangleFrame;
using Vector = detail::Vector3<double>;

constexpr std::array<char, 8> kSkinMagic = {'T', 'F', 'X', 'S', 'K', 'I', 'N', '\0'};
constexpr uint32_t kSkinVersion = 1;
constexpr uint32_t kMaxSkinName = 4095;
constexpr uint64_t kSkinHeaderSize = 24;
constexpr uint64_t kPartRecordMin = 5 * sizeof(uint32_t);
constexpr uint64_t kRootRecord = 80;
// About the diagonal of all coordinates.
constexpr float kMaxOffset = 4 * kMaxCoordinate;
// Error of a sum of 1 by rounding to float.
constexpr double kSumTolerance = 1e-5;

static_assert(sizeof(SurfaceRoot) == kRootRecord && std::is_trivially_copyable_v<SurfaceRoot>,
              "roots are stored as they are in memory");

bool isWithin(const Float3& p, float limit) {  // false for NaN
  return std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit;
}

bool isShare(float value) { return value >= 0 && value <= 1; }

std::optional<TriangleFrame> frameOf(const Float3& a, const Float3& b, const Float3& c) {
  return detail::triangleFrame(toVector(a), toVector(b), toVector(c));
}

// Returns the error of a root; empty if there is none.
std::string problemOf(const SurfaceRoot& root, std::span<const SkinPart> parts) {
  if (root.part >= parts.size())
    return fmt::format("part {}; it must be 0 to {}", root.part, parts.size() - 1);
  const SkinPart& part = parts[root.part];
  if (root.triangle >= part.triangleCount)
    return fmt::format("triangle {} of part {}, which has {}", root.triangle, root.part,
                       part.triangleCount);
  for (const uint32_t corner : root.corners)
    if (corner >= part.vertexCount)
      return fmt::format("vertex {} of part {}, which has {}", corner, root.part, part.vertexCount);
  const Float3& b = root.barycentric;
  if (!isShare(b.x) || !isShare(b.y) || !isShare(b.z) ||
      !(std::abs(double{b.x} + b.y + b.z - 1) <= kSumTolerance))
    return fmt::format("barycentric coordinates {} {} {}; they must be 0 to 1, their sum 1", b.x,
                       b.y, b.z);
  if (!isWithin(root.offset, kMaxOffset))
    return fmt::format("the offset {} {} {}; it must be within +-4e6", root.offset.x, root.offset.y,
                       root.offset.z);
  for (const Float3& p : root.bind)
    if (!isWithin(p, kMaxCoordinate))
      return fmt::format("a corner at {} {} {}; it must be within +-1e6", p.x, p.y, p.z);
  if (!frameOf(root.bind[0], root.bind[1], root.bind[2])) return "a triangle without area";
  return {};
}

bool isName(std::string_view text) {
  return text.size() <= kMaxSkinName && text.find('\0') == std::string_view::npos;
}

Result<std::string> readName(ByteReader& reader, std::string_view what) {
  const uint64_t at = reader.offset();
  auto size = reader.value<uint32_t>(what);
  if (!size) return size.error();
  if (*size > kMaxSkinName)
    return fileError(
        reader.name(), at,
        fmt::format("{} has a name of {} bytes; the maximum is {}", what, *size, kMaxSkinName));
  auto name = reader.text(*size, what);
  if (name && !isName(*name))
    return fileError(reader.name(), at + sizeof(uint32_t),
                     fmt::format("{} has a name with a NUL", what));
  return name;
}

Result<SkinPart> readPart(ByteReader& reader, uint32_t index) {
  const std::string what = fmt::format("part {}", index);
  SkinPart part;
  for (uint32_t* count : {&part.vertexCount, &part.triangleCount}) {
    auto value = reader.value<uint32_t>(what);
    if (!value) return value.error();
    *count = *value;
  }
  for (std::string* text : {&part.name, &part.mesh, &part.material}) {
    auto value = readName(reader, what);
    if (!value) return value.error();
    *text = std::move(*value);
  }
  return part;
}

Result<SkinTable> loadTable(std::span<const std::byte> bytes, std::string_view name,
                            uint32_t strandCount) {
  ByteReader reader(bytes, name);
  auto magic = reader.value<std::array<char, 8>>("the header");
  if (!magic) return magic.error();
  if (*magic != kSkinMagic) return fileError(name, 0, "this is no .tfxskin file");
  uint32_t words[4] = {};  // version, parts, roots, reserved
  for (uint32_t& word : words) {
    auto value = reader.value<uint32_t>("the header");
    if (!value) return value.error();
    word = *value;
  }
  const auto [version, partCount, rootCount, reserved] = words;
  if (version != kSkinVersion)
    return fileError(
        name, 8, fmt::format("version {}; this library reads version {}", version, kSkinVersion));
  if (partCount == 0 || partCount > reader.left() / kPartRecordMin)
    return fileError(name, 12,
                     fmt::format("{} parts; the file has room for 1 to {}", partCount,
                                 reader.left() / kPartRecordMin));
  if (rootCount == 0 || rootCount > reader.left() / kRootRecord)
    return fileError(name, 16,
                     fmt::format("{} roots; the file has room for 1 to {}", rootCount,
                                 reader.left() / kRootRecord));
  if (strandCount != 0 && rootCount != strandCount)
    return fileError(
        name, 16,
        fmt::format("the file is for {} strands, the hair has {}", rootCount, strandCount));
  if (reserved != 0)
    return fileError(name, 20, fmt::format("the reserved word is {}, not 0", reserved));

  SkinTable table;
  for (uint32_t i = 0; i < partCount; ++i) {
    auto part = readPart(reader, i);
    if (!part) return part.error();
    table.parts.push_back(std::move(*part));
  }
  table.roots.reserve(rootCount);
  for (uint32_t i = 0; i < rootCount; ++i) {
    const uint64_t at = reader.offset();
    auto root = reader.value<SurfaceRoot>(fmt::format("root {}", i));
    if (!root) return root.error();
    if (const std::string problem = problemOf(*root, table.parts); !problem.empty())
      return fileError(name, at, fmt::format("root {} has {}", i, problem));
    table.roots.push_back(*root);
  }
  if (reader.left() != 0)
    return fileError(name, reader.offset(),
                     fmt::format("{} bytes after the last root", reader.left()));
  return table;
}

Result<void> check(const SkinTable& table) {
  constexpr size_t kMaxCount = std::numeric_limits<uint32_t>::max();
  if (table.parts.empty() || table.parts.size() > kMaxCount || table.roots.empty() ||
      table.roots.size() > kMaxCount)
    return invalid(fmt::format("a skin table of {} parts and {} roots; it needs 1 to 2^32-1 each",
                               table.parts.size(), table.roots.size()));
  for (size_t i = 0; i < table.parts.size(); ++i)
    for (const std::string* text :
         {&table.parts[i].name, &table.parts[i].mesh, &table.parts[i].material})
      if (!isName(*text))
        return invalid(fmt::format("part {} has a name that is longer than {} bytes or has a NUL",
                                   i, kMaxSkinName));
  for (size_t i = 0; i < table.roots.size(); ++i)
    if (const std::string problem = problemOf(table.roots[i], table.parts); !problem.empty())
      return invalid(fmt::format("root {} has {}", i, problem));
  return {};
}

Result<std::vector<std::byte>> saveTable(const SkinTable& table) {
  if (auto r = check(table); !r) return r.error();
  std::vector<std::byte> bytes;
  bytes.reserve(kSkinHeaderSize + table.roots.size() * kRootRecord);
  append(bytes, kSkinMagic);
  append(bytes, kSkinVersion);
  append(bytes, static_cast<uint32_t>(table.parts.size()));
  append(bytes, static_cast<uint32_t>(table.roots.size()));
  append(bytes, uint32_t{0});
  for (const SkinPart& part : table.parts) {
    append(bytes, part.vertexCount);
    append(bytes, part.triangleCount);
    for (const std::string* text : {&part.name, &part.mesh, &part.material}) {
      append(bytes, static_cast<uint32_t>(text->size()));
      const auto* begin = reinterpret_cast<const std::byte*>(text->data());
      bytes.insert(bytes.end(), begin, begin + text->size());
    }
  }
  for (const SurfaceRoot& root : table.roots) append(bytes, root);
  return bytes;
}

// The first corner has the rest of 1: a sum that rounding moved off 1 would not follow a
// translation.
Vector weightedMean(const Float3& weights, const Vector& a, const Vector& b, const Vector& c) {
  return a + (b - a) * weights.y + (c - a) * weights.z;
}

// The motion from a triangle's bind frame to its current one. In the plane the map is
//   G = [ edge' / edge, (shear' - shear edge' / edge) / height; 0, height' / height ],
// and the rotation of its polar decomposition, for a positive determinant, has cosine and sine
// proportional to G00 + G11 and G10 - G01.
AffineTransform motion(const SurfaceRoot& root, const TriangleFrame& bind, const Vector bindAt[3],
                       const TriangleFrame& now, const Vector nowAt[3]) {
  const double stretch = now.edge / bind.edge;
  const double trace = stretch + now.height / bind.height;
  const double skew = (bind.shear * stretch - now.shear) / bind.height;
  const double norm = std::hypot(trace, skew);
  const double cosine = trace / norm, sine = skew / norm;
  const Vector x = now.x * cosine + now.y * sine, y = now.y * cosine - now.x * sine;
  const auto rotate = [&](const Vector& v) {
    return x * dot(bind.x, v) + y * dot(bind.y, v) + now.z * dot(bind.z, v);
  };
  const Vector columns[3] = {rotate({1, 0, 0}), rotate({0, 1, 0}), rotate({0, 0, 1})};
  const Vector offset = bind.toSpace(toVector(root.offset));
  const Vector from = weightedMean(root.barycentric, bindAt[0], bindAt[1], bindAt[2]) + offset;
  const Vector to = weightedMean(root.barycentric, nowAt[0], nowAt[1], nowAt[2]) + rotate(offset);
  const Vector shift = to - rotate(from);
  const auto row = [](double a, double b, double c, double d) {
    return Float4{static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
                  static_cast<float>(d)};
  };
  return {{row(columns[0].x, columns[1].x, columns[2].x, shift.x),
           row(columns[0].y, columns[1].y, columns[2].y, shift.y),
           row(columns[0].z, columns[1].z, columns[2].z, shift.z)}};
}

bool isFinite(const AffineTransform& transform) {
  float sum = 0;
  for (const Float4& r : transform.rows) sum += 0 * (r.x + r.y + r.z + r.w);
  return sum == 0;  // NaN when one is not
}

Result<void> follow(const SkinTable& table, std::span<const std::span<const Float3>> vertices,
                    std::span<AffineTransform> transforms) {
  if (vertices.size() != table.parts.size())
    return invalid(
        fmt::format("root transforms: vertices of {} parts, but the skin table has {}; give an "
                    "empty span for a part without roots",
                    vertices.size(), table.parts.size()));
  if (transforms.size() != table.roots.size())
    return invalid(fmt::format("root transforms: room for {} strands, but the skin table has {}",
                               transforms.size(), table.roots.size()));
  for (size_t i = 0; i < table.roots.size(); ++i) {
    const SurfaceRoot& root = table.roots[i];
    Vector bindAt[3], nowAt[3];
    for (size_t k = 0; k < 3; ++k) {
      if (root.part >= vertices.size() || root.corners[k] >= vertices[root.part].size())
        return invalid(fmt::format(
            "root transforms: strand {} needs vertex {} of part {} ('{}'), which has {}", i,
            root.corners[k], root.part,
            root.part < table.parts.size() ? table.parts[root.part].name : std::string(),
            root.part < vertices.size() ? vertices[root.part].size() : 0));
      bindAt[k] = toVector(root.bind[k]);
      nowAt[k] = toVector(vertices[root.part][root.corners[k]]);
    }
    const auto bind = detail::triangleFrame(bindAt[0], bindAt[1], bindAt[2]);
    const auto now = detail::triangleFrame(nowAt[0], nowAt[1], nowAt[2]);
    if (!bind || !now) continue;
    const AffineTransform transform = motion(root, *bind, bindAt, *now, nowAt);
    if (isFinite(transform)) transforms[i] = transform;
  }
  return {};
}

}  // namespace

Result<void> validate(const SkinTable& table) {
  return detail::guarded([&] { return check(table); });
}

Result<SkinTable> loadTfxSkin(std::span<const std::byte> bytes, std::string_view name,
                              uint32_t strandCount) {
  return detail::guarded([&] { return loadTable(bytes, name, strandCount); });
}

Result<SkinTable> loadTfxSkin(ByteSource& source, std::string_view name, uint32_t strandCount) {
  auto bytes = readAll(source, name);
  if (!bytes) return bytes.error();
  return loadTfxSkin(*bytes, name, strandCount);
}

Result<SkinTable> loadTfxSkin(const std::filesystem::path& path, uint32_t strandCount) {
  return detail::guarded([&]() -> Result<SkinTable> {
    auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return loadTable(*bytes, path.string(), strandCount);
  });
}

Result<std::vector<std::byte>> saveTfxSkin(const SkinTable& table) {
  return detail::guarded([&] { return saveTable(table); });
}

Result<void> saveTfxSkin(const SkinTable& table, const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    auto bytes = saveTable(table);
    if (!bytes) return bytes.error();
    return detail::writeFile(path, *bytes);
  });
}

Float3 bindPosition(const SurfaceRoot& root) {
  const Vector a = toVector(root.bind[0]), b = toVector(root.bind[1]), c = toVector(root.bind[2]);
  Vector at = weightedMean(root.barycentric, a, b, c);
  if (const auto frame = detail::triangleFrame(a, b, c))
    at += frame->toSpace(toVector(root.offset));
  return {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
}

Result<void> rootTransforms(const SkinTable& table,
                            std::span<const std::span<const Float3>> vertices,
                            std::span<AffineTransform> transforms) {
  return detail::guarded([&] { return follow(table, vertices, transforms); });
}

std::vector<BoneInfluences> oneBoneAStrand(uint32_t strandCount) {
  std::vector<BoneInfluences> influences(strandCount);
  for (uint32_t i = 0; i < strandCount; ++i) influences[i] = {{i, i, i, i}, {1, 0, 0, 0}};
  return influences;
}

}  // namespace pelage
