#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/sdf_collider.h"
#include "pelage/skin_table.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

template <class T>
bool allFinite(const std::vector<T>& values) {
  const auto* numbers = reinterpret_cast<const float*>(values.data());
  return std::all_of(numbers, numbers + values.size() * (sizeof(T) / sizeof(float)),
                     [](float v) { return std::isfinite(v); });
}

bool isProcessed(const HairAsset& asset) {
  return allFinite(asset.restLengths) && allFinite(asset.restFrames) &&
         allFinite(asset.restVectors) && allFinite(asset.tangents) &&
         allFinite(asset.inverseMasses) && allFinite(asset.vertexThickness);
}

bool areInfluences(const std::vector<BoneInfluences>& influences, size_t boneCount) {
  return std::all_of(influences.begin(), influences.end(), [&](const BoneInfluences& entry) {
    float sum = 0;
    for (int k = 0; k < 4; ++k) {
      if (entry.bones[k] >= boneCount || !(entry.weights[k] >= 0)) return false;
      sum += entry.weights[k];
    }
    return sum > 0 && std::isfinite(sum);
  });
}

}  // namespace

Outcome tfx(std::span<const std::byte> bytes) {
  if (auto repaired = loadTfx(bytes, kName, {.repair = true})) {
    if (!validate(*repaired)) return broken("a repaired asset is not valid");
    if (!repaired->process() || !isProcessed(*repaired))
      return broken("a repaired asset has rest data that are not finite");
  }
  auto asset = loadTfx(bytes, kName);
  if (!asset) return refused(asset.error());
  if (!validate(*asset)) return broken("the asset is not valid");
  const auto saved = saveTfx(*asset);
  if (!saved || !std::equal(saved->begin(), saved->end(), bytes.begin(), bytes.end()))
    return broken("saving does not give the same bytes");
  const auto part =
      loadTfx(bytes, kName, {.maxStrands = (asset->strandCount + 1) / 2, .vertexUv = false});
  if (!part || !isStart(part->positions, asset->positions) ||
      !isStart(part->strandThickness, asset->strandThickness) || !saveTfx(*part))
    return broken("the first strands differ from those of the whole file");
  if (!asset->process() || !isProcessed(*asset) || !packRest(*asset))
    return broken("rest data are not finite");
  return {true, {}};
}

Outcome tfxbone(std::span<const std::byte> bytes) {
  const auto weights = loadTfxBone(bytes, kName);
  if (!weights) return refused(weights.error());
  if (!areInfluences(weights->strands, weights->bones.size()))
    return broken("an influence is out of range");
  const auto saved = saveTfxBone(*weights);
  if (!saved) return broken("cannot be saved: " + saved.error().message);
  const auto again = loadTfxBone(*saved, kName, static_cast<uint32_t>(weights->strands.size()));
  if (!again || again->bones != weights->bones || !sameBits(again->strands, weights->strands))
    return broken("saving and loading gives something else");
  return {true, {}};
}

Outcome tfxmesh(std::span<const std::byte> bytes) {
  const auto mesh = loadTfxMesh(
      std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()), kName);
  if (!mesh) return refused(mesh.error());
  if (!areInfluences(mesh->influences, mesh->bones.size()) || !allFinite(mesh->positions) ||
      !allFinite(mesh->normals))
    return broken("a number is out of range");
  if (!inspectMesh(*mesh)) return broken("an index is out of range");
  const auto saved = saveTfxMesh(*mesh);
  if (!saved) return broken("cannot be saved: " + saved.error().message);
  const auto again = loadTfxMesh(std::string_view(*saved), kName);
  if (!again || again->bones != mesh->bones || !sameBits(again->positions, mesh->positions) ||
      !sameBits(again->normals, mesh->normals) || !sameBits(again->influences, mesh->influences) ||
      !sameBits(again->indices, mesh->indices))
    return broken("saving and loading gives something else");
  return {true, {}};
}

Outcome tfxskin(std::span<const std::byte> bytes) {
  const auto table = loadTfxSkin(bytes, kName);
  if (!table) return refused(table.error());
  if (!validate(*table)) return broken("the table is not valid");
  for (const SurfaceRoot& root : table->roots) {
    const Float3 p = bindPosition(root);
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      return broken("a bind position is not finite");
  }
  const auto saved = saveTfxSkin(*table);
  if (!saved || !std::equal(saved->begin(), saved->end(), bytes.begin(), bytes.end()))
    return broken("saving does not give the same bytes");
  return {true, {}};
}

Outcome tfxfollow(std::span<const std::byte> bytes) {
  const auto hairs = loadFollowHairs(bytes, kName, 0);
  if (!hairs) return refused(hairs.error());
  uint32_t guideCount = 1;
  for (const FollowHair& hair : *hairs)
    guideCount =
        std::max({guideCount, hair.guide + 1, hair.otherGuides[0] + 1, hair.otherGuides[1] + 1});
  if (guideCount == 0) return broken("a guide has the number 2^32 - 1");
  const auto saved = saveFollowHairs(*hairs, guideCount);
  if (!saved) return broken("cannot be saved: " + saved.error().message);
  const auto again = loadFollowHairs(*saved, kName, guideCount);
  if (!again || !sameBits(*again, *hairs)) return broken("saving and loading gives something else");
  return {true, {}};
}

Outcome psdf(std::span<const std::byte> bytes) {
  const auto field = loadSdf(bytes, kName);
  if (!field) return refused(field.error());
  const uint64_t nodes =
      uint64_t{field->grid.nodes[0]} * field->grid.nodes[1] * field->grid.nodes[2];
  if (field->keys.size() != nodes || field->surface.size() != uint64_t{16} * field->triangleCount)
    return broken("the arrays do not have their sizes");
  return {true, {}};
}

}  // namespace pelage::fuzz
