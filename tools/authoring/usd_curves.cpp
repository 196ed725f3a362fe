#include "pelage/authoring/usd_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <future>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "binary_file.h"
#include "common/errors.h"
#include "common/finite.h"
#include "pelage/authoring/hair_files.h"

namespace pelage {
namespace {

constexpr int64_t kMaxFrameNumber = int64_t{1} << 40;
constexpr size_t kMaxName = 255;
// Room for the last time code, which is known in the end: digits, sign and spaces.
constexpr int kTimeDigits = 16;

Error invalidUsd(std::string_view what) {
  return tools::invalid(fmt::format("USD curves: {}", what));
}

bool isIdentifier(std::string_view name) {
  const auto isLetter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  return !name.empty() && name.size() <= kMaxName && isLetter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return isLetter(c) || (c >= '0' && c <= '9'); });
}

uint64_t verticesOf(const UsdCurvesDef& def) {
  uint64_t count = 0;
  for (const uint32_t vertices : def.vertexCounts) count += vertices;
  return count;
}

using Extent = std::array<Float3, 2>;  // lowest and highest corner

Extent extentOf(std::span<const Float3> positions) {
  Extent extent = {positions[0], positions[0]};
  auto& [low, high] = extent;
  for (const Float3& p : positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return extent;
}

// Text of a file, in parts.
using Text = fmt::memory_buffer;

template <class... Args>
void add(Text& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

void addVector(Text& text, const Float3& v) { add(text, "({}, {}, {})", v.x, v.y, v.z); }

template <class T>
void addNumbers(Text& text, std::span<const T> numbers) {
  text.push_back('[');
  for (size_t i = 0; i < numbers.size(); ++i) add(text, "{}{}", i > 0 ? ", " : "", numbers[i]);
  text.push_back(']');
}

// An attribute with metadata.
template <class T, class Write>
void addValues(Text& text, std::string_view declaration, std::span<const T> values,
               std::string_view interpolation, Write write) {
  add(text, "    {} = [", declaration);
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text.append(std::string_view(", "));
    write(values[i]);
  }
  add(text, "] (\n        interpolation = \"{}\"\n    )\n", interpolation);
}

// The metadata of a layer. \param endTime as it is to be printed
void addLayer(Text& text, const UsdCurvesDef& def, int64_t startTime, std::string_view endTime) {
  add(text,
      "#usda 1.0\n(\n    defaultPrim = \"{}\"\n    endTimeCode = {}\n    framesPerSecond = {}\n"
      "    metersPerUnit = 1\n    startTimeCode = {}\n    timeCodesPerSecond = {}\n"
      "    upAxis = \"Y\"\n)\n\n",
      def.name, endTime, def.framesPerSecond, startTime, def.framesPerSecond);
}

const char* interpolationOf(const UsdCurvesDef& def) {
  if (def.widths.size() == 1) return "constant";
  return def.widths.size() == def.vertexCounts.size() ? "uniform" : "vertex";
}

// Adds the attributes that are the same in all frames.
void addConstants(Text& text, const UsdCurvesDef& def) {
  text.append(std::string_view("    int[] curveVertexCounts = "));
  addNumbers(text, std::span(def.vertexCounts));
  text.append(std::string_view(
      "\n    uniform token type = \"linear\"\n    uniform token wrap = \"nonperiodic\"\n"));
  if (!def.widths.empty()) {
    text.append(std::string_view("    float[] widths = "));
    addNumbers(text, std::span(def.widths));
    add(text, " (\n        interpolation = \"{}\"\n    )\n", interpolationOf(def));
  }
  if (!def.strandIds.empty()) {
    text.append(std::string_view("    int64[] primvars:id = "));
    addNumbers(text, std::span(def.strandIds));
    text.append(std::string_view(" (\n        interpolation = \"uniform\"\n    )\n"));
  }
}

std::filesystem::path withSuffix(std::filesystem::path path, const char* suffix) {
  path += suffix;
  return path;
}

}  // namespace

