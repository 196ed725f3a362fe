// The scenes that users run: GPU time of every pass, error beside time, first frame, and what
// drawing costs; as tables and CSV.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "device.h"
#include "scenes/drawing_measure.h"
#include "scenes/drawing_report.h"
#include "scenes/scene_measure.h"
#include "scenes/scene_report.h"
#include "simulation/bench_device.h"

namespace {

using bench::DrawingResult;
using bench::DrawingRow;
using bench::SceneResult;
using bench::SceneRow;
using pelage::Error;
using pelage::ErrorCode;
using pelage::HeadlessDevice;
using pelage::Result;
using Clock = std::chrono::steady_clock;

struct Options {
  std::vector<std::string> apis = {"vulkan", "gl", "gles"};
  std::vector<std::string> filters;  // empty: all rows
  int device = -1;
  bench::MeasureDef measure;
  std::string method;  // of the rows that draw; empty: as the library has it
  double seconds = 0;
  bool quick = false, small = false, cold = false, list = false, serial = false;
  std::string csv, commit, data;
};

// A smoke test takes the first frames, in which every SDF is built.
constexpr bench::MeasureDef kQuickMeasure = {
    .frames = 3, .warmUpFrames = 0, .samples = 1, .clocks = bench::kOnce};

bench::SceneSize sizeOf(const Options& options) {
  if (options.quick) return bench::SceneSize::kQuick;
  return options.small ? bench::SceneSize::kSmall : bench::SceneSize::kFull;
}

// Returns the rows that a filter fits.
template <class Row>
std::vector<Row> chosenOf(std::vector<Row> all, const Options& options) {
  std::vector<Row> rows;
  for (Row& row : all) {
    bool chosen = options.filters.empty();
    for (const std::string& filter : options.filters)
      chosen = chosen || row.name().find(filter) != std::string::npos;
    if (chosen) rows.push_back(std::move(row));
  }
  return rows;
}
std::vector<SceneRow> chosenRows(const Options& options) {
  return chosenOf(bench::sceneRows(sizeOf(options)), options);
}
std::vector<DrawingRow> chosenDrawings(const Options& options) {
  return chosenOf(bench::drawingRows(sizeOf(options)), options);
}

bench::DrawingDef drawingDefOf(const Options& options) {
  bench::DrawingDef def;
  if (options.method == "windowed") def.method = pelage::Transparency::kWindowed;
  if (options.method == "tiles") def.method = pelage::Transparency::kTiles;
  return def;
}

Result<std::unique_ptr<HeadlessDevice>> makeDevice(const std::string& api, const Options& options) {
  pelage::HeadlessDef def;
  def.api = *sample::parseApi(api);
  def.deviceIndex = options.device;
  return bench::createDevice(def);
}

/// The rows of one API, one after the other.
class ApiRun {
 public:
  ApiRun(HeadlessDevice& device, const Options& options, bench::SceneAssets& assets,
         Clock::time_point start)
      : options_(options),
        assets_(assets),
        start_(start),
        workbench_{device, {}},
        measure_(options.quick ? kQuickMeasure : options.measure),
        reference_(device, workbench_.scene, measure_.clocks) {
    workbench_.scene.setLevels(!options.serial);
  }

  /// Returns how many rows could not be measured.
  int run() {
    int failures = 0;
    for (const SceneRow& row : chosenRows(options_))
      failures += runInTime(row.name(), [&] { return runRow(row); });
    if (!results_.empty()) fmt::print("{}\n", bench::sceneTable(results_));
    for (const DrawingRow& row : chosenDrawings(options_))
      if (row.ratBoy && !assets_.hasRatBoy())
        fmt::print("{}: skipped, no --data folder with ratboy/\n", row.name());
      else
        failures += runInTime(row.name(), [&] { return runDrawing(row); });
    if (!drawings_.empty()) fmt::print("{}\n", bench::drawingTable(drawings_));
    std::fflush(stdout);
    return failures;
  }

