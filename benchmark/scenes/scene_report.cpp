#include "scenes/scene_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/csv_file.h"

namespace bench {

using pelage::DeviceInfo;
using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr const char* kCsvHeader =
    "commit,api,scene,solver,colliding_hair,guides,follow_hairs,vertices_per_strand,vertices,"
    "frames,frame_us_median,frame_us_mean,simulation_us_median,simulation_us_mean,sdf_us_median,"
    "sdf_us_mean,ratio_to_baseline_median,ratio_to_baseline_mean,stretch_max_percent,"
    "penetration_max_mm,penetration_p999_mm,judged_vertices,strands_rooted_inside,broken_strands,"
    "counters,"
    "reference_us_before,reference_us_after,runs,device,driver\n";
constexpr const char* kScenePassCsvHeader =
    "commit,api,scene,solver,colliding_hair,pass,builds_sdf,us_median,us_mean,passes_a_frame,"
    "device,driver\n";
constexpr const char* kFirstFrameCsvHeader =
    "commit,api,scene,solver,colliding_hair,first_frame_ms,device,driver\n";

const char* collidingHair(const SceneRow& row) {
  return row.followsCollide ? "guides and follow hairs" : "guides";
}

std::string csvStart(const SceneRow& row, const DeviceInfo& device, const std::string& commit) {
  return fmt::format("{},{},{},{},{}", commit, pelage::apiName(device.api), row.scene,
                     rowSolverName(row.solver), collidingHair(row));
}

// "name value; name value"
std::string countersText(const std::vector<Counter>& counters) {
  std::string text;
  for (const Counter& counter : counters)
    text += fmt::format("{}{} {:.1f}", text.empty() ? "" : "; ", counter.name, counter.value);
  return text;
}

std::string csvRow(const SceneResult& r) {
  const SceneErrors& e = r.errors;
  const bool timed = r.figures.isTimed(), collides = e.judgedVertices > 0;
  const auto spread = [&](const Spread& s) {
    return csvNumber(s.median, timed) + "," + csvNumber(s.mean, timed);
  };
  return fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{:.6g},{},{},{},{},{},\"{}\",{},{},{}", r.guides,
      r.followHairs, r.verticesPerStrand, r.vertices, r.figures.frames(), spread(r.figures.frame()),
      spread(r.figures.of(PassGroup::kSimulation)), spread(r.figures.of(PassGroup::kSdf)),
      csvNumber(r.ratioOfMedian, r.ratioOfMedian > 0), csvNumber(r.ratioOfMean, r.ratioOfMean > 0),
      100 * e.stretchMax, csvNumber(1000 * e.penetrationMax, collides),
      csvNumber(1000 * e.penetrationTop, collides), e.judgedVertices, e.strandsRootedInside,
      e.brokenStrands, countersText(r.counters), csvNumber(r.copies.before, r.copies.before > 0),
      csvNumber(r.copies.after, r.copies.after > 0), r.copies.runs);
}

std::string shown(double value, bool known, int digits) {
  return known ? fmt::format("{:.{}f}", value, digits) : "-";
}

std::string tableRow(const SceneResult& r) {
  const SceneErrors& e = r.errors;
  const bool timed = r.figures.isTimed(), collides = e.judgedVertices > 0;
  const Spread frame = r.figures.frame(), simulation = r.figures.of(PassGroup::kSimulation);
  const Spread sdf = r.figures.of(PassGroup::kSdf);
  const auto us = [&](double value) { return shown(value, timed, 1); };
  return fmt::format(
      "{:<32}{:>8}{:>9}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>7}{:>9.3f}{:>9}{:>9}{:>6}{:>9}{:>9}"
      "{:>5}  {}\n",
      r.row.name(), r.guides, r.vertices, us(frame.median), us(frame.mean), us(simulation.median),
      us(simulation.mean), us(sdf.median), us(sdf.mean),
      shown(r.ratioOfMedian, r.ratioOfMedian > 0, 2), 100 * e.stretchMax,
      shown(1000 * e.penetrationMax, collides, 3), shown(1000 * e.penetrationTop, collides, 3),
      e.brokenStrands, shown(r.copies.before, r.copies.before > 0, 1),
      shown(r.copies.after, r.copies.after > 0, 1), r.copies.runs, countersText(r.counters));
}

}  // namespace

