// info: what a file holds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "asset_files.h"
#include "commands.h"
#include "import_options.h"
#include "pelage/asset_cache.h"
#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/skinned_mesh.h"
#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_cache.h"
#include "pelage/sdf_collider.h"
#include "pelage/settings/settings_file.h"
#include "pelage/skin_table.h"
#include "sag_report.h"

namespace pelage::convert {
namespace {

struct InfoOptions {
  std::vector<std::filesystem::path> files;
  std::filesystem::path file;  // the one at hand
  float scale = 1;             // of all lengths
  SagOptions sag;
};

// Names of bones that people read; a program gets all.
constexpr size_t kBonesListed = 8;

void reportBounds(const std::vector<Float3>& points, float scale, Session& session) {
  Float3 low = points.front(), high = low;
  for (const Float3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  low = {low.x * scale, low.y * scale, low.z * scale};
  high = {high.x * scale, high.y * scale, high.z * scale};
  session.add("bounds", {{"min", {low.x, low.y, low.z}}, {"max", {high.x, high.y, high.z}}},
              "bounds",
              fmt::format("{:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g}", low.x, low.y, low.z,
                          high.x, high.y, high.z));
}

void reportBones(const std::vector<BoneName>& bones, Session& session) {
  nlohmann::json names = nlohmann::json::array();
  std::string text = fmt::format("{}", bones.size());
  for (size_t i = 0; i < bones.size(); ++i) {
    names.push_back({{"index", bones[i].index}, {"name", bones[i].name}});
    if (i < kBonesListed) text += fmt::format("{} {}", i == 0 ? ":" : ",", bones[i].name);
  }
  if (bones.size() > kBonesListed) text += ", ...";
  session.add("bones", std::move(names), "bones", std::move(text));
}

void reportFile(const std::filesystem::path& path, std::string_view kind, std::string_view format,
                Session& session) {
  std::error_code ignored;
  const uint64_t size = std::filesystem::file_size(path, ignored);
  session.add("file", path.string(), "file", path.string());
  session.add("kind", kind, "kind", fmt::format("{}, {}", kind, format));
  session.add("format", format, "", "");
  session.add("size", size, "size", fmt::format("{} bytes", size));
}

void warnOfUnit(const std::filesystem::path& name, const HairSize& size, const InfoOptions& options,
                Session& session) {
  std::string warning = program::unitWarningOf(name, size, options.scale);
  if (!warning.empty()) session.warn(std::move(warning));
}

Result<void> curvesInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  HairFileReport file;
  auto curves = loadHairCurves(path, &file);
  if (!curves) return curves.error();
  CurveImportReport report;
  if (auto r = prepareCurves(*curves, {.scale = options.scale}, &report); !r)
    return Error{ErrorCode::kInvalidFile, path.string() + ": " + r.error().message};
  reportFile(path, "hair curves", file.format, session);
  session.add("notes", file.notes, "", "");
  for (const std::string& note : file.notes) session.warn(note);
  const auto [fewest, most] =
      std::minmax_element(curves->vertexCounts.begin(), curves->vertexCounts.end());
  session.add("curves", report.curvesRead, "curves",
              fmt::format("{} with {} vertices", report.curvesRead, report.verticesRead));
  session.add("vertices", report.verticesRead, "", "");
  session.add(
      "vertices_per_curve", {{"min", *fewest}, {"max", *most}}, "vertices a curve",
      *fewest == *most ? fmt::format("{}", *most) : fmt::format("{} to {}", *fewest, *most));
  session.add("degenerate",
              {{"curves", report.curvesDropped()},
               {"vertices", report.removedVertices},
               {"values", report.repairedValues}},
              "degenerate",
              fmt::format("{} curves, {} vertices, {} other values", report.curvesDropped(),
                          report.removedVertices, report.repairedValues));
  session.add("length",
              {{"min", report.minLength}, {"mean", report.meanLength}, {"max", report.maxLength}},
              "length",
              fmt::format("{:.4g} to {:.4g} m, mean {:.4g} m", report.minLength, report.maxLength,
                          report.meanLength));
  warnOfUnit(path, {report.meanLength, report.maxLength, {}, {}}, options, session);
  reportBounds(curves->positions, 1, session);
  std::vector<std::string> arrays;
  const std::array<std::pair<const char*, bool>, 6> all = {
      {{"inverse masses", !curves->inverseMasses.empty()},
       {"radii", !curves->radii.empty()},
       {"colors", !curves->colors.empty()},
       {"vertex UV", !curves->vertexUv.empty()},
       {"strand UV", !curves->strandUv.empty()},
       {"labels", !curves->labels.empty()}}};
  std::string text;
  for (const auto& [name, there] : all) {
    if (!there) continue;
    arrays.emplace_back(name);
    text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
  }
  if (!curves->radii.empty()) {
    double sum = 0;
    for (const float radius : curves->radii) sum += double{radius};
    // The radii of a .tfx come from a factor without a unit.
    const double unit = file.kind == HairFileKind::kTfx ? double{options.scale} : 1.0;
    const double mean = sum / static_cast<double>(curves->radii.size()) / unit;
    session.add("fiber_radius", mean, "fiber radius", fmt::format("{:.4g} m on average", mean));
  }
  if (!curves->labels.empty()) {
    const auto guides = std::count_if(curves->labels.begin(), curves->labels.end(),
                                      [](const CurveLabel& label) { return label.isGuide; });
    session.add("guides", guides, "guides", fmt::format("{} of the curves", guides));
  }
  session.add("arrays", arrays, "arrays", text.empty() ? "positions alone" : text);
  if (options.sag.settings.empty() || file.kind != HairFileKind::kTfx) return {};
  auto guides = loadTfx(path, {.repair = true});
  if (!guides) return guides.error();
  auto sag = sagReportOf(*std::move(guides), options.scale, path.string(), options.sag, session);
  if (!sag) return sag.error();
  if (*sag) session.add("sag", (*sag)->json, "sag", (*sag)->text);
  return {};
}

Result<void> tfxBoneInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto weights = loadTfxBone(path);
  if (!weights) return weights.error();
  reportFile(path, "bone weights", ".tfxbone", session);
  session.add("strands", weights->strands.size(), "strands",
              fmt::format("{}", weights->strands.size()));
  reportBones(weights->bones, session);
  session.add("repaired_strands", weights->repairedStrandCount, "without weights",
              fmt::format("{} strands", weights->repairedStrandCount));
  return {};
}

Result<void> tfxMeshInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto mesh = loadTfxMesh(path);
  if (!mesh) return mesh.error();
  reportFile(path, "collision mesh", ".tfxmesh", session);
  session.add("vertices", mesh->positions.size(), "vertices",
              fmt::format("{}", mesh->positions.size()));
  session.add("triangles", mesh->indices.size() / 3, "triangles",
              fmt::format("{}", mesh->indices.size() / 3));
  reportBones(mesh->bones, session);
  reportBounds(mesh->positions, options.scale, session);
  return {};
}

