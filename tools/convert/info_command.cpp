// info: what a file holds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "pelage/authoring/curve_import.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"

namespace pelage::convert {
namespace {

// Names of bones that people read; a program gets all.
constexpr size_t kBonesListed = 8;

void reportBounds(const std::vector<Float3>& points, Session& session) {
  Float3 low = points.front(), high = low;
  for (const Float3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
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

Result<void> curvesInfo(const std::filesystem::path& path, Session& session) {
  HairFileReport file;
  auto curves = loadHairCurves(path, &file);
  if (!curves) return curves.error();
  reportFile(path, "hair curves", file.format, session);
  session.add("notes", file.notes, "", "");
  for (const std::string& note : file.notes) session.warn(note);
  CurveImportReport report;
  if (auto r = prepareCurves(*curves, {}, &report); !r)
    return Error{ErrorCode::kInvalidFile, path.string() + ": " + r.error().message};
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
              fmt::format("{:.4g} to {:.4g}, mean {:.4g} (units of the file)", report.minLength,
                          report.maxLength, report.meanLength));
  reportBounds(curves->positions, session);
  std::vector<std::string> arrays;
  const std::array<std::pair<const char*, bool>, 5> all = {
      {{"inverse masses", !curves->inverseMasses.empty()},
       {"radii", !curves->radii.empty()},
       {"colours", !curves->colors.empty()},
       {"vertex UV", !curves->vertexUv.empty()},
       {"strand UV", !curves->strandUv.empty()}}};
  std::string text;
  for (const auto& [name, there] : all) {
    if (!there) continue;
    arrays.emplace_back(name);
    text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
  }
  session.add("arrays", arrays, "arrays", text.empty() ? "positions alone" : text);
  return {};
}

Result<void> tfxBoneInfo(const std::filesystem::path& path, Session& session) {
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

Result<void> tfxMeshInfo(const std::filesystem::path& path, Session& session) {
  auto mesh = loadTfxMesh(path);
  if (!mesh) return mesh.error();
  reportFile(path, "collision mesh", ".tfxmesh", session);
  session.add("vertices", mesh->positions.size(), "vertices",
              fmt::format("{}", mesh->positions.size()));
  session.add("triangles", mesh->indices.size() / 3, "triangles",
              fmt::format("{}", mesh->indices.size() / 3));
  reportBones(mesh->bones, session);
  reportBounds(mesh->positions, session);
  return {};
}

struct Kind {
  const char* extension;
  Result<void> (*info)(const std::filesystem::path& path, Session& session);
};
// Everything else is hair curves, or an error that says so.
constexpr std::array kKinds = {Kind{".tfxbone", tfxBoneInfo}, Kind{".tfxmesh", tfxMeshInfo}};

Result<void> info(const std::filesystem::path& path, Session& session) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Kind& kind : kKinds)
    if (extension == kind.extension) return kind.info(path, session);
  return curvesInfo(path, session);
}

}  // namespace

void addInfoCommand(CLI::App& app, Session& session) {
  auto file = std::make_shared<std::filesystem::path>();
  CLI::App* command = app.add_subcommand(
      "info", "Says what a file holds: hair curves, bone weights, a collision mesh");
  command->add_option("FILE", *file, "Any file that pelage-convert reads or writes")->required();
  command->callback(
      [file, &session] { session.command = [file, &session] { return info(*file, session); }; });
}

}  // namespace pelage::convert
