// Writes .usda files, and beside them expected.json with the numbers that are in them, for
// read_usd.mjs: write_usd FOLDER.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/usd_curves.h"

namespace {

using namespace pelage;
using Frames = std::vector<std::vector<Float3>>;

constexpr int64_t kFirst = 1001;

// Large and small coordinates of both signs, with all their digits.
Frames makeFrames(size_t vertices) {
  Frames frames;
  for (int f = 0; f < 5; ++f) {
    auto& frame = frames.emplace_back();
    for (size_t v = 0; v < vertices; ++v) {
      const auto phase = static_cast<float>(f + 3 * static_cast<int>(v));
      frame.push_back({std::sin(phase), 1e-5f * std::cos(phase), 1e5f * std::sin(0.1f * phase)});
    }
  }
  return frames;
}

Result<void> write(const std::filesystem::path& path, UsdCurvesDef def, int64_t first,
                   std::span<const std::vector<Float3>> frames) {
  def.firstFrame = first;
  auto writer = UsdCurvesWriter::create(path, std::move(def));
  if (!writer) return writer.error();
  for (const auto& frame : frames)
    if (auto r = writer->append(frame); !r) return r;
  return writer->close();
}

void writeExpected(const std::filesystem::path& path, const UsdCurvesDef& def,
                   const Frames& frames) {
  nlohmann::json json = {{"firstFrame", kFirst},
                         {"framesPerSecond", def.framesPerSecond},
                         {"vertexCounts", def.vertexCounts},
                         {"widths", def.widths},
                         {"ids", def.strandIds}};
  for (const auto& frame : frames) {
    nlohmann::json points = nlohmann::json::array();
    for (const Float3& p : frame)
      for (const float x : {p.x, p.y, p.z}) points.push_back(x);
    json["points"].push_back(points);
  }
  std::ofstream(path) << json;
}

Result<void> writeAll(const std::filesystem::path& folder) {
  UsdCurvesDef def;
  def.vertexCounts = {3, 2, 4};
  def.widths = {1e-4f, 8e-5f, 6.5e-5f};
  def.strandIds = {7, 0, (uint64_t{1} << 53) - 1};
  def.framesPerSecond = 23.976;
  const Frames frames = makeFrames(9);
  const std::span<const std::vector<Float3>> all(frames);
  if (auto r = write(folder / "shot.usda", def, kFirst, all); !r) return r;
  if (auto r = write(folder / "part0.usda", def, kFirst, all.first(2)); !r) return r;
  if (auto r = write(folder / "part1.usda", def, kFirst + 2, all.subspan(2)); !r) return r;
  const UsdClip clips[] = {{"./part0.usda", kFirst, 2}, {"./part1.usda", kFirst + 2, 3}};
  writeExpected(folder / "expected.json", def, frames);
  HairCurves curves;
  curves.vertexCounts = def.vertexCounts;
  curves.positions = frames[0];
  for (const float width : {1e-4f, 8e-5f, 6.5e-5f})
    curves.radii.resize(curves.radii.size() + 3, width / 2);
  curves.colors.assign(9, {0.5f, 0.25f, 0.125f, 1});
  curves.strandUv = {{0, 0.5f}, {0.25f, 1}, {1, 0}};
  curves.labels = {{7, 0, true}, {0, 3, false}, {(uint64_t{1} << 53) - 1, 3, true}};
  if (auto r = saveUsdCurves(curves, folder / "groom.usda"); !r) return r;
  return saveUsdClips(folder / "clips.usda", def, clips);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_usd FOLDER\n");
    return 1;
  }
  const auto done = writeAll(argv[1]);
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