 private:
  /// Returns 1 where a row could not be measured. One for which there is no time is left out.
  template <class RunRow>
  int runInTime(const std::string& name, const RunRow& runRow) {
    const std::chrono::duration<double> spent = Clock::now() - start_;
    if (options_.seconds > 0 && spent.count() > options_.seconds) {
      fmt::print(stderr, "{}: skipped, the time is over\n", name);
      return 0;
    }
    fmt::print(stderr, "{}\n", name);
    const Result<void> done = runRow();
    if (done) return 0;
    fmt::print(stderr, "error: {}: {}\n", name, done.error().message);
    return 1;
  }

  Result<void> runRow(const SceneRow& row) {
    auto result = bench::measureRow(workbench_, reference_, assets_, row, measure_);
    if (!result) return result.error();
    compare(*result);
    results_.push_back(*std::move(result));
    if (!options_.csv.empty()) {
      const auto& info = workbench_.device.info();
      if (Result<void> done =
              bench::appendSceneCsv(options_.csv, results_.back(), info, options_.commit);
          !done)
        return done;
    }
    return options_.quick ? bench::checkResult(results_.back()) : Result<void>();
  }

  Result<void> runDrawing(const DrawingRow& row) {
    if (!rig_) {
      auto rig = bench::makeLightRig(workbench_.device, assets_, row);
      if (!rig) return rig.error();
      rig_ = *std::move(rig);
    }
    auto result = bench::measureDrawing(workbench_, reference_, assets_, row, *rig_,
                                        drawingDefOf(options_), measure_);
    if (!result) return result.error();
    if (const DrawingResult* alone = aloneBeside(row); alone != nullptr) {
      const bench::Spread without = bench::drawingTime(alone->figures);
      const bench::Spread all = bench::drawingTime(result->figures);
      result->added = {all.median - without.median, all.mean - without.mean};
      result->hasAdded = alone->figures.isTimed();
      if (row.extra == bench::DrawingExtra::kLevelOfDetail)
        result->psnr = sample::psnrOf(result->picture, alone->picture);
    }
    drawings_.push_back(*std::move(result));
    if (!options_.csv.empty()) {
      const auto& info = workbench_.device.info();
      if (Result<void> done =
              bench::appendDrawingCsv(options_.csv, drawings_.back(), info, options_.commit);
          !done)
        return done;
    }
    if (!options_.quick) return {};
    if (Result<void> done = bench::checkDrawing(drawings_.back()); !done) return done;
    return bench::comparePictures(drawings_);
  }

  // The row of as much hair that draws nothing else; nullptr: it has not run, or is this one.
  const DrawingResult* aloneBeside(const DrawingRow& row) const {
    if (row.extra == bench::DrawingExtra::kNone) return nullptr;
    for (const DrawingResult& one : drawings_)
      if (one.row.extra == bench::DrawingExtra::kNone && one.row.tenfold == row.tenfold &&
          one.row.distance == row.distance && one.row.characters == row.characters &&
          one.row.ratBoy == row.ratBoy)
        return &one;
    return nullptr;
  }

  void compare(SceneResult& result) {
    const bench::Spread frame = result.figures.frame();
    if (!result.figures.isTimed()) return;
    if (result.row.solver == bench::RowSolver::kBaseline) baselines_[result.row.scene] = frame;
    const auto found = baselines_.find(result.row.scene);
    if (found == baselines_.end()) return;
    result.ratioOfMedian = frame.median / found->second.median;
    result.ratioOfMean = frame.mean / found->second.mean;
  }

