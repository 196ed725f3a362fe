// Hair that touches hair, in scenes: what it keeps, and that it is not there when it is off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/gpu_structs.h"
#include "support/buffer_names.h"
#include "support/errors.h"
#include "support/hair_bundle.h"
#include "support/scene_test.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

const HairContactSettings kHairContact = {.stiffness = 1, .friction = 0.2f};

bool isGridPass(const Pass& pass) {
  return std::string_view(pass.name).find("hair_grid") != std::string_view::npos;
}

size_t gridPasses(const PassList& list) {
  return static_cast<size_t>(std::count_if(list.passes.begin(), list.passes.end(), isGridPass));
}

// In place of a runtime.
void simulateList(Scene& scene, PassList& list) {
  expectOk(scene.simulate(1.0f / 60, list));
  scene.finish(list);
  setDelivered(list.run);
}

TEST(HairContactOff, HasNoPassNoBufferAndNoForcesInTheSolver) {
  Scene scene, plain;
  PassList list, plainList;
  const HairAsset asset = bundle({.strands = 40, .vertices = 8});
  HairDef def;
  def.settings.contact = kHairContact;
  HairObject& hair = scene.hair(*scene.addHair(asset, def));
  ASSERT_TRUE(plain.addHair(asset, {}));
  for (int frame = 0; frame < 3; ++frame) {
    simulateList(scene, list);
    simulateList(plain, plainList);
  }
  EXPECT_EQ(gridPasses(list), 3u);
  EXPECT_NE(bufferNamed(scene.resources(), "hair/contactNodes"), nullptr);

  hair.settings.contact = {};
  simulateList(scene, list);
  simulateList(plain, plainList);
  EXPECT_EQ(gridPasses(list), 0u);
  scene.trim();
  EXPECT_EQ(scene.resources().count(), plain.resources().count());
  EXPECT_EQ(scene.resources().totalBytes(), plain.resources().totalBytes());
  ASSERT_EQ(list.passes.size(), plainList.passes.size());
  for (size_t i = 0; i < list.passes.size(); ++i)
    EXPECT_EQ(list.passes[i].kernel, plainList.passes[i].kernel) << "another permutation";
}

TEST(HairContact, GivesItsBuffersBackWithTheHair) {
  Scene scene;
  PassList list;
  const HairId id = *scene.addHair(bundle({.strands = 40, .vertices = 8}),
                                   {.settings = {.contact = kHairContact}});
  simulateList(scene, list);
  EXPECT_GT(gridPasses(list), 3u) << "the bind pose is measured";
  EXPECT_TRUE(scene.removeHair(id));
  EXPECT_EQ(scene.resources().count(), 0u);
}

TEST(HairContact, RefusesSettingsThatAreOutOfRange) {
  SimulationSettings settings;
  settings.contact.stiffness = 1.5f;
  expectError(validate(settings), "contact.stiffness");
  settings.contact = {.cellSize = 0};
  EXPECT_FALSE(validate(settings));
}

TEST(HairContact, HasAGridThatHoldsLongHairInSixtyFourNodes) {
  Scene scene;
  PassList list;
  HairDef def;
  def.settings.contact = {.stiffness = 1, .cellSize = 1e-3f};
  ASSERT_TRUE(scene.addHair(bundle({.strands = 5, .length = 30}), def));
  simulateList(scene, list);
  const BufferDesc* nodes = bufferNamed(scene.resources(), "hair/contactNodes");
  ASSERT_NE(nodes, nullptr);
  EXPECT_LE(nodes->size, 64u * 64 * 64 * sizeof(uint32_t));
}

TEST(HairContact, TakesTheObjectsOwnMotionOutOfTheMomentumAndFollowsIt) {
  // 30 m/s are more than the momentum can hold.
  Scene scene;
  PassList list;
  HairObject& hair = scene.hair(*scene.addHair(bundle({.strands = 40, .vertices = 8}),
                                               {.settings = {.contact = kHairContact}}));
  HairGridConstants constants = {};
  for (int frame = 0; frame < 5; ++frame) {
    AffineTransform bone;
    bone.rows[0].w = 0.5f * static_cast<float>(frame);
    setBone(hair, bone);
    simulateList(scene, list);
    const auto pass = std::find_if(list.passes.begin(), list.passes.end(), isGridPass);
    ASSERT_NE(pass, list.passes.end());
    for (const PassBinding& binding : list.bindingsOf(*pass)) {
      if (binding.buffer == BufferId::kInvalid)
        std::memcpy(&constants, list.constants.data() + binding.offset, sizeof(constants));
    }
    if (frame > 1) {
      EXPECT_NEAR(constants.gridVelocity.x, 30, 1e-3);
    }
    const float low = constants.gridOrigin.x, cell = constants.gridOrigin.w;
    if (frame > 0) {
      EXPECT_LT(low, bone.rows[0].w - 0.27f);
      EXPECT_GT(low + cell * static_cast<float>(constants.gridSize - 1), bone.rows[0].w + 0.27f);
      EXPECT_NEAR(low / cell, std::round(low / cell), 1e-3) << "whole cells";
    }
  }
}

