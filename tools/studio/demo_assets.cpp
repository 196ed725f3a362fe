#include "demo_assets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>
#include <unordered_map>

#include "gltf_file.h"
#include "names.h"

namespace sample {

namespace {

template <class T>
void repeatArray(std::vector<T>& array, uint32_t copies) {
  const size_t once = array.size();
  array.reserve(once * copies);
  for (uint32_t copy = 1; copy < copies; ++copy)
    array.insert(array.end(), array.begin(), array.begin() + static_cast<ptrdiff_t>(once));
}

// Points in cells as large as the reach of a search, so that a search looks at 27 of them.
class PointGrid {
 public:
  explicit PointGrid(float cell) : cell_(cell) {}

  void add(const Float3& p) { cells_[key(index(p.x), index(p.y), index(p.z))].push_back(p); }

  /// Distance to the nearest point, or the cell's size when there is none within it.
  float nearest(const Float3& p) const {
    float best = cell_ * cell_;
    const int64_t x = index(p.x), y = index(p.y), z = index(p.z);
    for (int64_t dx = -1; dx <= 1; ++dx)
      for (int64_t dy = -1; dy <= 1; ++dy)
        for (int64_t dz = -1; dz <= 1; ++dz) {
          const auto found = cells_.find(key(x + dx, y + dy, z + dz));
          if (found == cells_.end()) continue;
          for (const Float3& q : found->second) {
            const float ex = q.x - p.x, ey = q.y - p.y, ez = q.z - p.z;
            best = std::min(best, ex * ex + ey * ey + ez * ez);
          }
        }
    return std::sqrt(best);
  }

 private:
  int64_t index(float v) const { return static_cast<int64_t>(std::floor(v / cell_)); }
  // 21 bits an axis; where far cells share a key, a search only looks at more points.
  static uint64_t key(int64_t x, int64_t y, int64_t z) {
    const auto low = [](int64_t v) { return static_cast<uint64_t>(v) & 0x1fffffu; };
    return low(x) << 42 | low(y) << 21 | low(z);
  }

  float cell_;
  std::unordered_map<uint64_t, std::vector<Float3>> cells_;
};

float smoothStep(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

constexpr float kHidingThickness = 0.6f;

Result<void> makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kFileNotFound,
                 folder.string() + ": cannot make the folder: " + error.message()};
  return {};
}

}  // namespace

uint32_t DemoAssets::boneCount() const {
  const size_t ofMesh = mesh ? mesh->bones.size() : 0;
  return static_cast<uint32_t>(std::max({weights.bones.size(), ofMesh, size_t{1}}));
}

Result<DemoAssets> generateAssets(const pelage::GroomDef& def) {
  auto groom = pelage::generateGroom(def);
  if (!groom) return groom.error();
  DemoAssets assets;
  assets.name = "groom";
  assets.hair = std::move(groom->hair);
  assets.weights = std::move(groom->bones);
  assets.skeleton = std::move(groom->skeleton);
  assets.mesh = std::move(groom->head);
  assets.rootSpacing = groom->rootSpacing;
  if (Result<void> done = assets.hair.process(); !done) return done.error();
  return assets;
}

Result<void> repeatGuides(HairAsset& hair, std::vector<BoneInfluences>& influences,
                          uint32_t copies) {
  if (copies == 1) return {};
  if (uint64_t{hair.strandCount} * copies > std::numeric_limits<uint32_t>::max())
    return Error{ErrorCode::kInvalidArgument,
                 std::to_string(copies) + " copies of the guides are more than 2^32 of them"};
  hair.strandCount *= copies;
  repeatArray(hair.positions, copies);
  repeatArray(hair.vertexCounts, copies);
  repeatArray(hair.strandUv, copies);
  repeatArray(hair.vertexUv, copies);
  repeatArray(hair.strandThickness, copies);
  repeatArray(hair.vertexColor, copies);
  repeatArray(influences, copies);
  return hair.process();
}

Result<void> writeAssets(const DemoAssets& assets, const std::filesystem::path& folder) {
  if (Result<void> done = makeFolder(folder); !done) return done;
  const auto path = [&](const char* extension) { return folder / (assets.name + extension); };
  if (Result<void> done = pelage::saveTfx(assets.hair, path(".tfx")); !done) return done;
  if (!assets.weights.strands.empty())
    if (Result<void> done = pelage::saveTfxBone(assets.weights, path(".tfxbone")); !done)
      return done;
  if (assets.mesh)
    if (Result<void> done = pelage::saveTfxMesh(*assets.mesh, path(".tfxmesh")); !done) return done;
  return {};
}

Result<void> writeAssets(const pelage::Character& character, const std::filesystem::path& folder) {
  if (Result<void> done = makeFolder(folder); !done) return done;
  for (const pelage::CharacterGroom& groom : character.grooms) {
    if (Result<void> done = pelage::saveTfx(groom.hair, folder / (groom.name + ".tfx")); !done)
      return done;
    if (Result<void> done = pelage::saveTfxBone(groom.bones, folder / (groom.name + ".tfxbone"));
        !done)
      return done;
  }
  for (const pelage::CharacterCollider& collider : character.colliders)
    if (Result<void> done =
            pelage::saveTfxMesh(collider.mesh, folder / (collider.name + ".tfxmesh"));
        !done)
      return done;
  return writeGltf(character, folder / "character.gltf");
}

std::vector<float> coveredShares(const pelage::CollisionMesh& mesh, const HairAsset& hair,
                                 float range) {
  PointGrid roots(range);
  for (uint32_t strand = 0; strand < hair.strandCount; ++strand) {
    // The thin hair of a hairline does not hide the skin.
    if (!hair.strandThickness.empty() && hair.strandThickness[strand] < kHidingThickness) continue;
    const Float4& root = hair.positions[size_t{strand} * hair.verticesPerStrand];
    roots.add({root.x, root.y, root.z});
  }
  std::vector<float> shares;
  shares.reserve(mesh.positions.size());
  for (const Float3& p : mesh.positions)
    shares.push_back(1 - smoothStep(0.4f * range, range, roots.nearest(p)));
  return shares;
}

}  // namespace sample