Result<void> tfxSkinInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto table = loadTfxSkin(path);
  if (!table) return table.error();
  reportFile(path, "roots on a mesh", ".tfxskin", session);
  session.add("strands", table->roots.size(), "strands", fmt::format("{}", table->roots.size()));
  std::vector<uint64_t> roots(table->parts.size());
  double farthest = 0;
  for (const SurfaceRoot& root : table->roots) {
    ++roots[root.part];
    farthest = std::max(
        farthest, std::hypot(double{root.offset.x}, double{root.offset.y}, double{root.offset.z}));
  }
  farthest *= double{options.scale};
  session.add("max_distance", farthest, "distance",
              fmt::format("at most {:.4g} m from the mesh", farthest));
  nlohmann::json parts = nlohmann::json::array();
  for (size_t i = 0; i < roots.size(); ++i) {
    const SkinPart& part = table->parts[i];
    parts.push_back({{"name", part.name},
                     {"mesh", part.mesh},
                     {"material", part.material},
                     {"vertices", part.vertexCount},
                     {"triangles", part.triangleCount},
                     {"roots", roots[i]}});
    session.add("", {}, "part",
                fmt::format("'{}': {} vertices, {} triangles, {} roots", part.name,
                            part.vertexCount, part.triangleCount, roots[i]));
  }
  session.add("parts", std::move(parts), "", "");
  return {};
}

