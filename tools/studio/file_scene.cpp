// The scene of grooms and meshes from files.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "demo_scene.h"
#include "head_motion.h"
#include "names.h"
#include "scene_setup.h"

namespace sample {

using pelage::CachedHair;
using pelage::CachedMesh;

namespace {

constexpr Float3 kFileCameraDirection = {1, 0.25f, -0.3f};
constexpr uint32_t kFollowPerGuide = 8;
constexpr float kFollowRadius = 0.006f;  // m
constexpr float kCellsPerSide = 100;     // of a mesh's longest side

struct Bounds {
  Float3 low = {std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
                std::numeric_limits<float>::max()};
  Float3 high = {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
                 std::numeric_limits<float>::lowest()};
  void add(float x, float y, float z) {
    low = {std::min(low.x, x), std::min(low.y, y), std::min(low.z, z)};
    high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, z)};
  }
};

// A neck below the middle of all hair.
Float3 pivotUnder(const std::vector<CachedHair>& hairs) {
  Bounds b;
  for (const CachedHair& hair : hairs)
    for (const Float4& p : hair.asset.positions) b.add(p.x, p.y, p.z);
  const float below = 0.4f * (b.high.y - b.low.y);
  return {(b.low.x + b.high.x) / 2, b.low.y - below, (b.low.z + b.high.z) / 2};
}

float cellSizeOf(const CollisionMesh& mesh) {
  Bounds b;
  for (const Float3& p : mesh.positions) b.add(p.x, p.y, p.z);
  return std::max({b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z}) / kCellsPerSide;
}

// A neutral brown, or the colors of the file, which are multiplied with the material's. Thickness
// is a factor on a fiber of 80 um.
pelage::StrandMaterial fileMaterial(const pelage::HairAsset& hair) {
  pelage::StrandMaterial material;
  const bool colored = !hair.vertexColor.empty();
  material.rootColor = colored ? Float3{1, 1, 1} : Float3{0.060f, 0.038f, 0.026f};
  material.tipColor = colored ? Float3{1, 1, 1} : Float3{0.150f, 0.098f, 0.066f};
  material.fiberRadius = 40e-6f;
  return material;
}

// Stiff enough to keep its style.
pelage::SimulationSettings fileSettings(pelage::Solver solver) {
  pelage::SimulationSettings settings;
  settings.solver = solver;
  settings.bendLength = 0.2f;
  settings.globalStiffness = solver == pelage::Solver::kClassic ? kClassicGlobalStiffness : 0.06f;
  settings.globalRange = 1;
  settings.vspCoefficient = 0.2f;
  return settings;
}

// The names of all bones, each once.
std::vector<std::string> boneNames(const pelage::AssetCache& assets) {
  std::map<std::string, bool> known;
  std::vector<std::string> names;
  const auto add = [&](const std::vector<pelage::BoneName>& bones) {
    for (const pelage::BoneName& bone : bones)
      if (known.emplace(bone.name, true).second) names.push_back(bone.name);
  };
  for (const CachedHair& hair : assets.hairs)
    if (hair.bones) add(hair.bones->bones);
  for (const CachedMesh& mesh : assets.meshes) add(mesh.mesh.bones);
  return names;
}

std::optional<uint32_t> find(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<uint32_t>(found - names.begin());
}

// The influences in terms of all bones.
Result<std::vector<BoneInfluences>> mapped(const std::vector<pelage::BoneName>& bones,
                                           const std::vector<BoneInfluences>& influences,
                                           const std::vector<std::string>& names) {
  return pelage::mapBones(bones, influences,
                          [&](std::string_view name) { return find(names, name); });
}

// The transforms of these bones at a time.
using Pose = std::function<std::vector<AffineTransform>(double seconds)>;