namespace detail {

// Writes the text of vectors by several threads, which changes no byte.
class VectorText {
 public:
  explicit VectorText(uint32_t threads)
      : threads_(std::max(threads, 1u)), pieces_(size_t{kPiecesEach} * threads_) {}

  /// Threads that have something to do for so many vectors.
  static size_t pieceCount(size_t vectors) { return (vectors + kPiece - 1) / kPiece; }

  void add(Text& text, std::span<const Float3> vectors) {
    text.push_back('[');
    for (size_t first = 0; first < vectors.size(); first += pieces_.size() * kPiece) {
      const size_t count = std::min(pieces_.size(), pieceCount(vectors.size() - first));
      std::atomic<size_t> next = 0;
      const auto work = [&] {
        for (size_t piece = next++; piece < count; piece = next++)
          write(pieces_[piece], vectors, first + piece * kPiece);
      };
      std::vector<std::future<void>> others;
      while (others.size() + 1 < std::min<size_t>(threads_, count))
        others.push_back(std::async(work));
      work();
      for (std::future<void>& other : others) other.get();
      for (size_t i = 0; i < count; ++i) text.append(pieces_[i].begin(), pieces_[i].end());
    }
    text.push_back(']');
  }

 private:
  static constexpr size_t kPiece = 4096;  ///< vectors that a thread writes at a time
  static constexpr uint32_t kPiecesEach = 4;

  // A piece, with the comma that separates it from the one before it.
  static void write(Text& text, std::span<const Float3> vectors, size_t begin) {
    text.clear();
    for (size_t i = begin; i < std::min(begin + kPiece, vectors.size()); ++i) {
      if (i > 0) text.append(std::string_view(", "));
      addVector(text, vectors[i]);
    }
  }