Result<void> tfxFollowInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto hairs = loadFollowHairs(path, 0);
  if (!hairs) return hairs.error();
  reportFile(path, "follow hairs", ".tfxfollow", session);
  uint32_t lastGuide = 0;
  std::array<uint64_t, 3> byGuides = {};  // hairs of one, two and three guides
  for (const FollowHair& hair : *hairs) {
    size_t others = 0;
    lastGuide = std::max(lastGuide, hair.guide);
    for (size_t k = 0; k < 2; ++k) {
      if (!(hair.otherWeights[k] > 0)) continue;
      ++others;
      lastGuide = std::max(lastGuide, hair.otherGuides[k]);
    }
    ++byGuides[others];
  }
  session.add("follow_hairs", hairs->size(), "follow hairs",
              fmt::format("{}: {} of one guide, {} of two, {} of three", hairs->size(), byGuides[0],
                          byGuides[1], byGuides[2]));
  session.add("hairs_by_guides", byGuides, "", "");
  if (!hairs->empty())
    session.add("last_guide", lastGuide, "last guide", fmt::format("{}", lastGuide));
  return {};
}

Result<void> cacheInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto cache = loadAssetCache(path);
  if (!cache) return cache.error();
  reportFile(path, "cache of assets", fmt::format(".pelage version {}", kAssetCacheVersion),
             session);
  nlohmann::json hairs = nlohmann::json::array(), meshes = hairs, sources = hairs;
  for (const CachedHair& hair : cache->hairs) {
    const size_t bones = hair.bones ? hair.bones->bones.size() : 0;
    auto size = measureHair(hair.asset);
    if (!size) return Error{size.error().code, path.string() + ": " + size.error().message};
    size->meanLength *= double{options.scale};
    size->maxLength *= double{options.scale};
    warnOfUnit(path.string() + ": " + hair.name, *size, options, session);
    hairs.push_back({{"name", hair.name},
                     {"length", {{"mean", size->meanLength}, {"max", size->maxLength}}},
                     {"strands", hair.asset.strandCount},
                     {"vertices_per_strand", hair.asset.verticesPerStrand},
                     {"bones", bones},
                     {"follow_hairs", hair.followHairs.size()}});
    auto sag = sagReportOf(hair.asset, options.scale, path.string() + ": " + hair.name, options.sag,
                           session);
    if (!sag) return sag.error();
    if (*sag) hairs.back()["sag"] = (*sag)->json;
    session.add(
        "", {}, "hair",
        fmt::format("'{}': {} strands of {} vertices, {:.4g} m long on average, {} bones, {} "
                    "follow hairs",
                    hair.name, hair.asset.strandCount, hair.asset.verticesPerStrand,
                    size->meanLength, bones, hair.followHairs.size()));
    if (*sag) session.add("", {}, "sag", fmt::format("'{}': {}", hair.name, (*sag)->text));
  }
  for (const CachedMesh& mesh : cache->meshes) {
    meshes.push_back({{"name", mesh.name},
                      {"vertices", mesh.mesh.positions.size()},
                      {"triangles", mesh.mesh.indices.size() / 3},
                      {"bones", mesh.mesh.bones.size()},
                      {"prepared", mesh.mesh.prepared != nullptr}});
    session.add("", {}, "mesh",
                fmt::format("'{}': {} vertices, {} triangles, {} bones", mesh.name,
                            mesh.mesh.positions.size(), mesh.mesh.indices.size() / 3,
                            mesh.mesh.bones.size()));
  }
  for (const SourceKey& source : cache->sources) {
    sources.push_back({{"name", source.name},
                       {"size", source.size},
                       {"hash", fmt::format("{:016x}", source.hash)}});
    session.add("", {}, "made from", fmt::format("{}, {} bytes", source.name, source.size));
  }
  session.add("hairs", std::move(hairs), "", "");
  session.add("meshes", std::move(meshes), "", "");
  session.add("sources", std::move(sources), "", "");
  // Names of sources are relative to where the cache was made.
  const auto stale = findStaleSource(cache->sources, {});
  session.add(
      "stale_source", stale ? nlohmann::json(stale->name) : nlohmann::json(), "stale",
      stale ? fmt::format("{} has changed, or is not there when looked for from here", stale->name)
            : "no");
  return {};
}