Result<Pose> poseOf(const FileAssets& files, const std::vector<std::string>& names) {
  const size_t count = std::max<size_t>(names.size(), 1);
  if (!files.motion)
    return Pose([count, pivot = pivotUnder(files.assets.hairs)](double seconds) {
      return std::vector<AffineTransform>(count,
                                          rotationAbout(poseRotation(headPose(seconds)), pivot));
    });
  const BoneMotion& motion = *files.motion;
  for (const CachedHair& hair : files.assets.hairs)
    if (!hair.bones)
      return Error{ErrorCode::kInvalidArgument, "the hair '" + hair.name + "' has no bones that '" +
                                                    motion.name +
                                                    "' could move; give it a .tfxbone file"};
  std::vector<uint32_t> slots;
  for (const std::string& name : names) {
    const auto slot = find(motion.bones, name);
    if (!slot)
      return Error{ErrorCode::kInvalidArgument,
                   motion.name + ": there is no node for the bone '" + name + "'"};
    slots.push_back(*slot);
  }
  return Pose([slots, pose = motion.pose, length = motion.seconds](double seconds) {
    const std::vector<AffineTransform> all = pose(length > 0 ? std::fmod(seconds, length) : 0);
    std::vector<AffineTransform> bones;
    for (const uint32_t slot : slots) bones.push_back(all[slot]);
    return bones;
  });
}

}  // namespace

Result<DemoScene> DemoScene::create(const FileAssets& files, const DemoDef& def) {
  if (files.assets.hairs.empty())
    return Error{ErrorCode::kInvalidArgument, "there is no hair in the files"};
  DemoScene demo(def);
  const std::vector<std::string> names = boneNames(files.assets);
  auto pose = poseOf(files, names);
  if (!pose) return pose.error();
  demo.pose_ = *std::move(pose);
  demo.cycle_ = {0, files.motion ? files.motion->seconds : kHeadMotionSeconds};
  demo.boneCount_ = static_cast<uint32_t>(std::max<size_t>(names.size(), 1));
  demo.cameraDef_.direction = kFileCameraDirection;
  demo.takeLook(studioLights(kFileCameraDirection), def);
  if (def.drawSdf && files.assets.meshes.empty())
    return Error{ErrorCode::kInvalidArgument, "there is no mesh whose field could be drawn"};
  if (Result<void> added = demo.addFiles(files, names, def); !added) return added.error();
  return demo;
}

Result<void> DemoScene::addFiles(const FileAssets& files, const std::vector<std::string>& bones,
                                 const DemoDef& def) {
  std::vector<std::vector<AffineTransform>> poses;
  const double seconds = files.motion ? files.motion->seconds : kHeadMotionSeconds;
  for (int i = 0; i == 0 || i * kSweptStep < seconds; ++i) poses.push_back(pose_(i * kSweptStep));

  for (const CachedHair& hair : files.assets.hairs) {
    std::vector<BoneInfluences> influences;
    if (hair.bones) {
      auto found = mapped(hair.bones->bones, hair.bones->strands, bones);
      if (!found) return found.error();
      influences = *std::move(found);
    }
    pelage::HairDef look;
    look.name = hair.name;
    look.material = fileMaterial(hair.asset);
    look.settings = fileSettings(def.solver);
    look.influences = influences;
    look.followHairs = hair.followHairs;
    if (Result<void> added = addHair(
            hair.asset, look,
            {.countPerGuide = kFollowPerGuide, .maxRadius = kFollowRadius, .seed = def.seed}, def);
        !added)
      return added;
    for (const std::vector<AffineTransform>& pose : poses)
      sweepHair(hair.asset, influences, pose, sweptPoints_);
  }
  for (const CachedMesh& cached : files.assets.meshes) {
    auto influences = mapped(cached.mesh.bones, cached.mesh.influences, bones);
    if (!influences) return influences.error();
    CollisionMesh mesh = cached.mesh;
    mesh.influences = *std::move(influences);
    Result<void> added =
        addCollider(mesh, {.name = cached.name + "/field", .cellSize = cellSizeOf(mesh)}, def);
    if (added && !def.drawSdf)
      added = addMesh(mesh, {.name = cached.name + "/mesh", .influences = mesh.influences});
    if (!added) return added;
    for (const std::vector<AffineTransform>& pose : poses) sweepMesh(mesh, pose, sweptPoints_);
  }
  return {};
}

}  // namespace sample
