// Error against time: every solver and setting in every scene, on the GPU, as CSV.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "device.h"
#include "pelage/hair_asset.h"
#include "simulation/bench_device.h"
#include "simulation/measure.h"

namespace {

using bench::BenchScene;
using bench::Measurement;
using bench::SolverChoice;
using bench::SolverKind;
using pelage::Error;
using pelage::Result;

struct Options {
  std::vector<std::string> apis = {"vulkan", "gl"};
  std::vector<std::string> scenes;   // empty: all
  std::vector<std::string> solvers;  // likewise
  int device = -1;
  int rounds = 1;
  uint32_t strands = 32640;
  uint32_t staticStrands = 2176;
  std::vector<uint32_t> grooms = {2176, 32640, 130560};
  std::vector<uint32_t> mohawks = {1, 15};
  std::filesystem::path data;
  std::string csv, commit;
};

// A device with its scene and its copies.
struct Bench {
  explicit Bench(pelage::HeadlessDevice& device)
      : workbench{device, {}}, copies(device, workbench.scene, {}) {}
  bench::Workbench workbench;
  bench::CopyReference copies;
};

bool isChosen(const std::vector<std::string>& chosen, const std::string& name) {
  return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
}

// The efforts of each solver; the classic baseline's first one is what ratios refer to.
std::vector<SolverChoice> choicesOf(const BenchScene& scene, const Options& options) {
  const std::pair<SolverKind, std::vector<uint32_t>> all[] = {
      {SolverKind::kSweeps, {2, 20, 100}},
      {SolverKind::kCosserat, {5, 10, 20, 40}},
      {SolverKind::kClassic, {1, 2, 4, 8}},
      {SolverKind::kExact, {1, 2, 4, 8}}};
  std::vector<SolverChoice> choices;
  for (const auto& [kind, efforts] : all) {
    // XPBD has no velocity shock propagation.
    if (kind == SolverKind::kCosserat && scene.carry > 0) continue;
    if (!isChosen(options.solvers, solverName(kind))) continue;
    // Only the exact solver sleeps; the baseline is there for the ratio.
    if (scene.sleeps && kind != SolverKind::kExact && kind != SolverKind::kSweeps) continue;
    for (const uint32_t effort : efforts) {
      choices.push_back({kind, effort});
      if (scene.sleeps) break;
    }
  }
  return choices;
}

void print(const Measurement& m) {
  fmt::print("{:<24}{:<15}{:<16}{:>8}{:>11}{:>12.4g}{:>12.4g}{:>8}{:>12.1f}{:>12.1f}{:>10.1f}\n",
             m.scene, m.solver, m.setting, m.strands,
             m.error >= 0 ? fmt::format("{:.4g}", m.error) : "-", m.maxStretch, m.rmsStretch,
             m.brokenStrands, m.medianFrame, m.leastFrame, m.floor);
  std::fflush(stdout);
}

// The quickest of some rounds: a GPU is not always alone.
Result<Measurement> quickest(Bench& bench, const BenchScene& scene,
                             const bench::SceneReference& reference, const SolverChoice& choice,
                             int rounds) {
  auto best = bench::measure(bench.workbench, bench.copies, scene, reference, choice);
  for (int round = 1; round < rounds && best; ++round) {
    auto row = bench::measure(bench.workbench, bench.copies, scene, reference, choice);
    if (!row) return row;
    row->floor = std::min(row->floor, best->floor);
    if (row->medianFrame < best->medianFrame)
      best = row;
    else
      best->floor = row->floor;
  }
  return best;
}

// A row that a device cannot do is left out, and named.
Result<void> runScene(Bench& bench, const BenchScene& scene, const Options& options,
                      int& failures) {
  if (!isChosen(options.scenes, scene.name)) return {};
  const bench::SceneReference reference(scene);
  double baseline = 0;
  for (const SolverChoice& choice : choicesOf(scene, options)) {
    auto row = quickest(bench, scene, reference, choice, options.rounds);
    if (!row) {
      fmt::print(stderr, "error: {}, {}, {}: {}\n", scene.name, solverName(choice.kind),
                 choice.setting(), row.error().message);
      ++failures;
      continue;
    }
    if (choice.kind == SolverKind::kSweeps && choice.effort == 2) baseline = row->medianFrame;
    if (baseline > 0) row->ratioToBaseline = row->medianFrame / baseline;
    print(*row);
    if (options.csv.empty()) continue;
    const auto& device = bench.workbench.device.info();
    if (Result<void> done = bench::appendCsv(options.csv, {*row}, device, options.commit); !done)
      return done;
  }
  return {};
}

Result<void> runGrooms(Bench& bench, const Options& options, int& failures) {
  if (options.grooms.empty()) return {};
  const uint32_t least = *std::min_element(options.grooms.begin(), options.grooms.end());
  const auto hair = bench::generatedHair(least);
  if (!hair) return hair.error();
  for (const uint32_t strands : options.grooms) {
    const auto scene = bench::movedGroom("groom", *hair, std::max(1u, strands / least), 0);
    if (Result<void> done = runScene(bench, scene, options, failures); !done) return done;
  }
  const uint32_t copies = std::max(1u, options.grooms[options.grooms.size() / 2] / least);
  const auto carried = bench::movedGroom("groom_carried", *hair, copies, 0.5);
  if (Result<void> done = runScene(bench, carried, options, failures); !done) return done;
  return runScene(bench, bench::restingGroom("groom_asleep", *hair, copies), options, failures);
}

Result<void> runMohawk(Bench& bench, const Options& options, int& failures) {
  const auto path = options.data / "ratboy/Ratboy_mohawk.tfx";
  if (!std::filesystem::exists(path)) {
    fmt::print("mohawk: skipped, there is no {}\n", path.string());
    return {};
  }
  const auto hair = pelage::loadTfx(path, {.repair = true});
  if (!hair) return hair.error();
  for (const uint32_t copies : options.mohawks) {
    const auto scene = bench::movedGroom("mohawk", *hair, copies, 0);
    if (Result<void> done = runScene(bench, scene, options, failures); !done) return done;
  }
  return {};
}

Result<void> runApi(pelage::Api api, const Options& options, int& failures) {
  const auto device = bench::openDevice(api, options.device);
  if (!device) return device.error();
  if (!*device) return {};
  fmt::print("{}: {} ({})\n", pelage::apiName(api), (*device)->info().name,
             (*device)->info().driver);
  fmt::print("{:<24}{:<15}{:<16}{:>8}{:>11}{:>12}{:>12}{:>8}{:>12}{:>12}{:>10}\n", "scene",
             "solver", "setting", "strands", "error %", "max str. %", "rms str. %", "broken",
             "median us", "min us", "floor us");
  Bench bench(**device);
  for (const auto make :
       {bench::limpSwing, bench::limpWhip, bench::softSwing, bench::stiffSwing, bench::shakenCurl})
    if (Result<void> done = runScene(bench, make(options.strands), options, failures); !done)
      return done;
  for (const auto make : {bench::elastica, bench::saggingHelix})
    if (Result<void> done = runScene(bench, make(options.staticStrands), options, failures); !done)
      return done;
  if (Result<void> done = runGrooms(bench, options, failures); !done) return done;
  return runMohawk(bench, options, failures);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Runs pelage's solvers and the baselines in the same scenes on a GPU.");
  app.add_option("--api", options.apis, "vulkan, gl or gles; several run one after the other")
      ->check(CLI::IsMember(std::set<std::string>{"vulkan", "gl", "gles"}));
  app.add_option("--device", options.device, "which device, in the driver's order");
  app.add_option("--scenes", options.scenes, "only these");
  app.add_option("--solvers", options.solvers, "only these")
      ->check(CLI::IsMember(
          std::set<std::string>{"exact", "classic", "tressfx_like", "xpbd_cosserat"}));
  app.add_option("--rounds", options.rounds, "runs of each row, of which the quickest is kept")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--strands", options.strands, "copies of the strand in the moving scenes")
      ->check(CLI::Range(1u, 130560u))
      ->capture_default_str();
  app.add_option("--static-strands", options.staticStrands, "the same in the scenes at rest")
      ->check(CLI::Range(1u, 130560u))
      ->capture_default_str();
  app.add_option("--grooms", options.grooms,
                 "strands of the generated grooms, multiples of the "
                 "smallest one; 0 leaves them out");
  app.add_option("--mohawks", options.mohawks, "copies of the mohawk")->check(CLI::Range(1u, 60u));
  app.add_option("--data", options.data, "folder that holds ratboy/");
  app.add_option("--csv", options.csv, "file to append the rows to");
  app.add_option("--commit", options.commit, "of the source, for the rows");
  CLI11_PARSE(app, argc, argv);
  std::erase(options.grooms, 0u);
  int failures = 0;
  for (const std::string& name : options.apis) {
    if (Result<void> done = runApi(*sample::parseApi(name), options, failures); !done) {
      fmt::print(stderr, "error: {}\n", done.error().message);
      return 1;
    }
  }
  return failures > 0 ? 1 : 0;
}
