// usd: hair for other tools: simulated hair out of a cache, or the curves of any kind of file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "asset_files.h"
#include "commands.h"
#include "import_options.h"
#include "output_file.h"
#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/usd_curves.h"
#include "pelage/hair_cache.h"

namespace pelage::convert {
namespace {

struct UsdOptions {
  std::filesystem::path input, output;
  CurveImportDef import;  // of curves
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

void reportOutput(const UsdOptions& options, uint64_t frames, uint64_t curves, uint64_t vertices,
                  Session& session) {
  std::error_code ignored;
  const uint64_t size = std::filesystem::file_size(options.output, ignored);
  session.add("output", options.output.string(), "wrote", options.output.string());
  session.add("size", size, "size", fmt::format("{} bytes", size));
  session.add("frames", frames, "frames", fmt::format("{}", frames));
  session.add("curves", curves, "curves", fmt::format("{} with {} vertices", curves, vertices));
}

Result<void> writeCurves(const UsdOptions& options, Session& session) {
  HairFileReport file;
  auto curves = loadHairCurves(options.input, &file);
  if (!curves) return curves.error();
  for (const std::string& note : file.notes) session.warn(note);
  CurveImportReport imported;
  if (auto r = prepareCurves(*curves, options.import, &imported); !r)
    return Error{r.error().code, options.input.string() + ": " + r.error().message};
  if (imported.curvesDropped() > 0)
    session.warn(fmt::format("{} curves were dropped: too few vertices, or no length",
                             imported.curvesDropped()));
  if (curves->radii.empty()) curves->radii.assign(curves->positions.size(), options.width / 2);
  if (auto r = saveUsdCurves(*curves, options.output, options.name); !r) return r;
  reportOutput(options, 1, curves->curveCount(), curves->positions.size(), session);
  return {};
}

Result<void> writeUsd(const UsdOptions& options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".usda"); !r) return r;
  if (program::lowerExtension(options.input) != ".pelagecache")
    return writeCurves(options, session);
  auto reader = HairCacheReader::open(options.input);
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
  reportOutput(options, frames, reader->def().strandCount, positions.size(), session);
  return {};
}

}  // namespace

void addUsdCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<UsdOptions>();
  CLI::App* command =
      app.add_subcommand("usd", "Makes USD curves, .usda: of simulated hair, or of hair curves");
  command
      ->add_option("IN", options->input,
                   "Simulated hair, .pelagecache (curves with time samples); or hair curves of any "
                   "kind that groom reads")
      ->required();
  command->add_option("OUT", options->output, "USD file, .usda")->required();
  command->add_option("--name", options->name, "Name of the prim")->capture_default_str();
  command
      ->add_option("--width", options->width,
                   "Diameter of the fibers [m]; of curves: where the file has none")
      ->check(isAboveZero())
      ->capture_default_str();
  addAxisOptions(*command, "a file of curves", options->import.scale, options->import.upAxis,
                 options->import.invertZ);
  command->add_flag("--velocities,!--no-velocities", options->velocities,
                    "Velocities of all vertices; on without being asked for");
  command->callback([options, &session] {
    session.command = [options, &session] { return writeUsd(*options, session); };
  });
}

}  // namespace pelage::convert
