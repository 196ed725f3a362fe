// Transparency of hair: GPU time and memory against error of all methods and of the classic
// baseline, as CSV.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "device.h"
#include "oit/oit_measure.h"
#include "simulation/bench_device.h"

namespace {

using bench::HairSceneDef;
using bench::OitMethod;
using bench::OitRow;
using pelage::Result;

struct Options {
  std::vector<std::string> apis = {"vulkan"};
  std::vector<std::string> scenes, views, methods;  // empty: all
  std::vector<float> opacities = {0.33f, 0.6f, 1.0f};
  std::vector<std::string> sizes = {"1920x1080", "3840x2160"};
  int device = -1;
  bench::OitFrameCounts counts;
  uint32_t guides = 2000;
  uint32_t fragments = 1 << 23;
  double seconds = 0;  // none
  std::filesystem::path data;
  std::string csv, commit;
};

struct Size {
  uint32_t width = 0, height = 0;
};

bool parseSize(const std::string& text, Size& size) {
  char end = 0;
  const int found = std::sscanf(text.c_str(), "%ux%u%c", &size.width, &size.height, &end);
  return found == 2 && size.width >= 16 && size.width <= 16384 && size.height >= 16 &&
         size.height <= 16384;
}

bool isChosen(const std::vector<std::string>& chosen, const std::string& name) {
  return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
}

std::string nameOf(const OitMethod& method) {
  return method.samples > 1 ? fmt::format("{} x{}", method.name, method.samples) : method.name;
}

void print(const OitRow& row) {
  fmt::print(
      "{:<8}{:<7}{:>5}x{:<6}{:<6}{:<14}{:>7.2f}{:>8.4f}{:>8.3f}{:>10.3f}{:>10.3f}{:>9.3f}"
      "{:>7.2f}{:>9.1f}{:>11}{:>8.1f}{:>5}\n",
      row.scene, row.viewName, row.width, row.height, row.opacity,
      nameOf({row.method, {}, row.samples}), row.error.psnr, row.error.largest, 100 * row.error.off,
      row.build, row.resolve, row.shadow, row.resolveRatio,
      static_cast<double>(row.bytes) / (1 << 20), row.fragments, row.layersMean, row.layersMax);
  std::fflush(stdout);
}

class Run {
 public:
  Run(const Options& options, pelage::HeadlessDevice& device, bench::HairScene& scene)
      : options_(options),
        device_(device),
        scene_(scene),
        copies_(device, scene.scene(), {}),
        reference_(scene, options.fragments) {}

  /// Rows of all methods; those that a device cannot do are told of.
  Result<void> measure(const HairSceneDef& def, bool close, const Size& size, float opacity) {
    scene_.hair().material.opacity = opacity;
    const pelage::View view =
        sample::makeView(close ? def.close : def.whole, size.width, size.height, 1);
    const auto exact = reference_.picture(view);
    if (!exact) return exact.error();
    double classic = 0;
    for (const OitMethod& method : bench::oitMethods()) {
      if (!isChosen(options_.methods, method.name)) continue;
      if ((device_.info().sampleCounts & method.samples) == 0) {
        fmt::print("{}: skipped, the device has no such target\n", nameOf(method));
        continue;
      }
      OitRow row;
      row.scene = def.name;
      row.viewName = close ? "close" : "whole";
      row.opacity = std::round(1000 * static_cast<double>(opacity)) / 1000;
      if (Result<void> done =
              bench::measureOit({scene_, copies_, view, *exact}, method, options_.counts, row);
          !done)
        return pelage::Error{done.error().code, nameOf(method) + ": " + done.error().message};
      if (&method == bench::oitMethods().data()) classic = row.resolve;
      if (classic > 0 && row.resolve > 0) row.resolveRatio = row.resolve / classic;
      print(row);
      if (options_.csv.empty()) continue;
      if (Result<void> done =
              bench::appendOitCsv(options_.csv, row, device_.info(), options_.commit);
          !done)
        return done;
    }
    return {};
  }