// Reads all frames, so that a file that is reported is good.
Result<void> hairCacheInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto reader = HairCacheReader::open(path);
  if (!reader) return reader.error();
  const HairCacheDef& def = reader->def();
  const uint64_t frames = reader->frameCount();
  std::vector<Float3> positions(reader->vertexCount());
  for (uint64_t frame = 0; frame < frames; ++frame) {
    session.progress("frames", frame, frames);
    if (auto r = reader->read(frame, positions); !r) return r;
  }
  session.progress("frames", frames, frames);
  reportFile(path, "simulated hair", fmt::format(".pelagecache version {}", kHairCacheVersion),
             session);
  session.add("name", def.name, "name", def.name);
  session.add("strands", def.strandCount, "strands",
              fmt::format("{} with {} vertices", def.strandCount, positions.size()));
  session.add("vertices", positions.size(), "", "");
  session.add("first_frame", def.firstFrame, "", "");
  session.add("frames_per_second", def.framesPerSecond, "", "");
  session.add(
      "frames", frames, "frames",
      fmt::format("{} from {}, {:.6g} a second", frames, def.firstFrame, def.framesPerSecond));
  session.add("error_bound", def.errorBound, "error",
              def.errorBound > 0 ? fmt::format("at most {:.4g} m", def.errorBound) : "none");
  std::error_code ignored;
  const auto size = static_cast<double>(std::filesystem::file_size(path, ignored));
  const double each = size / (static_cast<double>(positions.size()) *
                              static_cast<double>(std::max<uint64_t>(frames, 1)));
  session.add("bytes_per_vertex", each, "density",
              fmt::format("{:.3g} bytes a vertex and frame", each));
  return {};
}

Result<void> sdfInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto field = loadSdf(path);
  if (!field) return field.error();
  reportFile(path, "distance field", ".psdf", session);
  const SdfGrid& grid = field->grid;
  session.add("nodes", grid.nodes, "nodes",
              fmt::format("{} x {} x {}", grid.nodes[0], grid.nodes[1], grid.nodes[2]));
  const float cell = grid.cellSize * options.scale;
  session.add("cell_size", cell, "cell size", fmt::format("{:.4g} m", cell));
  const Float3 origin = {grid.origin.x * options.scale, grid.origin.y * options.scale,
                         grid.origin.z * options.scale};
  session.add("origin", {origin.x, origin.y, origin.z}, "origin",
              fmt::format("{:.4g} {:.4g} {:.4g}", origin.x, origin.y, origin.z));
  session.add("triangles", field->triangleCount, "triangles",
              fmt::format("{}", field->triangleCount));
  return {};
}

