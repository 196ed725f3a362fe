#include "scenes/scene_assets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "asset_files.h"
#include "groom_presets.h"
#include "head_motion.h"

namespace bench {

using pelage::AffineTransform;
using pelage::Character;
using pelage::Result;
using sample::DemoAssets;

namespace {

// Cells of the head's and the character's meshes as pelage-headless makes them [m].
constexpr float kHeadCellSize = 0.0025f, kCharacterCellSize = 0.003f;
constexpr float kQuickHeadCellSize = 0.007f;

constexpr const char* kRatBoyHair = "Ratboy_mohawk.tfx";

constexpr size_t kHeadBone = 1;
// The sample's.
constexpr double kVelocityShockPropagation = 0.2;

pelage::rod::RootPose toRootPose(const AffineTransform& bone) {
  Eigen::Matrix3d rotation;
  const auto d = [](float x) { return static_cast<double>(x); };
  for (int i = 0; i < 3; ++i)
    rotation.row(i) << d(bone.rows[i].x), d(bone.rows[i].y), d(bone.rows[i].z);
  const Eigen::Quaterniond q(rotation);
  return {{q.x(), q.y(), q.z(), q.w()}, {d(bone.rows[0].w), d(bone.rows[1].w), d(bone.rows[2].w)}};
}

}  // namespace

Result<const BenchScene*> SceneAssets::freeHair(uint32_t strands) {
  const auto found = free_.find(strands);
  if (found != free_.end()) return &found->second;
  auto hair = generatedHair(strands);
  if (!hair) return hair.error();
  return &free_.emplace(strands, movedGroom("free", *hair, 1, 0)).first->second;
}

Result<const DemoAssets*> SceneAssets::head(uint32_t guides, uint32_t verticesPerStrand) {
  const auto key = std::pair(guides, verticesPerStrand);
  const auto found = heads_.find(key);
  if (found != heads_.end()) return &found->second;
  pelage::GroomDef def = sample::presetLook(sample::GroomPreset::kParted).groom;
  def.strandCount = guides;
  def.headCellSize = quick_ ? kQuickHeadCellSize : kHeadCellSize;
  if (verticesPerStrand > 0) def.verticesPerStrand = verticesPerStrand;
  auto assets = sample::generateAssets(def);
  if (!assets) return assets.error();
  return &heads_.emplace(key, std::move(*assets)).first->second;
}

Result<const Character*> SceneAssets::character(uint32_t guides) {
  const auto found = characters_.find(guides);
  if (found != characters_.end()) return &found->second;
  pelage::CharacterDef def;
  def.cellSize = kCharacterCellSize;
  const double share = static_cast<double>(guides) / def.longHair.strandCount;
  for (uint32_t* count : {&def.longHair.strandCount, &def.fur.strandCount, &def.mohawk.strandCount})
    *count = static_cast<uint32_t>(std::max(std::round(share * *count), 1.0));
  auto character = pelage::generateCharacter(def);
  if (!character) return character.error();
  for (pelage::CharacterGroom& groom : character->grooms)
    if (Result<void> done = groom.hair.process(); !done) return done.error();
  return &characters_.emplace(guides, std::move(*character)).first->second;
}

bool SceneAssets::hasRatBoy() const {
  return !data_.empty() && std::filesystem::exists(ratBoyFile(kRatBoyHair));
}

Result<const sample::FileAssets*> SceneAssets::ratBoy() {
  if (ratBoy_) return &*ratBoy_;
  pelage::program::AssetFiles files;
  files.hairs = {ratBoyFile(kRatBoyHair)};
  files.bones = {ratBoyFile("Ratboy_mohawk.tfxbone")};
  files.meshes = {ratBoyFile("Ratboy_body.tfxmesh"), ratBoyFile("Ratboy_left_hand.tfxmesh")};
  files.repair = true;
  std::vector<std::string> warnings;
  auto loaded = pelage::program::loadAssetFiles(files, warnings);
  if (!loaded) return loaded.error();
  return &ratBoy_.emplace(sample::FileAssets{*std::move(loaded), {}});
}

Result<BenchScene> headOfBaseline(const DemoAssets& head) {
  BenchScene scene = movedGroom("head", head.hair, 1, kVelocityShockPropagation);
  // The first frame is at rest in the bind pose; those after it are the sample's.
  scene.motion = [skeleton = head.skeleton](double time) {
    return toRootPose(sample::poseSkeleton(skeleton, sample::headPose(time))[kHeadBone]);
  };
  return scene;
}

}  // namespace bench
