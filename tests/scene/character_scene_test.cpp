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
    return valueOf(generateCharacter(def));
  }();
  return made;
}

// Turns the head faster than hair can follow.
std::vector<AffineTransform> poseAt(int frame) {
  return skinningTransforms(character().skeleton,
                            poseCharacter(CharacterMotion::kHeadShake, kFrameSeconds * frame));
}

struct CharacterRun {
  explicit CharacterRun(Api api) : run(api) {
    if (run.device() == nullptr) return;
    const auto bones = static_cast<uint32_t>(character().skeleton.bones.size());
    for (const CharacterGroom& groom : character().grooms) {
      assets.push_back(groom.hair);
      expectOk(assets.back().process());
      hairs.push_back(&run.add(assets.back(), {.name = groom.name,
                                               .settings = groom.settings,
                                               .influences = groom.bones.strands,
                                               .boneCount = bones}));
    }
    for (const CharacterCollider& collider : character().colliders) {
      SdfColliderDef def;
      def.name = collider.name;
      def.cellSize = kSdfCell;
      def.boneCount = bones;
      const Result<ColliderId> added = required(run.scene.addCollider(collider.mesh, def));
      colliders.push_back(*added);
    }
  }

  void simulate(int frames) {
    for (int frame = 1; frame <= frames; ++frame) {
      const std::vector<AffineTransform> bones = poseAt(frame);
      for (HairObject* hair : hairs) hair->setBones(bones);
      for (const ColliderId id : colliders) run.scene.collider(id).setBones(bones);
      run.step();
    }
  }

  SceneRun run;
  std::vector<HairAsset> assets;
  std::vector<HairObject*> hairs;
  std::vector<ColliderId> colliders;
};

class CharacterScene : public testing::TestWithParam<Api> {
 protected:
  CharacterScene() : now_(GetParam()) {}
  void SetUp() override {
    if (now_.run.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  }

  CharacterRun now_;
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
  now_.simulate(kFrames);
  const std::vector<AffineTransform> bones = poseAt(kFrames);
  std::vector<std::vector<Eigen::Vector3d>> free(now_.hairs.size());
  for (size_t g = 0; g < now_.hairs.size(); ++g) {
    const HairAsset& asset = now_.assets[g];
    const std::vector<Float4> positions = now_.run.positions(*now_.hairs[g]);
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
    EXPECT_LT(worst, 1e-3) << now_.hairs[g]->name();
    EXPECT_GT(moved, 1e-3) << now_.hairs[g]->name();
  }
  // Fields have an error of about cell^2 over 8 times the radius of curvature, a finger's here.
  constexpr double kDepth = 0.004;
  for (const CharacterCollider& collider : character().colliders) {
    const reference::DistanceOracle oracle(skinned(collider.mesh, bones), collider.mesh.indices);
    for (size_t g = 0; g < free.size(); ++g) {
      double deepest = 0;
      for (const double d : oracle.signedDistances(free[g], 0.02)) keepSmallest(deepest, d);
      EXPECT_GT(deepest, -kDepth) << now_.hairs[g]->name() << " in " << collider.name;
    }
  }
}

TEST_P(CharacterScene, HasTheSameBitsWithoutLevels) {
  CharacterRun serial(GetParam());
  serial.run.scene.setLevels(false);
  constexpr int kFew = 4;
  serial.simulate(kFew);
  now_.simulate(kFew);
  for (size_t g = 0; g < now_.hairs.size(); ++g)
    EXPECT_EQ(now_.run.positions(*now_.hairs[g]), serial.run.positions(*serial.hairs[g])) << g;
}

INSTANTIATE_TEST_SUITE_P(All, CharacterScene, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