class HairContactRun : public SceneTest {
 protected:
  /// Area of the layers of the bundle over that of its bind pose.
  double areaOf(const HairObject& hair, const BundleDef& def, int axisA, int axisB) const {
    const HairAsset asset = bundle(def);
    const int across = def.hanging ? 0 : 1;
    return areaOfLayers(run_.positions(hair), def.strands, def.vertices, axisA, axisB) /
           areaOfLayers(asset.positions, def.strands, def.vertices, across, 2);
  }
};

TEST_P(HairContactRun, ABundleInItsBindPoseFeelsNothing) {
  HairDef def;
  def.settings.contact = kHairContact;
  def.settings.gravity = {};
  HairObject& hair = run_.add(bundle(), def);
  for (int frame = 0; frame < 5; ++frame) run_.step();
  for (const Float4& force : run_.read(hair.buffers().contactForces))
    EXPECT_LT(toVector(force).norm(), 1e-3) << "[m/s2]";
  // Another place and direction of the grid's cells.
  AffineTransform bone;
  bone.rows[0] = {std::cos(0.7f), -std::sin(0.7f), 0, 0.317f};
  bone.rows[1] = {std::sin(0.7f), std::cos(0.7f), 0, -3.291f};
  bone.rows[2].w = 0.0137f;
  setBone(hair, bone);
  hair.reset();
  for (int frame = 0; frame < 5; ++frame) run_.step();
  for (const Float4& force : run_.read(hair.buffers().contactForces))
    EXPECT_LT(toVector(force).norm(), 0.02) << "[m/s2]";
}

TEST_P(HairContactRun, ASqueezedBundleKeepsMoreOfItsVolumeAndGetsItBack) {
  const BundleDef bundleDef = {.strands = 200};
  double squeezed[2], released[2];
  for (const bool on : {false, true}) {
    HairDef def;
    if (on) def.settings.contact = kHairContact;
    HairObject& hair = run_.add(bundle(bundleDef), def);
    for (int frame = 0; frame < 150; ++frame) {
      // Two cylinders that come to 1 cm of each other, stay, and go.
      float gap = 0.08f;
      if (frame >= 10) gap = std::max(0.01f, 0.08f - 0.07f * static_cast<float>(frame - 10) / 30);
      if (frame >= 70) gap = std::min(0.08f, 0.01f + 0.07f * static_cast<float>(frame - 70) / 15);
      const float x = gap / 2 + 0.03f;
      const CapsuleCollider colliders[] = {{.head = {x, -0.14f, -0.3f},
                                            .headRadius = 0.03f,
                                            .tail = {x, -0.14f, 0.3f},
                                            .tailRadius = 0.03f,
                                            .friction = 0},
                                           {.head = {-x, -0.14f, -0.3f},
                                            .headRadius = 0.03f,
                                            .tail = {-x, -0.14f, 0.3f},
                                            .tailRadius = 0.03f,
                                            .friction = 0}};
      hair.setColliders(colliders);
      run_.step();
      if (frame == 69) squeezed[on] = areaOf(hair, bundleDef, 0, 2);
    }
    released[on] = areaOf(hair, bundleDef, 0, 2);
    hair.setColliders({});
    hair.settings.contact = {};
  }
  RecordProperty("squeezedOff", std::to_string(squeezed[0]));
  RecordProperty("squeezedOn", std::to_string(squeezed[1]));
  EXPECT_LT(squeezed[0], 0.55);
  EXPECT_GT(squeezed[1], 0.62);
  EXPECT_GT(squeezed[1], 1.3 * squeezed[0]);
  EXPECT_NEAR(released[1], 1, 0.05);
}

TEST_P(HairContactRun, ATuftThatHangsFromAWallDoesNotCollapseToASheet) {
  const BundleDef bundleDef = {.strands = 200, .hanging = false};
  double area[2];
  for (const bool on : {false, true}) {
    HairDef def;
    if (on) def.settings.contact = kHairContact;
    const HairObject& hair = run_.add(bundle(bundleDef), def);
    for (int frame = 0; frame < 150; ++frame) run_.step();
    area[on] = areaOf(hair, bundleDef, 0, 2);
  }
  EXPECT_LT(area[0], 0.05);
  EXPECT_GT(area[1], 0.4);
}