 private:
  const Options& options_;
  pelage::HeadlessDevice& device_;
  bench::HairScene& scene_;
  bench::CopyReference copies_;
  bench::FragmentReference reference_;
};

// A device has the buffers of one scene.
Result<void> runScene(pelage::Api api, const HairSceneDef& def, const Options& options,
                      int& failures) {
  const auto device = bench::openDevice(api, options.device);
  if (!device) return device.error();
  if (!*device) return {};
  fmt::print(
      "{}: {} ({})\n{:<8}{:<7}{:>5} {:<6}{:<6}{:<14}{:>7}{:>8}{:>8}{:>10}{:>10}{:>9}{:>7}"
      "{:>9}{:>11}{:>8}{:>5}\n",
      pelage::apiName(api), (*device)->info().name, (*device)->info().driver, "scene", "view",
      "size", "", "alpha", "method", "dB", "max", "% off", "build ms", "resolve", "shadow", "ratio",
      "MiB", "fragments", "layers", "max");
  const auto scene = bench::HairScene::create(def, **device);
  if (!scene) return scene.error();
  Run run(options, **device, **scene);
  const auto start = std::chrono::steady_clock::now();
  for (const std::string& text : options.sizes) {
    Size size;
    parseSize(text, size);
    for (const bool close : {false, true}) {
      if (!isChosen(options.views, close ? "close" : "whole")) continue;
      for (const float opacity : options.opacities) {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        if (options.seconds > 0 && spent.count() > options.seconds) {
          fmt::print("{} {} {} {}: skipped, the time is over\n", def.name,
                     close ? "close" : "whole", text, opacity);
          continue;
        }
        if (Result<void> done = run.measure(def, close, size, opacity); !done) {
          fmt::print(stderr, "error: {} {} {} {}: {}\n", def.name, close ? "close" : "whole", text,
                     opacity, done.error().message);
          ++failures;
        }
      }
    }
  }
  return {};
}

Result<int> run(const Options& options) {
  Size first;
  parseSize(options.sizes.front(), first);
  std::vector<HairSceneDef> scenes;
  const float aspect = static_cast<float>(first.width) / static_cast<float>(first.height);
  if (isChosen(options.scenes, "groom")) {
    auto groom = bench::groomScene(options.guides, aspect);
    if (!groom) return groom.error();
    scenes.push_back(std::move(*groom));
  }
  if (!options.scenes.empty() && isChosen(options.scenes, "character")) {
    auto character = bench::characterScene(aspect);
    if (!character) return character.error();
    scenes.push_back(std::move(*character));
  }
  if (isChosen(options.scenes, "mohawk")) {
    auto mohawk = bench::mohawkScene(options.data);
    if (!mohawk) return mohawk.error();
    if (*mohawk)
      scenes.push_back(std::move(**mohawk));
    else
      fmt::print("mohawk: skipped, --data has no ratboy/Ratboy_mohawk.tfx and its body\n");
  }
  int failures = 0;
  for (const std::string& api : options.apis)
    for (const HairSceneDef& scene : scenes)
      if (Result<void> done = runScene(*sample::parseApi(api), scene, options, failures); !done)
        return done.error();
  return failures;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::set<std::string> methods;
  for (const OitMethod& method : bench::oitMethods()) methods.insert(method.name);
  CLI::App app("Draws hair with every kind of transparency, beside the classic baseline.");
  app.add_option("--api", options.apis, "vulkan, gl or gles; several run one after the other")
      ->check(CLI::IsMember(std::set<std::string>{"vulkan", "gl", "gles"}));
  app.add_option("--device", options.device, "which device, in the driver's order");
  app.add_option("--scenes", options.scenes,
                 "mohawk, groom, character; the first two when not given")
      ->check(CLI::IsMember(std::set<std::string>{"mohawk", "groom", "character"}));
  app.add_option("--views", options.views, "whole, close; both when not given")
      ->check(CLI::IsMember(std::set<std::string>{"whole", "close"}));
  app.add_option("--methods", options.methods, "only these")->check(CLI::IsMember(methods));
  app.add_option("--opacities", options.opacities, "of a fiber")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--sizes", options.sizes, "of the pictures, WIDTHxHEIGHT [pixels]")
      ->check([](const std::string& text) {
        Size size;
        return parseSize(text, size) ? "" : text + " is no size of 16x16 to 16384x16384";
      })
      ->capture_default_str();
  app.add_option("--frames", options.counts.frames, "that are timed, or more")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--together", options.counts.together,
                 "frames without a pause, in which clocks would fall")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--guides", options.guides, "of the generated groom")
      ->check(CLI::Range(1u, 1u << 20))
      ->capture_default_str();
  app.add_option("--fragments", options.fragments,
                 "that errors are held against; of a picture with more, some rows are taken")
      ->check(CLI::Range(1u << 12, 1u << 26))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds,
                 "of a scene, after which no more cases are begun; 0 for all")
      ->capture_default_str();
  app.add_option("--data", options.data, "folder that holds ratboy/");
  app.add_option("--csv", options.csv, "file to append the rows to");
  app.add_option("--commit", options.commit, "of the source, for the rows");
  CLI11_PARSE(app, argc, argv);
  const auto failures = run(options);
  if (!failures) fmt::print(stderr, "error: {}\n", failures.error().message);
  return failures && *failures == 0 ? 0 : 1;
}