  uint32_t threads_;
  std::vector<Text> pieces_;
};

// A file that is removed unless it is kept.
class PartialFile {
 public:
  explicit PartialFile(std::filesystem::path path) : path_(std::move(path)) {
    file_.open(path_, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  ~PartialFile() {
    if (path_.empty()) return;
    file_.close();
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  std::fstream& stream() { return file_; }
  Result<void> check(const char* what) const {
    if (file_) return {};
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: {}", path_.string(), what)};
  }
  Result<void> write(Text& text) {
    file_.write(text.data(), static_cast<std::streamsize>(text.size()));
    text.clear();
    return check("cannot be written; is the disk full?");
  }
  Result<void> rename(const std::filesystem::path& to) {
    file_.close();
    if (auto r = check("cannot be written; is the disk full?"); !r) return r;
    std::error_code error;
    std::filesystem::rename(path_, to, error);
    if (error)
      return Error{ErrorCode::kFileNotFound,
                   fmt::format("{}: {}", path_.string(), error.message())};
    path_.clear();
    return {};
  }

 private:
  std::filesystem::path path_;
  std::fstream file_;
};

}  // namespace detail

Result<void> validate(const UsdCurvesDef& def) {
  if (!isIdentifier(def.name))
    return invalidUsd(
        fmt::format("'{}' is no name of a prim: letters, digits and _, no digit first",
                    def.name.substr(0, kMaxName)));
  if (def.vertexCounts.empty()) return invalidUsd("there are no strands");
  for (size_t s = 0; s < def.vertexCounts.size(); ++s)
    if (def.vertexCounts[s] < 2)
      return invalidUsd(fmt::format("strand {} has {} vertices; linear curves have at least 2", s,
                                    def.vertexCounts[s]));
  const uint64_t vertices = verticesOf(def);
  if (vertices > std::numeric_limits<int32_t>::max())
    return invalidUsd("more than 2^31 - 1 vertices");
  if (!def.widths.empty() && def.widths.size() != 1 &&
      def.widths.size() != def.vertexCounts.size() && def.widths.size() != vertices)
    return invalidUsd(fmt::format(
        "{} widths, which is neither 1 nor the number of strands or vertices", def.widths.size()));
  for (const float width : def.widths)
    if (!(width >= 0 && std::isfinite(width)))
      return invalidUsd("a width is negative or not finite");
  if (!def.strandIds.empty() && def.strandIds.size() != def.vertexCounts.size())
    return invalidUsd("strandIds has not one id a strand");
  for (const uint64_t id : def.strandIds)
    if (id > std::numeric_limits<int64_t>::max()) return invalidUsd("an id is 2^63 or more");
  if (!(def.framesPerSecond >= 1e-3 && def.framesPerSecond <= 1e6))
    return invalidUsd("framesPerSecond is not within 1e-3..1e6");
  if (def.firstFrame < -kMaxFrameNumber || def.firstFrame > kMaxFrameNumber)
    return invalidUsd("firstFrame is not within +-2^40");
  return {};
}

namespace {

constexpr float kMaxRadius = 1e30f;
constexpr uint32_t kMaxGroups = 1u << 24;  // whole numbers of a float

Result<void> checkCurves(const HairCurves& curves, std::string_view prim) {
  if (!isIdentifier(prim))
    return invalidUsd(fmt::format("'{}' is no name of a prim", prim.substr(0, kMaxName)));
  if (auto r = validate(curves); !r) return r;
  if (curves.vertexCounts.empty()) return invalidUsd("there are no curves");
  for (const float radius : curves.radii)
    if (!(std::abs(radius) <= kMaxRadius)) return invalidUsd("a radius is above 1e30");
  for (const CurveLabel& label : curves.labels)
    if (label.id > std::numeric_limits<int64_t>::max() || label.group >= kMaxGroups)
      return invalidUsd("the id of a curve is 2^63 or more, or a group 2^24 or more");
  return {};
}

// Shapes, then what they look like, then their labels.
Result<std::string> curvesText(const HairCurves& curves, std::string_view prim) {
  if (auto r = checkCurves(curves, prim); !r) return r.error();
  Text text;
  add(text,
      "#usda 1.0\n(\n    defaultPrim = \"{}\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
      "def BasisCurves \"{}\"\n{{\n    int[] curveVertexCounts = ",
      prim, prim);
  addNumbers(text, std::span(curves.vertexCounts));
  auto [low, high] = extentOf(curves.positions);
  float largest = 0;
  for (const float radius : curves.radii) largest = std::max(largest, radius);
  text.append(std::string_view("\n    float3[] extent = ["));
  addVector(text, {low.x - largest, low.y - largest, low.z - largest});
  text.append(std::string_view(", "));
  addVector(text, {high.x + largest, high.y + largest, high.z + largest});
  text.append(std::string_view("]\n    point3f[] points = ["));
  for (size_t i = 0; i < curves.positions.size(); ++i) {
    if (i > 0) text.append(std::string_view(", "));
    addVector(text, curves.positions[i]);
  }
  text.append(std::string_view(
      "]\n    uniform token type = \"linear\"\n    uniform token wrap = \"nonperiodic\"\n"));
  const auto addNumber = [&](const auto& number) { add(text, "{}", number); };
  const auto addUv = [&](const Float2& uv) { add(text, "({}, {})", uv.x, uv.y); };
  const auto addAll = [&](std::string_view declaration, const auto& values, std::string_view per,
                          auto write) {
    if (!values.empty()) addValues(text, declaration, std::span(values), per, write);
  };
  addAll("float[] widths", curves.radii, "vertex", [&](float r) { add(text, "{}", 2 * r); });
  addAll("float[] primvars:pelage:inverseMass", curves.inverseMasses, "vertex", addNumber);
  addAll("color3f[] primvars:displayColor", curves.colors, "vertex", [&](const Float4& c) {
    addVector(text, {c.x, c.y, c.z});
  });
  addAll("float[] primvars:displayOpacity", curves.colors, "vertex",
         [&](const Float4& c) { add(text, "{}", c.w); });
  addAll("texCoord2f[] primvars:st", curves.vertexUv, "vertex", addUv);
  addAll("float2[] primvars:groom_root_uv", curves.strandUv, "uniform", addUv);
  addAll("int64[] primvars:groom_id", curves.labels, "uniform",
         [&](const CurveLabel& label) { add(text, "{}", label.id); });
  addAll("int[] primvars:groom_guide", curves.labels, "uniform",
         [&](const CurveLabel& label) { add(text, "{}", label.isGuide ? 1 : 0); });
  addAll("int[] primvars:groom_group_id", curves.labels, "uniform",
         [&](const CurveLabel& label) { add(text, "{}", label.group); });
  text.append(std::string_view("}\n"));
  return std::string(text.data(), text.size());
}

}  // namespace

Result<std::string> saveUsdCurves(const HairCurves& curves) {
  return tools::guarded([&] { return curvesText(curves, "hair"); });
}

Result<void> saveUsdCurves(const HairCurves& curves, const std::filesystem::path& path,
                           std::string_view prim) {
  return tools::guarded([&]() -> Result<void> {
    auto text = curvesText(curves, prim);
    if (!text) return text.error();
    return tools::writeFile(path, std::as_bytes(std::span(*text)));
  });
}

struct UsdCurvesWriter::Impl {
  Impl(std::filesystem::path p, UsdCurvesDef d, uint32_t threads)
      : path(std::move(p)),
        def(std::move(d)),
        vertexCount(verticesOf(def)),
        vectors(static_cast<uint32_t>(
            std::min<uint64_t>(threads, detail::VectorText::pieceCount(vertexCount)))),
        file(withSuffix(path, ".partial")) {
    if (def.velocities) velocities.emplace(withSuffix(path, ".velocities.partial"));
  }

  std::filesystem::path path;
  UsdCurvesDef def;
  uint64_t vertexCount;
  detail::VectorText vectors;
  detail::PartialFile file;
  std::optional<detail::PartialFile> velocities;
  std::streamoff endTimeAt = 0;  ///< where the last time code is to be
  int64_t frameCount = 0;
  bool closed = false;
  std::vector<Float3> beforeLast, last, velocity;
  std::vector<Extent> extents;  ///< [frame] without widths
  Text text;

  Result<void> begin();
  Result<void> append(std::span<const Float3> positions);
  Result<void> addVelocities(int64_t frame, std::span<const Float3> from,
                             std::span<const Float3> to, int frames);
  void addExtents();
  Result<void> addVelocitySamples();
  Result<void> close();
};

Result<void> UsdCurvesWriter::Impl::begin() {
  if (auto r = file.check("cannot be created; check the folder and its permissions"); !r) return r;
  if (velocities)
    if (auto r = velocities->check("cannot be created"); !r) return r;
  const std::string room(kTimeDigits, ' ');
  addLayer(text, def, def.firstFrame, room);
  endTimeAt =
      static_cast<std::streamoff>(std::string_view(text.data(), text.size()).find("= " + room)) + 2;
  add(text, "def BasisCurves \"{}\"\n{{\n", def.name);
  addConstants(text, def);
  text.append(std::string_view("    point3f[] points.timeSamples = {\n"));
  return file.write(text);
}

// The sample of a frame, from the change over some frames around it.
Result<void> UsdCurvesWriter::Impl::addVelocities(int64_t frame, std::span<const Float3> from,
                                                  std::span<const Float3> to, int frames) {
  const double perSecond = frames > 0 ? def.framesPerSecond / frames : 0;
  const auto speed = [&](float a, float b) {
    return static_cast<float>((static_cast<double>(b) - static_cast<double>(a)) * perSecond);
  };
  velocity.resize(from.size());
  for (size_t i = 0; i < from.size(); ++i) {
    velocity[i] = {speed(from[i].x, to[i].x), speed(from[i].y, to[i].y), speed(from[i].z, to[i].z)};
    if (!tools::isFinite(velocity[i]))
      return invalidUsd(fmt::format("frame {}: the velocity of vertex {} is not finite",
                                    def.firstFrame + frame, i));
  }
  add(text, "        {}: ", def.firstFrame + frame);
  vectors.add(text, velocity);
  text.append(std::string_view(",\n"));
  return velocities->write(text);
}

Result<void> UsdCurvesWriter::Impl::append(std::span<const Float3> positions) {
  if (closed) return invalidUsd("the writer is closed");
  if (positions.size() != vertexCount)
    return invalidUsd(fmt::format("{} positions for {} vertices", positions.size(), vertexCount));
  const auto broken = std::find_if_not(positions.begin(), positions.end(),
                                       [](const Float3& p) { return tools::isFinite(p); });
  if (broken != positions.end())
    return invalidUsd(fmt::format("frame {}: vertex {} is not finite", def.firstFrame + frameCount,
                                  broken - positions.begin()));
  if (velocities && frameCount > 0) {
    const bool central = frameCount > 1;
    if (auto r =
            addVelocities(frameCount - 1, central ? beforeLast : last, positions, central ? 2 : 1);
        !r)
      return r;
  }
  add(text, "        {}: ", def.firstFrame + frameCount);
  vectors.add(text, positions);
  text.append(std::string_view(",\n"));
  extents.push_back(extentOf(positions));
  ++frameCount;
  beforeLast.swap(last);
  last.assign(positions.begin(), positions.end());
  return file.write(text);
}

void UsdCurvesWriter::Impl::addExtents() {
  const float radius =
      def.widths.empty() ? 0 : *std::max_element(def.widths.begin(), def.widths.end()) / 2;
  text.append(std::string_view("    float3[] extent.timeSamples = {\n"));
  for (size_t f = 0; f < extents.size(); ++f) {
    const auto& [low, high] = extents[f];
    add(text, "        {}: [", def.firstFrame + static_cast<int64_t>(f));
    addVector(text, {low.x - radius, low.y - radius, low.z - radius});
    text.append(std::string_view(", "));
    addVector(text, {high.x + radius, high.y + radius, high.z + radius});
    text.append(std::string_view("],\n"));
  }
  text.append(std::string_view("    }\n"));
}

// Copies the samples behind the points.
Result<void> UsdCurvesWriter::Impl::addVelocitySamples() {
  const bool several = frameCount > 1;
  if (auto r = addVelocities(frameCount - 1, several ? beforeLast : last, last, several ? 1 : 0);
      !r)
    return r;
  text.append(std::string_view("    vector3f[] velocities.timeSamples = {\n"));
  if (auto r = file.write(text); !r) return r;
  std::fstream& from = velocities->stream();
  from.seekg(0);
  file.stream() << from.rdbuf();
  text.append(std::string_view("    }\n"));
  return file.check("cannot be written; is the disk full?");
}

Result<void> UsdCurvesWriter::Impl::close() {
  if (closed) return invalidUsd("the writer is closed");
  if (frameCount == 0) return invalidUsd("no frame was added");
  closed = true;
  text.append(std::string_view("    }\n"));
  if (auto r = file.write(text); !r) return r;
  if (velocities)
    if (auto r = addVelocitySamples(); !r) return r;
  addExtents();
  text.append(std::string_view("}\n"));
  if (auto r = file.write(text); !r) return r;
  file.stream().seekp(endTimeAt);
  add(text, "{}", def.firstFrame + frameCount - 1);
  if (auto r = file.write(text); !r) return r;
  return file.rename(path);
}

UsdCurvesWriter::UsdCurvesWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
UsdCurvesWriter::UsdCurvesWriter(UsdCurvesWriter&&) noexcept = default;
UsdCurvesWriter& UsdCurvesWriter::operator=(UsdCurvesWriter&&) noexcept = default;
UsdCurvesWriter::~UsdCurvesWriter() = default;

Result<UsdCurvesWriter> UsdCurvesWriter::create(const std::filesystem::path& path, UsdCurvesDef def,
                                                uint32_t threads) {
  return tools::guarded([&]() -> Result<UsdCurvesWriter> {
    if (auto r = validate(def); !r) return r.error();
    auto impl = std::make_unique<Impl>(path, std::move(def), threads);
    if (auto r = impl->begin(); !r) return r.error();
    return UsdCurvesWriter(std::move(impl));
  });
}

Result<void> UsdCurvesWriter::append(std::span<const Float3> positions) {
  return tools::guarded([&] { return impl_->append(positions); });
}
Result<void> UsdCurvesWriter::close() {
  return tools::guarded([&] { return impl_->close(); });
}

namespace {

Result<void> checkClips(std::span<const UsdClip> clips) {
  if (clips.empty()) return invalidUsd("there are no clips");
  for (size_t i = 0; i < clips.size(); ++i) {
    const UsdClip& clip = clips[i];
    const auto isBad = [](unsigned char c) { return c == '@' || c < 0x20 || c == 0x7f; };
    if (clip.file.empty() || std::any_of(clip.file.begin(), clip.file.end(), isBad))
      return invalidUsd(fmt::format("clip {} has no file that USD can name", i));
    if (clip.frameCount < 1 || clip.frameCount > kMaxFrameNumber ||
        clip.firstFrame < -kMaxFrameNumber || clip.firstFrame > kMaxFrameNumber)
      return invalidUsd(fmt::format("clip {} has no frames, or too many", i));
    if (i > 0 &&
        clip.firstFrame != clips[i - 1].firstFrame + static_cast<int64_t>(clips[i - 1].frameCount))
      return invalidUsd(fmt::format("clip {} does not begin where the one before it ends", i));
  }
  return {};
}

// The names that are in the clips.
void addManifest(Text& text, const UsdCurvesDef& def) {
  add(text, "#usda 1.0\n(\n    defaultPrim = \"{}\"\n)\n\n", def.name);
  add(text, "over \"{}\"\n{{\n    float3[] extent\n    point3f[] points\n", def.name);
  if (def.velocities) text.append(std::string_view("    vector3f[] velocities\n"));
  text.append(std::string_view("}\n"));
}

void addRoot(Text& text, const UsdCurvesDef& def, std::span<const UsdClip> clips,
             std::string_view manifest) {
  const int64_t first = clips.front().firstFrame;
  const int64_t last = clips.back().firstFrame + static_cast<int64_t>(clips.back().frameCount) - 1;
  addLayer(text, def, first, std::to_string(last));
  add(text,
      "def BasisCurves \"{}\" (\n    clips = {{\n        dictionary default = {{\n"
      "            double2[] active = [",
      def.name);
  for (size_t i = 0; i < clips.size(); ++i)
    add(text, "{}({}, {})", i > 0 ? ", " : "", clips[i].firstFrame, i);
  text.append(std::string_view("]\n            asset[] assetPaths = ["));
  for (size_t i = 0; i < clips.size(); ++i) add(text, "{}@{}@", i > 0 ? ", " : "", clips[i].file);
  // The time of a clip is that of the shot.
  add(text,
      "]\n            asset manifestAssetPath = @./{}@\n            string primPath = \"/{}\"\n"
      "            double2[] times = [({}, {})",
      manifest, def.name, first, first);
  if (last > first) add(text, ", ({}, {})", last, last);
  text.append(std::string_view("]\n        }\n    }\n)\n{\n"));
  addConstants(text, def);
  text.append(std::string_view("}\n"));
}

Result<void> saveClips(const std::filesystem::path& path, const UsdCurvesDef& def,
                       std::span<const UsdClip> clips) {
  if (auto r = validate(def); !r) return r;
  if (auto r = checkClips(clips); !r) return r;
  const std::string manifest = path.stem().string() + ".manifest.usda";
  Text text;
  addManifest(text, def);
  const auto bytes = [&] { return std::as_bytes(std::span(text.data(), text.size())); };
  if (auto r = tools::writeFile(path.parent_path() / manifest, bytes()); !r) return r;
  text.clear();
  addRoot(text, def, clips, manifest);
  return tools::writeFile(path, bytes());
}

}  // namespace

Result<void> saveUsdClips(const std::filesystem::path& path, const UsdCurvesDef& def,
                          std::span<const UsdClip> clips) {
  return tools::guarded([&] { return saveClips(path, def, clips); });
}

}  // namespace pelage