  const Options& options_;
  bench::SceneAssets& assets_;
  Clock::time_point start_;
  bench::Workbench workbench_;
  bench::MeasureDef measure_;
  bench::CopyReference reference_;
  std::vector<SceneResult> results_;
  std::vector<DrawingResult> drawings_;
  std::optional<engine_lights::LightRig> rig_;      // made by the first row that draws
  std::map<std::string, bench::Spread> baselines_;  // by scene
};

Result<int> runAll(const Options& options) {
  bench::SceneAssets assets(options.quick, options.data);
  const Clock::time_point start = Clock::now();
  int failures = 0;
  for (const std::string& api : options.apis) {
    const auto device = makeDevice(api, options);
    if (!device) {
      if (device.error().code != ErrorCode::kUnsupported) return device.error();
      fmt::print("{}: skipped, {}\n", api, device.error().message);
      continue;
    }
    const auto& info = (*device)->info();
    fmt::print("{}: {} ({})\n", api, info.name, info.driver);
    failures += ApiRun(**device, options, assets, start).run();
  }
  return failures;
}

// One row of one API in a process of its own; prints a number and nothing else.
Result<int> runCold(const Options& options) {
  const std::vector<SceneRow> rows = chosenRows(options);
  if (rows.size() != 1 || options.apis.size() != 1)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("--cold takes one --api and a --filter that fits one row, not {} and "
                             "{}; --list names the rows",
                             options.apis.size(), rows.size())};
  const auto device = makeDevice(options.apis[0], options);
  if (!device) return device.error();
  bench::SceneAssets assets(options.quick);
  bench::Workbench workbench{**device, {}};
  const auto milliseconds = bench::firstFrame(workbench, assets, rows[0]);
  if (!milliseconds) return milliseconds.error();
  fmt::print("{:.1f}\n", *milliseconds);
  if (options.csv.empty()) return 0;
  if (Result<void> done = bench::appendFirstFrameCsv(options.csv, rows[0], *milliseconds,
                                                     (*device)->info(), options.commit);
      !done)
    return done.error();
  return 0;
}

int listRows(const Options& options) {
  for (const SceneRow& row : chosenRows(options)) fmt::print("{}\n", row.name());
  if (options.cold) return 0;
  for (const DrawingRow& row : chosenDrawings(options)) fmt::print("{}\n", row.name());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Runs the scenes of the samples on a GPU, beside the classic baseline.");
  app.add_option("--api", options.apis, "vulkan, gl or gles; several run one after the other")
      ->check(CLI::IsMember(std::set<std::string>{"vulkan", "gl", "gles"}));
  app.add_option("--device", options.device, "which device, in the driver's order");
  app.add_option("--filter", options.filters, "only rows whose name has one of these in it");
  app.add_option("--frames", options.measure.frames, "that are measured, of 1/60 s each")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--warm-up", options.measure.warmUpFrames, "frames before those")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--runs", options.measure.clocks.maxRuns,
                 "of a row at most, while the copies beside it take different times")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "after which no more rows are begun; 0 for all")
      ->capture_default_str();
  app.add_option("--method", options.method,
                 "of the rows that draw; chosen by the size of the hair when not given")
      ->check(CLI::IsMember(std::set<std::string>{"windowed", "tiles"}));
  app.add_option("--csv", options.csv,
                 "file to append the rows to; passes go to NAME_passes.csv, first frames to "
                 "NAME_first_frame.csv, rows that draw to NAME_drawing.csv and "
                 "NAME_drawing_passes.csv");
  app.add_option("--data", options.data, "folder with ratboy/, for the rows of Rat Boy");
  app.add_option("--commit", options.commit, "of the source, for the rows");
  app.add_flag("--quick", options.quick, "smoke test: few strands and frames, results are checked");
  app.add_flag("--small", options.small, "fewer strands, for software drivers");
  app.add_flag("--cold", options.cold, "print the wall time of a row's first frame [ms]");
  app.add_flag("--serial", options.serial,
               "lists without levels: for the times of single passes (Scene::setLevels())");
  app.add_flag("--list", options.list,
               "print the names of the rows; with --cold of those that have first frames");
  CLI11_PARSE(app, argc, argv);
  if (options.list) return listRows(options);
  const auto failures = options.cold ? runCold(options) : runAll(options);
  if (!failures) fmt::print(stderr, "error: {}\n", failures.error().message);
  return failures && *failures == 0 ? 0 : 1;
}
