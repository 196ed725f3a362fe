// bind: bones and weights of each root, and its position on a skinned mesh.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <utility>

#include "commands.h"
#include "import_options.h"
#include "output_file.h"
#include "pelage/authoring/skin_binding.h"
#include "pelage/bone_weights.h"
#include "pelage/hair_asset.h"

namespace pelage::convert {
namespace {

// Far strands that people read; a program gets all.
constexpr size_t kStrandsListed = 8;

struct BindOptions {
  std::filesystem::path groom, mesh, output, skin, compare;
  MeshImportDef import;
  BindDef def;
};

void reportFarStrands(const BindOptions& options, const BindReport& report, Session& session) {
  std::vector<FarStrand> farthest = report.farStrands;
  std::stable_sort(farthest.begin(), farthest.end(),
                   [](const FarStrand& a, const FarStrand& b) { return a.distance > b.distance; });
  nlohmann::json strands = nlohmann::json::array();
  for (const FarStrand& strand : report.farStrands)
    strands.push_back({{"strand", strand.strand}, {"distance", strand.distance}});
  std::string text = fmt::format("{}", farthest.size());
  for (size_t i = 0; i < std::min(farthest.size(), kStrandsListed); ++i)
    text += fmt::format("{} {} ({:.4g} m)", i == 0 ? ": strand" : ",", farthest[i].strand,
                        farthest[i].distance);
  if (farthest.size() > kStrandsListed) text += ", ...";
  session.add("far_strands", std::move(strands),
              fmt::format("farther than {:g} m", options.def.maxDistance), std::move(text));
  if (!farthest.empty())
    session.warn(
        fmt::format("{} strands do not touch the mesh; the farthest, strand {}, is {:.4g} m "
                    "from it (if that is most of them: do --scale and --up-axis of the mesh fit?)",
                    farthest.size(), farthest[0].strand, farthest[0].distance));
}

Result<void> reportComparison(const BindOptions& options, const BoneWeights& weights,
                              Session& session) {
  auto other = loadTfxBone(options.compare, static_cast<uint32_t>(weights.strands.size()));
  if (!other) return other.error();
  auto comparison = compareWeights(weights, *other);
  if (!comparison) return comparison.error();
  session.add("compared_with", options.compare.string(), "compared with", options.compare.string());
  session.add("weight_difference",
              {{"mean", comparison->mean},
               {"max", comparison->max},
               {"share_above_tenth", comparison->shareAboveTenth}},
              "weight difference",
              fmt::format("mean {:.4f}, max {:.4f} (of 2); above 0.1: {:.2f} % of the strands",
                          comparison->mean, comparison->max, 100 * comparison->shareAboveTenth));
  return {};
}

Result<void> bind(const BindOptions& options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".tfxbone"); !r) return r;
  if (!options.skin.empty())
    if (auto r = program::checkOutput(options.skin, ".tfxskin"); !r) return r;
  auto groom = loadTfx(options.groom);
  if (!groom) return groom.error();
  auto mesh = loadSkinnedMesh(options.mesh);
  if (!mesh) return mesh.error();
  if (auto r = prepareMesh(*mesh, options.import); !r)
    return Error{r.error().code, options.mesh.string() + ": " + r.error().message};
  auto binding = bindRoots(rootsOf(*groom), *mesh, options.def);
  if (!binding)
    return Error{binding.error().code, options.mesh.string() + ": " + binding.error().message};
  if (auto r = saveTfxBone(binding->weights, options.output); !r) return r;
  if (!options.skin.empty())
    if (auto r = saveTfxSkin(binding->table, options.skin); !r) return r;

  const BindReport& report = binding->report;
  session.add("groom", options.groom.string(), "groom",
              fmt::format("{}: {} strands", options.groom.string(), groom->strandCount));
  session.add("strands", groom->strandCount, "", "");
  session.add("mesh", options.mesh.string(), "mesh",
              fmt::format("{}: {} triangles, {} parts, {} bones", options.mesh.string(),
                          mesh->triangleCount(), mesh->parts.size(), mesh->bones.size()));
  session.add("bones", binding->weights.bones.size(), "bones in use",
              fmt::format("{}", binding->weights.bones.size()));
  session.add("distance", {{"mean", report.meanDistance}, {"max", report.maxDistance}}, "distance",
              fmt::format("mean {:.4g} m, max {:.4g} m", report.meanDistance, report.maxDistance));
  reportFarStrands(options, report, session);
  session.add("max_lost_weight", report.maxLostWeight, "lost weight",
              fmt::format("at most {:.4g} by the limit of {} bones", report.maxLostWeight,
                          options.def.maxBones));
  session.add("degenerate_triangles", report.degenerateTriangles, "without area",
              fmt::format("{} triangles, to which nothing is bound", report.degenerateTriangles));
  if (mesh->repairedVertexCount > 0)
    session.warn(fmt::format("{} vertices of the mesh have no weights and follow their node",
                             mesh->repairedVertexCount));
  if (!options.compare.empty())
    if (auto r = reportComparison(options, binding->weights, session); !r) return r;
  session.add("output", options.output.string(), "written", options.output.string());
  if (!options.skin.empty())
    session.add("skin", options.skin.string(), "written", options.skin.string());
  return {};
}

}  // namespace

void addBindCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<BindOptions>();
  CLI::App* command = app.add_subcommand(
      "bind", "Binds the roots of a groom to a skinned mesh: bones and weights, .tfxbone");
  command->add_option("GROOM", options->groom, "Hair, .tfx")->required();
  command->add_option("MESH", options->mesh, "Skinned mesh: glTF, FBX, ..., .tfxmesh")->required();
  command->add_option("OUT", options->output, "Bones and weights, .tfxbone")->required();
  addAxisOptions(*command, "the mesh", options->import.scale, options->import.upAxis,
                 options->import.invertZ);
  command->add_option("--skin", options->skin,
                      "Also write the position of each root on the mesh, .tfxskin");
  command
      ->add_option("--max-distance", options->def.maxDistance,
                   "Report strands whose root is farther from the mesh than this [m]")
      ->capture_default_str();
  command->add_option("--max-bones", options->def.maxBones, "Bones a strand, 1 to 4")
      ->capture_default_str();
  command->add_option("--compare", options->compare,
                      "Report the difference from the weights of another .tfxbone");
  command->callback([options, &session] {
    session.command = [options, &session] { return bind(*options, session); };
  });
}

}  // namespace pelage::convert
