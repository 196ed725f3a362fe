// usd: simulated hair for other tools, out of a cache.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "commands.h"
#include "import_options.h"
#include "output_file.h"
#include "pelage/authoring/usd_curves.h"
#include "pelage/hair_cache.h"

namespace pelage::convert {
namespace {

struct UsdOptions {
  std::filesystem::path cache, output;
  std::string name = "hair";
  float width = 8e-5f;
  bool velocities = true;
};

UsdCurvesDef curvesOf(const HairCacheDef& cache, const UsdOptions& options) {
  UsdCurvesDef def;
  def.name = options.name;
  def.vertexCounts = cache.vertexCounts;
  if (def.vertexCounts.empty()) def.vertexCounts.assign(cache.strandCount, cache.verticesPerStrand);
  def.widths = {options.width};
  def.strandIds = cache.strandIds;
  def.framesPerSecond = cache.framesPerSecond;
  def.firstFrame = cache.firstFrame;
  def.velocities = options.velocities;
  return def;
}

Result<void> writeUsd(const UsdOptions& options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".usda"); !r) return r;
  auto reader = HairCacheReader::open(options.cache);
  if (!reader) return reader.error();
  auto writer = UsdCurvesWriter::create(options.output, curvesOf(reader->def(), options),
                                        std::max(std::thread::hardware_concurrency(), 1u));
  if (!writer) return writer.error();
  std::vector<Float3> positions(reader->vertexCount());
  const uint64_t frames = reader->frameCount();
  for (uint64_t frame = 0; frame < frames; ++frame) {
    session.progress("frames", frame, frames);
    if (auto r = reader->read(frame, positions); !r) return r;
    if (auto r = writer->append(positions); !r) return r;
  }
  session.progress("frames", frames, frames);
  if (auto r = writer->close(); !r) return r;
  std::error_code ignored;
  const uint64_t size = std::filesystem::file_size(options.output, ignored);
  session.add("output", options.output.string(), "wrote", options.output.string());
  session.add("size", size, "size", fmt::format("{} bytes", size));
  session.add("frames", frames, "frames", fmt::format("{}", frames));
  session.add("curves", reader->def().strandCount, "curves",
              fmt::format("{} with {} vertices", reader->def().strandCount, positions.size()));
  return {};
}

}  // namespace

void addUsdCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<UsdOptions>();
  CLI::App* command =
      app.add_subcommand("usd", "Makes USD curves with time samples out of simulated hair, .usda");
  command->add_option("CACHE", options->cache, "Simulated hair, .pelagecache")->required();
  command->add_option("OUT", options->output, "USD file, .usda")->required();
  command->add_option("--name", options->name, "Name of the prim")->capture_default_str();
  command->add_option("--width", options->width, "Diameter of the fibers [m]")
      ->check(isAboveZero())
      ->capture_default_str();
  command->add_flag("--velocities,!--no-velocities", options->velocities,
                    "Velocities of all vertices; on without being asked for");
  command->callback([options, &session] {
    session.command = [options, &session] { return writeUsd(*options, session); };
  });
}

}  // namespace pelage::convert
