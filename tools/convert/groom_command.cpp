// groom: hair curves of any kind of file to guide strands, .tfx.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "asset_files.h"
#include "commands.h"
#include "import_options.h"
#include "output_file.h"
#include "pelage/authoring/guides.h"
#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/hair_asset.h"
#include "sag_report.h"

namespace pelage::convert {
namespace {

struct GroomOptions {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path input, output, follow;  // of the one at hand; at first those given
  CurveImportDef import;
  ResampleDef resample;
  GuideDef guides;
  SagOptions sag;
  bool resampled = false;   // an option about the vertices of a strand was given
  bool fileGuides = false;  // the file says which curves are guides

  bool selects() const { return guides.guideCount > 0 || guides.guideErrorBound > 0 || fileGuides; }
  /// Whether the strands of a .tfx pass as they are.
  bool changesNothing() const {
    CurveImportDef neutral;
    neutral.seed = import.seed;
    return !resampled && !resample.bothEndsImmovable && !selects() && import == neutral;
  }
};

void reportOptions(const GroomOptions& options, uint32_t verticesPerStrand, Session& session) {
  const CurveImportDef& def = options.import;
  const char* placement = options.resample.placement == VertexPlacement::kEven ? "even" : "fitted";
  nlohmann::ordered_json json = {{"scale", def.scale},
                                 {"up_axis", toString(def.upAxis)},
                                 {"invert_z", def.invertZ},
                                 {"invert_v", def.invertV},
                                 {"min_curve_length", def.minCurveLength},
                                 {"randomize_strands", def.randomizeStrands},
                                 {"seed", def.seed},
                                 {"vertices_per_strand", verticesPerStrand},
                                 {"resampled", options.resampled},
                                 {"error_bound", options.resample.errorBound},
                                 {"placement", placement},
                                 {"both_ends_immovable", options.resample.bothEndsImmovable}};
  std::string text = fmt::format("scale {:g}, {} up", def.scale, toString(def.upAxis));
  if (def.invertZ) text += ", z inverted";
  if (def.invertV) text += ", v inverted";
  if (def.minCurveLength > 0) text += fmt::format(", at least {:g} m", def.minCurveLength);
  if (def.randomizeStrands) text += fmt::format(", strands shuffled (seed {})", def.seed);
  text += options.resampled
              ? fmt::format(", {} vertices a strand ({})", verticesPerStrand, placement)
              : fmt::format(", {} vertices a strand as read", verticesPerStrand);
  if (options.resampled && options.resample.errorBound > 0)
    text += fmt::format(", error bound {:g} m", options.resample.errorBound);
  if (options.resample.bothEndsImmovable) text += ", both ends immovable";
  session.add("options", json, "options", std::move(text));
}

void reportInput(const GroomOptions& options, const HairFileReport& file, Session& session) {
  session.add("input", options.input.string(), "read",
              fmt::format("{} ({}, {} bytes)", options.input.string(), file.format, file.fileSize));
  session.add("format", file.format, "", "");
  session.add("notes", file.notes, "", "");
  for (const std::string& note : file.notes) session.warn(note);
}

void reportCurves(const CurveImportReport& report, Session& session) {
  session.add("curves_read", report.curvesRead, "curves",
              fmt::format("{} with {} vertices", report.curvesRead, report.verticesRead));
  session.add("vertices_read", report.verticesRead, "", "");
  session.add("dropped",
              {{"single_vertex", report.droppedSingleVertex},
               {"unusable", report.droppedUnusable},
               {"no_length", report.droppedNoLength},
               {"too_short", report.droppedShort}},
              "dropped", fmt::format("{}", report.curvesDropped()));
  session.add("removed_vertices", report.removedVertices, "", "");
  session.add("repaired_values", report.repairedValues, "", "");
  session.add("curves_kept", report.curvesKept, "kept",
              fmt::format("{} with {} vertices", report.curvesKept, report.verticesKept));
  session.add("vertices_kept", report.verticesKept, "", "");
  session.add("length",
              {{"min", report.minLength}, {"mean", report.meanLength}, {"max", report.maxLength}},
              "length",
              fmt::format("{:.4g} to {:.4g} m, mean {:.4g} m", report.minLength, report.maxLength,
                          report.meanLength));
  if (report.curvesDropped() > 0)
    session.warn(
        fmt::format("{} curves were dropped: {} with a single vertex, {} without usable "
                    "coordinates, {} without length, {} too short",
                    report.curvesDropped(), report.droppedSingleVertex, report.droppedUnusable,
                    report.droppedNoLength, report.droppedShort));
  if (report.removedVertices > 0)
    session.warn(
        fmt::format("{} vertices without usable coordinates were removed", report.removedVertices));
  if (report.repairedValues > 0)
    session.warn(
        fmt::format("{} values of UV, color, radius or mass were set to 0", report.repairedValues));
}

void reportDeviation(const ResampleReport& report, const HairCurves& curves, Session& session) {
  size_t root = 0;
  for (uint32_t i = 0; i < report.worstCurve; ++i) root += curves.vertexCounts[i];
  const Float3& p = curves.positions[root];
  session.add("deviation",
              {{"max", report.maxDeviation},
               {"mean", report.meanDeviation},
               {"worst_curve", report.worstCurve},
               {"worst_root", {p.x, p.y, p.z}},
               {"max_length_change", report.maxLengthChange}},
              "deviation",
              fmt::format("max {:.4g} m (strand {} with its root at {:.4g} {:.4g} {:.4g}), mean "
                          "{:.4g} m; lengths change by at most {:.3g} %",
                          report.maxDeviation, report.worstCurve, p.x, p.y, p.z,
                          report.meanDeviation, 100 * report.maxLengthChange));
  if (report.fiberRadius > 0)
    session.add("fiber_radius", report.fiberRadius, "fiber radius",
                fmt::format("{:.4g} m on average; a thickness of 1 stands for {:g} m",
                            report.fiberRadius, kUnitFiberRadius));
}

bool allHaveOneCount(const HairCurves& curves) {
  const uint32_t count = curves.vertexCounts.front();
  return count <= kMaxVerticesPerStrand &&
         std::all_of(curves.vertexCounts.begin(), curves.vertexCounts.end(),
                     [count](uint32_t other) { return other == count; });
}

void warnOfTaper(const HairCurves& curves, Session& session) {
  constexpr float kNoticed = 1.01f;  // most over least
  size_t first = 0;
  if (curves.radii.empty()) return;
  for (const uint32_t count : curves.vertexCounts) {
    const auto [least, most] =
        std::minmax_element(curves.radii.begin() + static_cast<ptrdiff_t>(first),
                            curves.radii.begin() + static_cast<ptrdiff_t>(first + count));
    first += count;
    if (*most <= kNoticed * *least) continue;
    session.warn("the thickness along a strand is not kept: a strand has one, the mean");
    return;
  }
}

// Strands with the vertices of the curves, which all have as many.
HairAsset keepVertices(const HairCurves& curves, const GroomOptions& options) {
  HairAsset asset;
  asset.strandCount = curves.curveCount();
  asset.verticesPerStrand = curves.vertexCounts.front();
  const uint32_t count = asset.verticesPerStrand;
  for (size_t i = 0; i < curves.positions.size(); ++i) {
    const size_t vertex = i % count;
    const bool tip = options.resample.bothEndsImmovable && vertex + 2 >= count;
    float mass = vertex < 2 ? 0.0f : 1.0f;
    if (!curves.inverseMasses.empty()) mass = curves.inverseMasses[i];
    const Float3& p = curves.positions[i];
    asset.positions.push_back({p.x, p.y, p.z, tip ? 0 : mass});
  }
  // Readers of .tfx give a strand one radius.
  for (size_t i = 0; i < curves.radii.size(); i += count)
    asset.strandThickness.push_back(curves.radii[i] / options.resample.unitRadius);
  asset.strandUv = curves.strandUv;
  asset.vertexUv = curves.vertexUv;
  asset.vertexColor = curves.colors;
  return asset;
}

Result<HairAsset> selectedGuides(const HairAsset& groom, const GroomOptions& options,
                                 Session& session) {
  auto selection = selectGuides(groom, options.guides, [&](uint64_t done, uint64_t total) {
    session.progress("guides", done, total);
  });
  if (!selection) return selection.error();
  const GuideReport& report = selection->report;
  session.add("guides",
              {{"count", report.guides},
               {"follow_hairs", selection->followHairs.size()},
               {"max_error", report.maxError},
               {"mean_error", report.meanError},
               {"rms_error", report.rmsError},
               {"worst_hair", report.worstHair}},
              "guides",
              fmt::format("{} of {} hairs; the others are off by {:.4g} m at most (hair {}), mean "
                          "{:.4g} m",
                          report.guides, report.hairs, report.maxError, report.worstHair,
                          report.meanError));
  if (options.follow.empty()) {
    session.warn("the hairs that are no guides are not written; --follow writes them");
    return std::move(selection->guides);
  }
  if (auto r =
          saveFollowHairs(selection->followHairs, selection->guides.strandCount, options.follow);
      !r)
    return r.error();
  session.add(
      "follow", options.follow.string(), "written",
      fmt::format("{}: {} follow hairs", options.follow.string(), selection->followHairs.size()));
  return std::move(selection->guides);
}

Result<void> writeAsset(const HairAsset& asset, const GroomOptions& options, Session& session) {
  auto sag = sagReportOf(asset, 1, options.input.string(), options.sag, session);
  if (!sag) return sag.error();
  if (*sag) session.add("sag", (*sag)->json, "sag", (*sag)->text);
  auto bytes = saveTfx(asset);
  if (!bytes) return bytes.error();
  if (auto r = saveTfx(asset, options.output); !r) return r;
  session.add("output", options.output.string(), "written",
              fmt::format("{}: {} strands of {} vertices, {} bytes", options.output.string(),
                          asset.strandCount, asset.verticesPerStrand, bytes->size()));
  session.add("strands", asset.strandCount, "", "");
  session.add("vertices_per_strand", asset.verticesPerStrand, "", "");
  session.add("output_size", bytes->size(), "", "");
  return {};
}

Result<void> passThrough(const HairAsset& asset, const GroomOptions& options, Session& session) {
  const size_t vertexCount = asset.positions.size();
  const auto size = measureHair(asset);
  if (!size) return size.error();
  if (std::string warning = program::unitWarningOf(options.input, *size, 1); !warning.empty())
    session.warn(std::move(warning));
  session.add("unchanged", true, "unchanged", "no option changes the strands");
  session.add("curves_read", asset.strandCount, "curves",
              fmt::format("{} with {} vertices", asset.strandCount, vertexCount));
  session.add("vertices_read", vertexCount, "", "");
  reportOptions(options, asset.verticesPerStrand, session);
  return writeAsset(asset, options, session);
}

Result<void> groom(GroomOptions options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".tfx"); !r) return r;
  if (!options.follow.empty())
    if (auto r = program::checkOutput(options.follow, ".tfxfollow"); !r) return r;
  HairFileReport file;
  auto curves = loadHairCurves(options.input, &file);
  if (!curves) return curves.error();
  const bool isTfx = file.kind == HairFileKind::kTfx;
  reportInput(options, file, session);
  // The thickness of a .tfx has no unit: the scale does not change it.
  if (isTfx) options.resample.unitRadius = kUnitFiberRadius * options.import.scale;
  // A .tfx 4.0 that nothing changes keeps its bytes, its zero-length strands included.
  if (isTfx && options.changesNothing())
    if (auto asset = loadTfx(options.input); asset) return passThrough(*asset, options, session);
  CurveImportReport imported;
  if (auto r = prepareCurves(*curves, options.import, &imported); !r)
    return Error{r.error().code, options.input.string() + ": " + r.error().message};
  reportCurves(imported, session);
  if (std::string warning = program::unitWarningOf(
          options.input, {imported.meanLength, imported.maxLength, {}, {}}, options.import.scale);
      !warning.empty())
    session.warn(std::move(warning));
  HairAsset asset;
  if (isTfx && !options.resampled && allHaveOneCount(*curves)) {
    asset = keepVertices(*curves, options);
    reportOptions(options, asset.verticesPerStrand, session);
  } else {
    options.resampled = true;
    auto resampled = resampleCurves(*curves, options.resample, [&](uint64_t done, uint64_t total) {
      session.progress("resampling", done, total);
    });
    if (!resampled)
      return Error{resampled.error().code,
                   options.input.string() + ": " + resampled.error().message};
    asset = std::move(resampled->asset);
    warnOfTaper(*curves, session);
    reportOptions(options, asset.verticesPerStrand, session);
    reportDeviation(resampled->report, *curves, session);
  }
  if (options.fileGuides) {
    for (uint32_t curve = 0; curve < curves->labels.size(); ++curve)
      if (curves->labels[curve].isGuide) options.guides.guides.push_back(curve);
    if (options.guides.guides.empty())
      return Error{ErrorCode::kInvalidFile,
                   fmt::format("{}: --file-guides: the file labels no curve as a guide "
                               "(primvars:groom_guide of .usda)",
                               options.input.string())};
  }
  if (options.selects()) {
    auto guides = selectedGuides(asset, options, session);
    if (!guides) return guides.error();
    asset = *std::move(guides);
  }
  return writeAsset(asset, options, session);
}