TEST_P(HairContactRun, FrictionCalmsWhatMovesAgainstEachOther) {
  // Strands of two lengths swing with different periods. Over half a second, as they pass each
  // other in some frames and stand still in others.
  double speed[2];
  for (const bool on : {false, true}) {
    HairAsset asset = bundle({.strands = 200, .hanging = false});
    asset.vertexCounts.resize(200);
    for (uint32_t s = 0; s < 200; ++s) asset.vertexCounts[s] = s % 2 == 0 ? 16 : 11;
    expectOk(asset.process());
    HairDef def;
    def.settings.damping = 0.01f;
    def.settings.bendLength = 0.2f;
    if (on) def.settings.contact.friction = 0.3f;
    const HairObject& hair = run_.add(asset, def);
    for (int frame = 0; frame < 45; ++frame) run_.step();
    std::vector<Float4> before = run_.positions(hair);
    double squared = 0;
    constexpr int kFrames = 30;
    for (int frame = 0; frame < kFrames; ++frame) {
      run_.step();
      const std::vector<Float4> now = run_.positions(hair);
      Vector3d mean[2] = {{0, 0, 0}, {0, 0, 0}};
      for (size_t s = 0; s < 200; ++s)
        mean[s % 2] += (toVector(now[s * 16 + 9]) - toVector(before[s * 16 + 9])) * 60 / 100;
      squared += (mean[0] - mean[1]).squaredNorm();
      before = now;
    }
    speed[on] = std::sqrt(squared / kFrames);
  }
  RecordProperty("relativeSpeedOff", std::to_string(speed[0]));
  RecordProperty("relativeSpeedOn", std::to_string(speed[1]));
  EXPECT_LT(speed[1], 0.65 * speed[0]);
}

TEST_P(HairContactRun, GravityPullsTheHairAsOneAsFastAsWithoutFriction) {
  // Limp hair from a wall, before it has turned far: it falls, and all of it alike.
  double fallen[2];
  for (const bool on : {false, true}) {
    HairDef def;
    def.settings.damping = 0;
    def.settings.bendLength = 0;
    if (on) def.settings.contact.friction = 0.5f;
    const HairObject& hair = run_.add(bundle({.strands = 200, .hanging = false}), def);
    for (int frame = 0; frame < 6; ++frame) run_.step();
    const std::vector<Float4> now = run_.positions(hair);
    const HairAsset asset = bundle({.strands = 200, .hanging = false});
    fallen[on] = 0;
    for (size_t s = 0; s < 200; ++s)
      fallen[on] += static_cast<double>(asset.positions[s * 16 + 15].y - now[s * 16 + 15].y) / 200;
  }
  EXPECT_GT(fallen[0], 0.03) << "[m] in 0.1 s";
  EXPECT_NEAR(fallen[1], fallen[0], 0.05 * fallen[0]);
}

TEST_P(HairContactRun, LongFramesAndSubStepsStayCalm) {
  HairDef def;
  def.settings.contact = kHairContact;
  def.settings.subSteps = 3;
  const BundleDef bundleDef = {.strands = 100, .hanging = false};
  const HairObject& hair = run_.add(bundle(bundleDef), def);
  for (int frame = 0; frame < 60; ++frame) run_.step(frame % 2 == 0 ? 1.0f / 15 : 1.0f / 120);
  const std::vector<Float4> before = run_.positions(hair);
  run_.step();
  const std::vector<Float4> now = run_.positions(hair);
  double squares = 0;
  for (size_t i = 0; i < now.size(); ++i) {
    ASSERT_TRUE(isFinite(now[i]));
    squares += (toVector(now[i]) - toVector(before[i])).squaredNorm() * 3600;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(now.size())), 0.05) << "[m/s]";
}

TEST_P(HairContactRun, AStrandThatIsNotANumberDoesNotReachTheOthers) {
  HairObject& hair = run_.add(bundle({.strands = 60}), {.settings = {.contact = kHairContact}});
  for (int frame = 0; frame < 10; ++frame) run_.step();
  AffineTransform bone;
  bone.rows[1].w = std::nanf("");
  setBone(hair, bone);
  for (int frame = 0; frame < 3; ++frame) run_.step();
  bone = {};
  setBone(hair, bone);
  for (int frame = 0; frame < 30; ++frame) run_.step();
  for (const Float4& p : run_.positions(hair)) ASSERT_TRUE(isFinite(p));
  for (const Float4& f : run_.read(hair.buffers().contactForces)) ASSERT_TRUE(isFinite(f));
}

INSTANTIATE_TEST_SUITE_P(Apis, HairContactRun, testing::Values(kFirstApi), apiTestName);

TEST(HairContactBits, AreTheSameOnEveryApi) {
  std::vector<Float4> first;
  for (const Api api : kApis) {
    SceneRun run(api);
    if (run.device() == nullptr) continue;
    const HairObject& hair = run.add(bundle({.strands = 100, .hanging = false}),
                                     {.settings = {.contact = kHairContact}});
    for (int frame = 0; frame < 60; ++frame) run.step();
    const std::vector<Float4> positions = run.positions(hair);
    if (first.empty()) first = positions;
    EXPECT_TRUE(positions == first) << apiName(api);
  }
  if (first.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

}  // namespace
}  // namespace pelage::test
