#include "skin_mesh.h"

#include <fmt/format.h>

#include <utility>

#include "json_members.h"
#include "obj_mesh.h"
#include "pelage/authoring/skin_binding.h"

namespace pelage::bake {
namespace {

Result<CollisionMesh> loadFile(const std::filesystem::path& path) {
  if (path.extension() != ".obj") return loadTfxMesh(path);
  const auto text = loadText(path.string());
  if (!text) return text.error();
  return readObjMesh(*text, path.string());
}

}  // namespace

Result<CollisionMesh> loadSkinMesh(const std::filesystem::path& path, float scale) {
  auto mesh = loadFile(path);
  if (!mesh) return mesh;
  for (Float3& p : mesh->positions) p = {scale * p.x, scale * p.y, scale * p.z};
  mesh->bones.clear();
  mesh->influences = oneBoneAStrand(static_cast<uint32_t>(mesh->positions.size()));
  mesh->prepared = nullptr;
  return mesh;
}

Result<SkinTable> bindToSkin(const HairAsset& hair, const CollisionMesh& mesh,
                             std::string& warning) {
  SkinnedMesh skin;
  const auto vertices = static_cast<uint32_t>(mesh.positions.size());
  const auto triangles = static_cast<uint32_t>(mesh.indices.size() / 3);
  skin.parts = {{"skin", "", "", 0, vertices, 0, triangles}};
  skin.bones = {{0, "skin"}};
  skin.positions = mesh.positions;
  skin.normals.resize(vertices);
  BoneInfluences one;
  one.weights[0] = 1;
  skin.influences.assign(vertices, one);
  skin.indices = mesh.indices;
  auto binding = bindRoots(rootsOf(hair), skin);
  if (!binding) return binding.error();
  const BindReport& report = binding->report;
  if (!report.farStrands.empty())
    warning = fmt::format("{} of {} roots are not on the skin, the farthest {:.3g} mm from it",
                          report.farStrands.size(), hair.strandCount, 1e3 * report.maxDistance);
  return std::move(binding->table);
}

}  // namespace pelage::bake