Result<void> meshInfo(const InfoOptions& options, Session& session) {
  const std::filesystem::path& path = options.file;
  auto mesh = loadSkinnedMesh(path);
  if (!mesh) return mesh.error();
  reportFile(path, "mesh", "for bind and collision", session);
  session.add("vertices", mesh->positions.size(), "vertices",
              fmt::format("{}", mesh->positions.size()));
  session.add("triangles", mesh->triangleCount(), "triangles",
              fmt::format("{}", mesh->triangleCount()));
  nlohmann::json parts = nlohmann::json::array();
  for (const SkinnedMeshPart& part : mesh->parts) {
    parts.push_back({{"name", part.name},
                     {"mesh", part.mesh},
                     {"material", part.material},
                     {"vertices", part.vertexCount},
                     {"triangles", part.triangleCount}});
    session.add("", {}, "part",
                fmt::format("'{}', material '{}': {} triangles", part.name, part.material,
                            part.triangleCount));
  }
  session.add("parts", std::move(parts), "", "");
  reportBones(mesh->bones, session);
  session.add("vertices_without_weights", mesh->repairedVertexCount, "without weights",
              fmt::format("{} vertices", mesh->repairedVertexCount));
  reportBounds(mesh->positions, options.scale, session);
  return {};
}

Result<void> settingsInfo(const InfoOptions& options, Session& session) {
  auto settings = SettingsFile::load(options.file);
  if (!settings) return settings.error();
  reportFile(options.file, "settings", "JSON", session);
  std::string names;
  for (const std::string& name : settings->names()) names += (names.empty() ? "" : ", ") + name;
  session.add("settings", settings->names(), "settings", names.empty() ? "none" : names);
  return {};
}

// Hair, or else a mesh: .obj, .gltf and .glb may be either, and what only a mesh can be in is for
// the importer of meshes. What is neither has the error of the one that its name stands for.
Result<void> curvesOrMeshInfo(const InfoOptions& options, const std::string& extension,
                              Session& session) {
  auto curves = curvesInfo(options, session);
  if (curves || curves.error().code == ErrorCode::kFileNotFound) return curves;
  constexpr std::array kHairAlone = {".tfx",  ".tfxb", ".hair", ".hairtxt",
                                     ".usda", ".usd",  ".usdc", ".usdz"};
  if (std::find(kHairAlone.begin(), kHairAlone.end(), extension) != kHairAlone.end()) return curves;
  auto mesh = meshInfo(options, session);
  const bool namesHair = extension == ".obj" || extension == ".gltf" || extension == ".glb";
  return mesh || !namesHair ? mesh : curves;
}

struct Kind {
  const char* extension;
  Result<void> (*info)(const InfoOptions& options, Session& session);
};
constexpr std::array kKinds = {Kind{".tfxbone", tfxBoneInfo}, Kind{".tfxmesh", tfxMeshInfo},
                               Kind{".tfxskin", tfxSkinInfo}, Kind{".tfxfollow", tfxFollowInfo},
                               Kind{".pelage", cacheInfo},    Kind{".psdf", sdfInfo},
                               Kind{".json", settingsInfo},   Kind{".pelagecache", hairCacheInfo}};

Result<void> fileInfo(const InfoOptions& options, Session& session) {
  const std::string extension = program::lowerExtension(options.file);
  for (const Kind& kind : kKinds)
    if (extension == kind.extension) return kind.info(options, session);
  return curvesOrMeshInfo(options, extension, session);
}

Result<void> info(InfoOptions options, Session& session) {
  for (const std::filesystem::path& file : options.files) {
    options.file = file;
    session.beginFile();
    auto r = fileInfo(options, session);
    if (!r && options.files.size() == 1) return r;
    if (!r) session.fail(file.string(), r.error().message);
  }
  return {};
}

}  // namespace

void addInfoCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand(
      "info",
      "Says what files hold: hair curves, bone weights, follow hairs, a mesh, a cache, settings, "
      "...");
  command->add_option("FILE", options->files, "Any files that pelage-convert reads or writes")
      ->required();
  command->add_option("--scale", options->scale, "Metres a unit of the file")
      ->check(isAboveZero())
      ->capture_default_str();
  addSagOption(*command, options->sag);
  command->callback([options, &session] {
    session.command = [options, &session] { return info(*options, session); };
  });
}

}  // namespace pelage::convert