std::string sceneTable(const std::vector<SceneResult>& results) {
  std::string text = fmt::format(
      "\n{:<32}{:>8}{:>9}{:>22}{:>22}{:>22}{:>7}{:>9}{:>18}{:>6}{:>18}{:>5}\n{:<32}{:>8}{:>9}"
      "{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>7}{:>9}{:>9}{:>9}{:>6}{:>9}{:>9}{:>5}  {}\n",
      "GPU time a frame [us]", "", "", "frame", "simulation", "SDF builds", "to", "stretch",
      "penetration [mm]", "", "copy [us]", "", "row", "guides", "vertices", "median", "mean",
      "median", "mean", "median", "mean", "base", "max %", "max", "99.9 %", "NaN", "before",
      "after", "runs", "counters");
  for (const SceneResult& result : results) text += tableRow(result);
  text += fmt::format("\n{:<32}{:<28}{:>5}{:>12}{:>12}{:>10}\n", "row", "pass", "SDF", "median us",
                      "mean us", "a frame");
  for (const SceneResult& r : results)
    for (const PassFigure& pass : r.figures.passes()) {
      const Spread us = spreadOf(pass.us);
      text += fmt::format("{:<32}{:<28}{:>5}{:>12}{:>12}{:>10.2f}\n", r.row.name(), pass.name,
                          pass.group == PassGroup::kSdf ? "yes" : "",
                          shown(us.median, r.figures.isTimed(), 2),
                          shown(us.mean, r.figures.isTimed(), 2), r.figures.perFrame(pass));
    }
  return text;
}

Result<void> appendSceneCsv(const std::string& path, const SceneResult& result,
                            const DeviceInfo& device, const std::string& commit) {
  const std::string start = csvStart(result.row, device, commit), end = csvEnd(device);
  const std::string row = start + "," + csvRow(result) + "," + end;
  if (Result<void> done = appendLines(path, kCsvHeader, {row}); !done) return done;
  std::vector<std::string> passes;
  for (const PassFigure& pass : result.figures.passes()) {
    const Spread us = spreadOf(pass.us);
    const bool timed = result.figures.isTimed();
    passes.push_back(fmt::format("{},{},{:d},{},{},{:.6g},{}", start, pass.name,
                                 pass.group == PassGroup::kSdf, csvNumber(us.median, timed),
                                 csvNumber(us.mean, timed), result.figures.perFrame(pass), end));
  }
  return appendLines(besidePath(path, "_passes"), kScenePassCsvHeader, passes);
}

Result<void> appendFirstFrameCsv(const std::string& path, const SceneRow& row, double milliseconds,
                                 const DeviceInfo& device, const std::string& commit) {
  const std::string line =
      fmt::format("{},{:.1f},{}", csvStart(row, device, commit), milliseconds, csvEnd(device));
  return appendLines(besidePath(path, "_first_frame"), kFirstFrameCsvHeader, {line});
}

Result<void> checkResult(const SceneResult& result) {
  const auto fault = [&](const char* what) -> Result<void> {
    return Error{ErrorCode::kDevice, result.row.name() + ": " + what};
  };
  const FrameFigures& figures = result.figures;
  const SceneErrors& errors = result.errors;
  if (figures.frames() == 0 || figures.passes().empty()) return fault("no pass ran");
  if (figures.isTimed() && !(figures.of(PassGroup::kSimulation).mean > 0))
    return fault("no pass took time");
  if (errors.brokenStrands > 0) return fault("strands have coordinates that are not finite");
  if (!std::isfinite(errors.stretchMax)) return fault("the stretch is not finite");
  if (!std::isfinite(errors.penetrationMax)) return fault("the penetration is not finite");
  const bool hasSdf =
      result.row.kind == SceneKind::kHeadSdf || result.row.kind == SceneKind::kCharacter;
  if (hasSdf != figures.has(PassGroup::kSdf))
    return fault(hasSdf ? "no SDF was built" : "an SDF was built");
  const bool collides = result.row.kind != SceneKind::kFree;
  if (collides != (errors.judgedVertices > 0)) return fault("the wrong vertices were judged");
  return {};
}

}  // namespace bench
