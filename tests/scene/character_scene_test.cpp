// The character on every API: three grooms and three colliders that move, for a second.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "pelage/demo/character.h"
#include "reference/sdf/distance_oracle.h"
#include "support/extremes.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

constexpr int kFrames = 60;
constexpr double kFrameSeconds = 1.0 / 60;
constexpr float kSdfCell = 0.020f;  // m

const Character& character() {
  static const Character made = [] {
    CharacterDef def;
    def.cellSize = 0.006f;
    def.colliderCellSize = 0.012f;
    def.longHair = {64, 16, 0.34f};
    def.fur = {128, 8, 0.03f};
    def.mohawk = {32, 8, 0.09f};
    Result<Character> character = generateCharacter(def);
    EXPECT_TRUE(character) << character.error().message;
    return std::move(*character);
  }();
  return made;
}

class CharacterScene : public testing::TestWithParam<Api> {
 protected:
  CharacterScene() : run_(GetParam()) {}

  void SetUp() override {
    if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    const auto bones = static_cast<uint32_t>(character().skeleton.bones.size());
    for (const CharacterGroom& groom : character().grooms) {
      assets_.push_back(groom.hair);
      expectOk(assets_.back().process());
      hairs_.push_back(&run_.add(assets_.back(), {.name = groom.name,
                                                  .settings = groom.settings,
                                                  .influences = groom.bones.strands,
                                                  .boneCount = bones}));
    }
    for (const CharacterCollider& collider : character().colliders) {
      SdfColliderDef def;
      def.name = collider.name;
      def.cellSize = kSdfCell;
      def.boneCount = bones;
      const Result<ColliderId> added = required(run_.scene.addCollider(collider.mesh, def));
      colliders_.push_back(*added);
    }
  }

  // Turns the head faster than hair can follow.
  std::vector<AffineTransform> pose(int frame) const {
    return skinningTransforms(character().skeleton,
                              poseCharacter(CharacterMotion::kHeadShake, kFrameSeconds * frame));
  }

  void simulate() {
    for (int frame = 1; frame <= kFrames; ++frame) {
      const std::vector<AffineTransform> bones = pose(frame);
      for (HairObject* hair : hairs_) hair->setBones(bones);
      for (const ColliderId id : colliders_) run_.scene.collider(id).setBones(bones);
      run_.step();
    }
  }

  SceneRun run_;
  std::vector<HairAsset> assets_;
  std::vector<HairObject*> hairs_;
  std::vector<ColliderId> colliders_;
};

// Positions of a collider's vertices at the last frame.
std::vector<Float3> skinned(const CollisionMesh& mesh, const std::vector<AffineTransform>& bones) {
  std::vector<Float3> positions;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    Float3 sum;
    const BoneInfluences& from = mesh.influences[v];
    for (int i = 0; i < 4; ++i) {
      const Float3 p = transformPoint(bones[from.bones[i]], mesh.positions[v]);
      sum = {sum.x + from.weights[i] * p.x, sum.y + from.weights[i] * p.y,
             sum.z + from.weights[i] * p.z};
    }
    positions.push_back(sum);
  }
  return positions;
}

TEST_P(CharacterScene, KeepsLengthsAndStaysOutOfTheBody) {
  simulate();
  const std::vector<AffineTransform> bones = pose(kFrames);
  std::vector<std::vector<Eigen::Vector3d>> free(hairs_.size());
  for (size_t g = 0; g < hairs_.size(); ++g) {
    const HairAsset& asset = assets_[g];
    const std::vector<Float4> positions = run_.positions(*hairs_[g]);
    ASSERT_EQ(positions.size(), asset.positions.size());
    double worst = 0, moved = 0;
    for (size_t i = 0; i < positions.size(); ++i) {
      const Float4& p = positions[i];
      ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      const size_t vertex = i % asset.verticesPerStrand;
      if (vertex >= 2) free[g].emplace_back(p.x, p.y, p.z);
      const Float4& bind = asset.positions[i];
      keepLargest(moved,
                  std::hypot(double{p.x} - bind.x, double{p.y} - bind.y, double{p.z} - bind.z));
      if (vertex == 0) continue;
      const Float4& q = positions[i - 1];
      const double rest = asset.restLengths[i - 1];
      keepLargest(
          worst,
          std::abs(std::hypot(double{p.x} - q.x, double{p.y} - q.y, double{p.z} - q.z) / rest - 1));
    }
    EXPECT_LT(worst, 1e-3) << hairs_[g]->name();
    EXPECT_GT(moved, 1e-3) << hairs_[g]->name();
  }
  // Fields have an error of about cell^2 over 8 times the radius of what is round, a finger's.
  constexpr double kDepth = 0.004;
  for (const CharacterCollider& collider : character().colliders) {
    const reference::DistanceOracle oracle(skinned(collider.mesh, bones), collider.mesh.indices);
    for (size_t g = 0; g < free.size(); ++g) {
      double deepest = 0;
      for (const double d : oracle.signedDistances(free[g], 0.02)) keepSmallest(deepest, d);
      EXPECT_GT(deepest, -kDepth) << hairs_[g]->name() << " in " << collider.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, CharacterScene, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
