// Distance fields: error against time of pelage's build and collision and of the classic baseline,
// on the GPU, as CSV.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "device.h"
#include "sdf/sdf_measure.h"
#include "simulation/bench_device.h"

namespace {

using bench::NodeGrid;
using bench::SdfMethod;
using bench::SdfMotion;
using bench::SdfRow;
using bench::SdfShape;
using pelage::Result;
using pelage::reference::DistanceOracle;

constexpr double kRange = 6;  // cells outside that the oracle looks

struct Options {
  std::vector<std::string> apis = {"vulkan", "gl"};
  std::vector<std::string> shapes, methods;  // empty: all
  std::vector<uint32_t> cells;               // likewise
  int device = -1;
  int frames = 40;
  uint32_t vertices = 1044480;
  std::filesystem::path data;
  std::string csv, commit;
};

template <class T>
bool isChosen(const std::vector<T>& chosen, const T& name) {
  return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
}

// The first one is what ratios refer to.
std::vector<SdfMethod> methodsOf(const SdfShape& shape) {
  std::vector<SdfMethod> methods = {
      {.name = "classic", .classic = true, .ownGrid = true, .collides = true},
      {.name = "classic, tight grid", .classic = true, .collides = true},
      {.name = "one axis", .collides = true},
      {.name = "three axes", .threeAxes = true},
  };
  if (!shape.hasHair) return methods;
  methods.push_back({.name = "band 4", .band = 4, .collides = true});
  methods.push_back({.name = "12 bits", .keyBits = 12, .collides = true});
  methods.push_back({.name = "10 bits", .keyBits = 10, .collides = true});
  methods.push_back({.name = "9 % move", .motion = SdfMotion::kPart});
  methods.push_back({.name = "nothing moves", .motion = SdfMotion::kNone});
  return methods;
}

// A grid, and what is true at its nodes.
struct Truth {
  NodeGrid grid;
  std::vector<float> distances;
};

class ShapeRun {
 public:
  ShapeRun(bench::Workbench& workbench, bench::CopyReference& copies, const SdfShape& shape,
           const Options& options)
      : workbench_(workbench),
        copies_(copies),
        shape_(shape),
        options_(options),
        oracle_(shape.mesh) {}

  /// Returns how many rows could not be measured.
  Result<int> run() {
    int failures = 0;
    for (const uint32_t cells : shape_.cells) {
      if (!isChosen(options_.cells, cells)) continue;
      truths_.clear();
      classic_.clear();
      makeHair(cells);
      for (const SdfMethod& method : methodsOf(shape_)) {
        if (!isChosen(options_.methods, method.name)) continue;
        auto rows = measure(cells, method);
        if (!rows) {
          fmt::print(stderr, "error: {}, {} cells, {}: {}\n", shape_.name, cells, method.name,
                     rows.error().message);
          ++failures;
          continue;
        }
        for (SdfRow& row : *rows) finishRow(row, method);
        if (options_.csv.empty()) continue;
        const auto& info = workbench_.device.info();
        if (Result<void> done = bench::appendSdfCsv(options_.csv, *rows, info, options_.commit);
            !done)
          return done.error();
      }
    }
    return failures;
  }

 private:
  Result<std::vector<SdfRow>> measure(uint32_t cells, const SdfMethod& method) {
    const auto truth = truthOf(cells, method.band);
    if (!truth) return truth.error();
    const bench::SdfCase what = {shape_, cells, (*truth)->grid, (*truth)->distances, hair_};
    return bench::measureSdf(workbench_, copies_, what, method, oracle_, options_.frames);
  }

  // Near: all of it within 3 cells, half of it inside. Usual: outside, a twentieth within a cell.
  void makeHair(uint32_t cells) {
    hair_.clear();
    if (!shape_.hasHair || options_.vertices == 0) return;
    const float cell = bench::cellSizeOf(shape_, cells);
    hair_.push_back(
        bench::makeHairSet(shape_, oracle_, "collide_near", options_.vertices, -3, 3, cell));
    hair_.push_back(
        bench::makeHairSet(shape_, oracle_, "collide_usual", options_.vertices, 0.05f, 20, cell));
  }