// Several inputs: a file for each in the folder OUT, and in that of --follow.
Result<void> groomAll(GroomOptions options, Session& session) {
  if (options.inputs.size() == 1) {
    options.input = options.inputs.front();
    return groom(std::move(options), session);
  }
  std::set<std::filesystem::path> names;
  for (const std::filesystem::path& input : options.inputs)
    if (!names.insert(input.stem()).second)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: another file would be written as {}.tfx, too", input.string(),
                               input.stem().string())};
  for (const std::filesystem::path& folder : {options.output, options.follow}) {
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      return Error{ErrorCode::kFileNotFound,
                   fmt::format("{}: cannot make the folder: {}", folder.string(), error.message())};
  }
  for (const std::filesystem::path& input : options.inputs) {
    GroomOptions one = options;
    one.input = input;
    one.output = options.output / (input.stem().string() + ".tfx");
    if (!options.follow.empty())
      one.follow = options.follow / (input.stem().string() + ".tfxfollow");
    session.beginFile();
    if (auto r = groom(std::move(one), session); !r) return r;
  }
  return {};
}

void addImportOptions(CLI::App& command, CurveImportDef& def) {
  addAxisOptions(command, "the file", def.scale, def.upAxis, def.invertZ);
  command.add_flag("--invert-v", def.invertV, "v of the texture becomes 1 - v");
  command.add_option("--min-curve-length", def.minCurveLength, "Drop shorter curves [m]")
      ->capture_default_str();
  command.add_flag("--randomize-strands", def.randomizeStrands,
                   "Shuffle the strands, so that the first ones are a fair sample");
  command.add_option("--seed", def.seed, "Of the shuffle, and of the choice of guides")
      ->check(isNotNegative())
      ->capture_default_str();
}

}  // namespace

void addGroomCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<GroomOptions>();
  CLI::App* command = app.add_subcommand(
      "groom",
      "Makes guide strands, .tfx, of hair curves: .tfx, .hair, .obj, .gltf, .glb, .hairtxt, .usda");
  // The last of the files is OUT; one list, because the parser gives all to the first one.
  command
      ->add_option("IN", options->inputs,
                   "Hair curves, then OUT: guide strands, .tfx; a folder for several files of "
                   "curves")
      ->required()
      ->expected(2, -1);
  addImportOptions(*command, options->import);
  CLI::Option* vertices = command->add_option(
      "--vertices-per-strand", options->resample.verticesPerStrand,
      "2 to 256, evenly along the curve; without it a .tfx keeps its vertices, others get 16");
  CLI::Option* bound =
      command
          ->add_option("--error-bound", options->resample.errorBound,
                       "Take the fewest vertices with which no curve deviates by more [m]")
          ->check(isAboveZero())
          ->excludes(vertices);
  CLI::Option* placement =
      command
          ->add_option_function<std::string>(
              "--placement",
              [options](const std::string& name) {
                options->resample.placement =
                    name == "even" ? VertexPlacement::kEven : VertexPlacement::kFitted;
              },
              "Where on the curve the vertices are: even, or fitted to its bends (even)")
          ->check(CLI::IsMember({"even", "fitted"}))
          ->type_name("TEXT");
  command->add_flag("--both-ends-immovable", options->resample.bothEndsImmovable,
                    "The last two vertices of a strand are fixed, too");
  CLI::Option* count = command
                           ->add_option("--guide-count", options->guides.guideCount,
                                        "Keep as many strands as guides for the others")
                           ->check(isAboveZero());
  CLI::Option* guideBound =
      command
          ->add_option("--guide-error-bound", options->guides.guideErrorBound,
                       "Keep as few guides as put no vertex of the others off by more [m]")
          ->check(isAboveZero())
          ->excludes(count);
  CLI::Option* fileGuides =
      command
          ->add_flag("--file-guides", options->fileGuides,
                     "Keep the curves that a .usda labels as guides (primvars:groom_guide)")
          ->excludes(count)
          ->excludes(guideBound);
  CLI::Option* follow = command->add_option("--follow", options->follow,
                                            "Write the strands that follow the guides, .tfxfollow");
  addSagOption(*command, options->sag);
  command->callback([=, &session] {
    if (*follow && !*count && !*guideBound && !*fileGuides)
      throw CLI::ValidationError("--follow",
                                 "needs --guide-count, --guide-error-bound or --file-guides");
    options->resampled = *vertices || *bound || *placement;
    options->guides.seed = options->import.seed;
    options->output = options->inputs.back();
    options->inputs.pop_back();
    session.command = [options, &session] { return groomAll(*options, session); };
  });
}

}  // namespace pelage::convert
