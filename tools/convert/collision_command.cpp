// collision: collision meshes out of a skinned mesh.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "import_options.h"
#include "output_file.h"
#include "pelage/authoring/collision_from_mesh.h"
#include "pelage/collision_mesh.h"

namespace pelage::convert {
namespace {

struct CollisionOptions {
  std::filesystem::path mesh, output;
  MeshImportDef import;
  std::string by = "whole";
  CollisionMeshDef def;
};

const std::map<std::string, CollisionSplit> kSplits = {{"whole", CollisionSplit::kWhole},
                                                       {"material", CollisionSplit::kMaterial},
                                                       {"object", CollisionSplit::kPart},
                                                       {"part", CollisionSplit::kPart},
                                                       {"bone", CollisionSplit::kBone}};

// Letters, digits and . _ - stay, so that every file system takes the name; no two are the same
// where upper and lower case are not told apart.
std::string fileName(const std::string& name, std::set<std::string>& taken) {
  const auto isPlain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  constexpr size_t kMaxLength = 100;
  std::string base = name.empty() ? "unnamed" : name.substr(0, kMaxLength);
  for (char& c : base)
    if (!isPlain(c)) c = '_';
  const auto lower = [](std::string text) {
    for (char& c : text)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
  };
  std::string result = base;
  for (int i = 2; !taken.insert(lower(result)).second; ++i) result = fmt::format("{}_{}", base, i);
  return result;
}

Result<void> makeCollision(const CollisionOptions& options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".tfxmesh"); !r) return r;
  auto mesh = loadSkinnedMesh(options.mesh);
  if (!mesh) return mesh.error();
  if (auto r = prepareMesh(*mesh, options.import); !r)
    return Error{r.error().code, options.mesh.string() + ": " + r.error().message};
  auto pieces = collisionMeshes(*mesh, options.def);
  if (!pieces)
    return Error{pieces.error().code, options.mesh.string() + ": " + pieces.error().message};
  session.add("mesh", options.mesh.string(), "mesh",
              fmt::format("{}: {} triangles, {} parts, {} bones", options.mesh.string(),
                          mesh->triangleCount(), mesh->parts.size(), mesh->bones.size()));
  std::set<std::string> taken;
  nlohmann::json list = nlohmann::json::array();
  std::string text;
  for (size_t i = 0; i < pieces->size(); ++i) {
    const NamedCollisionMesh& piece = (*pieces)[i];
    session.progress("collision meshes", i, pieces->size());
    std::filesystem::path path = options.output;
    if (options.def.by != CollisionSplit::kWhole) {
      const std::string stem = options.output.stem().string() + "_" + fileName(piece.name, taken);
      path.replace_filename(stem + ".tfxmesh");
    }
    if (auto r = saveTfxMesh(piece.mesh, path); !r) return r;
    nlohmann::json entry = {{"name", piece.name},
                            {"output", path.string()},
                            {"triangles", piece.report.triangleCount},
                            {"source_triangles", piece.sourceTriangleCount},
                            {"vertices", piece.report.vertexCount},
                            {"bones", piece.mesh.bones.size()},
                            {"caps", piece.capCount},
                            {"error", piece.error},
                            {"closed", piece.report.closed},
                            {"consistently_oriented", piece.report.consistentlyOriented},
                            {"open_edges", piece.report.openEdges},
                            {"volume", piece.report.volume}};
    list.push_back(std::move(entry));
    std::string line = fmt::format("'{}', {}", piece.name, describe(piece.report));
    if (piece.capCount > 0)
      line += fmt::format("; {} {} capped", piece.capCount, piece.capCount == 1 ? "cut" : "cuts");
    if (options.def.errorBound > 0)
      line += fmt::format("; {} triangles before, within {:.3g} m", piece.sourceTriangleCount,
                          piece.error);
    session.add("", {}, path.string(), line);
    if (!piece.report.closed)
      session.warn(fmt::format("{} is open; hair inside may not be pushed out", path.string()));
  }
  session.progress("collision meshes", pieces->size(), pieces->size());
  session.add("meshes", std::move(list), "", "");
  return {};
}

}  // namespace

void addCollisionCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<CollisionOptions>();
  CLI::App* command =
      app.add_subcommand("collision", "Makes collision meshes out of a skinned mesh, .tfxmesh");
  command->add_option("MESH", options->mesh, "Skinned mesh: glTF, FBX, ..., .tfxmesh")->required();
  command
      ->add_option("OUT", options->output,
                   "Collision mesh, .tfxmesh; pieces go to <OUT without extension>_<name>.tfxmesh")
      ->required();
  addAxisOptions(*command, "the mesh", options->import.scale, options->import.upAxis,
                 options->import.invertZ);
  command
      ->add_option("--by", options->by,
                   "whole, or a piece each material, object (part is the same) or bone")
      ->transform(CLI::IsMember({"whole", "material", "object", "part", "bone"}, CLI::ignore_case))
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--only", options->def.only,
                      "Names of the pieces to write; of the objects to take without --by");
  command->add_flag("--cap-holes,!--no-cap-holes", options->def.capHoles,
                    "Close the holes that taking apart cuts; on without being asked for");
  command
      ->add_option("--error-bound", options->def.errorBound,
                   "Simplify, within this distance of the mesh [m]; 0 keeps all triangles")
      ->capture_default_str();
  command->callback([options, &session] {
    options->def.by = kSplits.at(options->by);
    session.command = [options, &session] { return makeCollision(*options, session); };
  });
}

}  // namespace pelage::convert