  Result<const Truth*> truthOf(uint32_t cells, float band) {
    const auto found = truths_.find(band);
    if (found != truths_.end()) return &found->second;
    const auto grid = bench::comparedGrid(shape_, bench::cellSizeOf(shape_, cells), band);
    if (!grid) return grid.error();
    Truth& truth = truths_[band];
    truth = {*grid, bench::trueDistances(oracle_, *grid, kRange)};
    return &truth;
  }

  void finishRow(SdfRow& row, const SdfMethod& method) {
    if (method.classic && method.ownGrid) classic_[row.what] = row.median;
    if (classic_[row.what] > 0) row.ratioToClassic = row.median / classic_[row.what];
    const auto& e = row.errors;
    fmt::print("{:<11}{:>6}  {:<14}{:<45}{:>10.1f}{:>10.1f}", row.shape, row.cells, row.what,
               row.response.empty() ? row.method : row.method + ": " + row.response, row.median,
               row.least);
    if (row.hasErrors)
      fmt::print("{:>7}{:>10.2g}{:>8.2f}{:>8.3f}", e.wrongSigns, e.nearMax, 100 * e.unsetInterior,
                 e.farMax);
    else
      fmt::print("{:>33}",
                 row.resolved >= 0 ? fmt::format("{:.3f} % out", 100 * row.resolved) : "");
    fmt::print("{:>9.2f}\n", static_cast<double>(row.sdfBytes) / (1 << 20));
    std::fflush(stdout);
  }

  bench::Workbench& workbench_;
  bench::CopyReference& copies_;
  const SdfShape& shape_;
  const Options& options_;
  DistanceOracle oracle_;
  std::vector<bench::HairSet> hair_;       // of one cell size
  std::map<float, Truth> truths_;          // by band, of one cell size
  std::map<std::string, double> classic_;  // [us] of what it is the time of
};

Result<void> runApi(pelage::Api api, const std::vector<SdfShape>& shapes, const Options& options,
                    int& failures) {
  const auto device = bench::openDevice(api, options.device);
  if (!device) return device.error();
  if (!*device) return {};
  fmt::print("{}: {} ({})\n", pelage::apiName(api), (*device)->info().name,
             (*device)->info().driver);
  fmt::print("{:<11}{:>6}  {:<14}{:<45}{:>10}{:>10}{:>7}{:>10}{:>8}{:>8}{:>9}\n", "shape", "cells",
             "what", "method", "median us", "min us", "signs", "error", "unset %", "inside", "MiB");
  bench::Workbench workbench{**device, {}};
  bench::CopyReference copies(**device, workbench.scene, {});
  for (const SdfShape& shape : shapes) {
    if (!isChosen(options.shapes, shape.name)) continue;
    const auto failed = ShapeRun(workbench, copies, shape, options).run();
    if (!failed) return failed.error();
    failures += *failed;
  }
  return {};
}

Result<int> run(const Options& options) {
  auto shapes = bench::realShapes(options.data);
  if (!shapes) return shapes.error();
  for (SdfShape& shape : bench::generatedShapes()) shapes->push_back(std::move(shape));
  int failures = 0;
  for (const std::string& name : options.apis)
    if (Result<void> done = runApi(*sample::parseApi(name), *shapes, options, failures); !done)
      return done.error();
  return failures;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Builds distance fields and collides hair with them, beside the classic baseline.");
  app.add_option("--api", options.apis, "vulkan, gl or gles; several run one after the other")
      ->check(CLI::IsMember(std::set<std::string>{"vulkan", "gl", "gles"}));
  app.add_option("--device", options.device, "which device, in the driver's order");
  app.add_option("--shapes", options.shapes, "only these");
  app.add_option("--methods", options.methods, "only these");
  app.add_option("--cells", options.cells, "only these, of those that a shape has");
  app.add_option("--frames", options.frames, "that are timed, an even number")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  app.add_option("--vertices", options.vertices, "of the hair; 0 leaves collisions out")
      ->check(CLI::Range(0u, 1u << 24))
      ->capture_default_str();
  app.add_option("--data", options.data, "folder that holds ratboy/");
  app.add_option("--csv", options.csv, "file to append the rows to");
  app.add_option("--commit", options.commit, "of the source, for the rows");
  CLI11_PARSE(app, argc, argv);
  options.frames += options.frames % 2;
  options.vertices -= options.vertices % 32;
  const auto failures = run(options);
  if (!failures) fmt::print(stderr, "error: {}\n", failures.error().message);
  return failures && *failures == 0 ? 0 : 1;
}
