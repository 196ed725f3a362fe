#include "bone_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "common/finite.h"
#include "json_members.h"
#include "pelage/skeleton.h"
#include "pelage/stream.h"
#include "sample_time.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

constexpr size_t kMaxBones = 1u << 16;

// 12 numbers, row by row.
std::optional<AffineTransform> transformOf(const json& from) {
  if (!from.is_array() || from.size() != 12) return std::nullopt;
  std::array<float, 12> numbers = {};
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!from[i].is_number()) return std::nullopt;
    numbers[i] = from[i].get<float>();
  }
  const auto transform = std::bit_cast<AffineTransform>(numbers);
  if (!tools::isFinite(transform)) return std::nullopt;
  return transform;
}

struct StreamHeader {
  double framesPerSecond = 24;
  std::vector<std::string> bones;
  std::vector<AffineTransform> bindInverses;  ///< [bone], or empty
  Path data;
};

void readBones(JsonMembers& root, JsonFaults& faults, StreamHeader& header) {
  header.bones = root.texts("bones");
  if (header.bones.empty() || header.bones.size() > kMaxBones)
    root.fault("bones", fmt::format("must be 1 to {} names", kMaxBones));
  std::set<std::string_view> names;
  for (const std::string& name : header.bones)
    if (!names.insert(name).second) root.fault("bones", fmt::format("has '{}' twice", name));
  const json* binds = root.array("bind");
  if (binds == nullptr) return;
  if (binds->size() != header.bones.size())
    root.fault("bind", "must have a transform for each of \"bones\"");
  for (size_t i = 0; i < binds->size(); ++i) {
    const auto bind = transformOf((*binds)[i]);
    const auto inverted = bind ? inverse(*bind) : std::nullopt;
    if (!inverted)
      faults.add(fmt::format("/bind/{}", i),
                 "must be 12 finite numbers, three rows of [M | t], and M must have an inverse");
    header.bindInverses.push_back(inverted.value_or(AffineTransform()));
  }
}

Result<StreamHeader> loadHeader(const Path& path) {
  const auto loaded = loadJson(path.string());
  if (!loaded) return loaded.error();
  JsonFaults faults = {path.string(), {}};
  JsonMembers root(*loaded, "", faults);
  StreamHeader header;
  (void)root.integer("version", 1, 1);
  header.framesPerSecond = root.number("fps", 1e-3, 1e6);
  readBones(root, faults, header);
  header.data = path.parent_path() / root.text("data");
  root.finish();
  if (auto fine = faults.result(); !fine) return fine.error();
  return header;
}

AffineTransform linearPartOf(AffineTransform transform) {
  for (Float4& row : transform.rows) row.w = 0;
  return transform;
}

float mix(float a, float b, double share) {
  return static_cast<float>(a + (static_cast<double>(b) - a) * share);
}

// On the shortest arc, at equal speed: halves the arc until it is a line. This takes square roots
// alone, which have the same bits on every machine, and the sines of the C library have not.
Quaternion slerp(const Float4& from, const Float4& to, double share) {
  std::array<double, 4> a = {from.x, from.y, from.z, from.w}, b = {to.x, to.y, to.z, to.w};
  if (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0)
    for (double& x : b) x = -x;
  for (int halves = 0; halves < 24; ++halves) {
    std::array<double, 4> middle = {};
    for (size_t i = 0; i < 4; ++i) middle[i] = a[i] + b[i];
    const double length = std::sqrt(middle[0] * middle[0] + middle[1] * middle[1] +
                                    middle[2] * middle[2] + middle[3] * middle[3]);
    for (double& x : middle) x /= length;
    share *= 2;
    if (share < 1) {
      b = middle;
    } else {
      a = middle;
      share -= 1;
    }
  }
  const auto mixed = [&](size_t i) { return static_cast<float>(a[i] + (b[i] - a[i]) * share); };
  return {mixed(0), mixed(1), mixed(2), mixed(3)};
}

// M = R S of both, with the rotation R next to M.
AffineTransform between(const AffineTransform& a, const AffineTransform& b, double share) {
  const Float4 first = toDualQuaternion(a).real, second = toDualQuaternion(b).real;
  const auto stretchOf = [](const AffineTransform& of, const Float4& rotation) {
    return multiply(rigidTransform({-rotation.x, -rotation.y, -rotation.z, rotation.w}, {}),
                    linearPartOf(of));
  };
  AffineTransform stretch = stretchOf(a, first);
  const AffineTransform other = stretchOf(b, second);
  for (int i = 0; i < 3; ++i) {
    Float4& row = stretch.rows[i];
    row = {mix(row.x, other.rows[i].x, share), mix(row.y, other.rows[i].y, share),
           mix(row.z, other.rows[i].z, share), 0};
  }
  const Float3 translation = {mix(a.rows[0].w, b.rows[0].w, share),
                              mix(a.rows[1].w, b.rows[1].w, share),
                              mix(a.rows[2].w, b.rows[2].w, share)};
  return multiply(rigidTransform(slerp(first, second, share), translation), stretch);
}

Result<void> readAll(FileSource& file, const Path& path, std::span<std::byte> out) {
  for (size_t at = 0; at < out.size();) {
    const size_t got = file.read(at, out.subspan(at));
    if (got == 0)
      return Error{ErrorCode::kInvalidFile,
                   fmt::format("{}: byte {}: cannot be read", path.string(), at)};
    at += got;
  }
  return {};
}

}  // namespace

Result<Path> dataOfBoneStream(const Path& path) {
  auto header = loadHeader(path);
  if (!header) return header.error();
  return std::move(header->data);
}

Result<BoneStream> loadBoneStream(const Path& path) {
  auto header = loadHeader(path);
  if (!header) return header.error();
  auto file = FileSource::open(header->data);
  if (!file) return file.error();
  BoneStream stream = {header->framesPerSecond, std::move(header->bones), {}};
  const std::string name = header->data.string();
  const uint64_t frameBytes = stream.bones.size() * sizeof(AffineTransform), size = file->size();
  if (size == 0 || size % frameBytes != 0)
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: has {} bytes, which are no whole frames of {} bones, {} bytes "
                             "each: 12 floats a bone",
                             name, size, stream.bones.size(), frameBytes)};
  stream.transforms.resize(size / sizeof(AffineTransform));
  if (auto done =
          readAll(*file, header->data, std::as_writable_bytes(std::span(stream.transforms)));
      !done)
    return done.error();
  for (size_t i = 0; i < stream.transforms.size(); ++i) {
    const size_t bone = i % stream.bones.size();
    if (!tools::isFinite(stream.transforms[i]))
      return Error{
          ErrorCode::kInvalidFile,
          fmt::format("{}: byte {}: frame {}: the transform of '{}' is not finite", name,
                      i * sizeof(AffineTransform), i / stream.bones.size(), stream.bones[bone])};
    if (!header->bindInverses.empty())
      stream.transforms[i] = multiply(stream.transforms[i], header->bindInverses[bone]);
  }
  return stream;
}

std::vector<AffineTransform> transformsAt(const BoneStream& stream, double seconds) {
  const size_t bones = stream.bones.size();
  const SampleTime at = sampleAt(seconds * stream.framesPerSecond, stream.frameCount());
  const auto first = stream.transforms.begin() + static_cast<ptrdiff_t>(at.sample * bones);
  std::vector<AffineTransform> out(first, first + static_cast<ptrdiff_t>(bones));
  if (at.share > 0)
    for (size_t i = 0; i < bones; ++i)
      out[i] = between(out[i], first[static_cast<ptrdiff_t>(bones + i)], at.share);
  return out;
}

}  // namespace pelage::bake
