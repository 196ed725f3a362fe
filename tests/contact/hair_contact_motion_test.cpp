// Hair-hair contact of objects that are taken elsewhere and rotated, and of those whose bones an
// engine has on the GPU.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/engine_buffer.h"
#include "support/hair_bundle.h"

namespace pelage::test {
namespace {

constexpr int kShakenFrames = 26, kTeleport = 18;
constexpr BundleDef kBundle = {.strands = 150, .vertices = 12, .radius = 0.02, .length = 0.2};

RigidMotion elsewhere() { return RigidMotion::about(2.2, {1, -2, 0.7}, {7, -3, 12}); }

/// Shakes the bundle, so that strands push and rub each other.
RigidMotion shakenHead(int frame, const RigidMotion& world) {
  const Vector3d shift(0.03 * std::sin(0.6 * frame), 0.01 * frame, 0);
  return world * RigidMotion::about(0.5 * std::sin(0.5 * frame), {1, 0.3, 0.5}, shift);
}

using Story = std::vector<std::vector<Float4>>;  // [frame] positions

class HairContactMotion : public SceneTest {
 protected:
  HairContactMotion() : asset_(bundle(kBundle)) {
    settings_.contact = {.stiffness = 1, .friction = 0.2f, .cellSize = 0x1p-6f};
  }
  /// Largest acceleration that contact gives a vertex [m/s2].
  double largestForce(const HairObject& hair) const {
    double largest = 0;
    if (hair.buffers().contactForces == BufferId::kInvalid) return largest;
    for (const Float4& force : run_.read(hair.buffers().contactForces))
      keepLargest(largest, toVector(force).norm());
    return largest;
  }
  void setGravity(HairObject& hair, const RigidMotion& world) const {
    hair.settings.gravity = toFloat3(world.rotation * Vector3d(0, -9.81, 0));
  }
  /// \param at the frame that a teleport comes before; none beyond the last one
  Story tell(int at, const RigidMotion& to) {
    HairObject& hair = run_.add(asset_, {.settings = settings_});
    Story story;
    RigidMotion world;
    force_ = 0;
    for (int frame = 0; frame < kShakenFrames; ++frame) {
      if (frame == at) {
        expectOk(run_.scene.teleport(run_.lastHair(), to.transform()));
        world = to;
      }
      setBone(hair, shakenHead(frame, world).transform());
      setGravity(hair, world);
      run_.step();
      story.push_back(run_.positions(hair));
      keepLargest(force_, largestForce(hair));
    }
    run_.clear();
    return story;
  }

  HairAsset asset_;
  SimulationSettings settings_;
  double force_ = 0;  ///< of the last story
};
INSTANTIATE_TEST_SUITE_P(All, HairContactMotion, testing::Values(kFirstApi), apiTestName);

double largestDifference(const Story& moved, const Story& still, const RigidMotion& to) {
  double largest = 0;
  for (size_t i = 0; i < kShakenFrames; ++i)
    keepLargest(largest, maxDistance(moved[i], still[i], i < kTeleport ? RigidMotion{} : to));
  return largest;
}

// The nodes of the grid are at whole cells of the world: a motion that takes these to each other
// changes nothing.
TEST_P(HairContactMotion, ATeleportFromNodesToNodesIsNotNoticed) {
  const Story still = tell(kShakenFrames, {});
  EXPECT_GT(force_, 1) << "strands push each other";
  RigidMotion exchanged = {{}, Vector3d(7, -3, 12)};
  exchanged.rotation << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const RigidMotion shifted = {Eigen::Matrix3d::Identity(), Vector3d(7, -3, 12)};
  for (const RigidMotion& world : {shifted, exchanged}) {
    const Story moved = tell(kTeleport, world);
    printFigure("first frame [m]", maxDistance(moved[kTeleport], still[kTeleport], world));
    printFigure("all frames [m]", largestDifference(moved, still, world));
    EXPECT_LT(maxDistance(moved[kTeleport], still[kTeleport], world), 1e-5);
    EXPECT_LT(largestDifference(moved, still, world), 1e-4);
  }
}

// Any other rotation puts other nodes into the hair. So does one that was always there: a teleport
// makes no more of it than twice that.
TEST_P(HairContactMotion, ATeleportWithARotationTakesContactAlong) {
  const Story still = tell(kShakenFrames, {});
  const Story always = tell(0, elsewhere());
  const Story moved = tell(kTeleport, elsewhere());
  double nodes = 0;
  for (size_t i = 0; i < kShakenFrames; ++i)
    keepLargest(nodes, maxDistance(always[i], still[i], elsewhere()));
  const double difference = largestDifference(moved, still, elsewhere());
  printFigure("of a teleport [m]", difference);
  printFigure("of other nodes [m]", nodes);
  EXPECT_LT(difference, 2 * nodes + 1e-5);
  EXPECT_LT(nodes, 5e-3);
}

TEST_P(HairContactMotion, BonesOnTheGpuGiveTheContactOfThoseOfTheHost) {
  EngineBuffer palette(run_, "palette", 12);
  const SkeletonId host = run_.add(SkeletonDef{.name = "host", .boneCount = 1});
  const SkeletonId gpu = run_.add(
      SkeletonDef{.name = "gpu", .boneCount = 1, .source = BoneSource::kBuffer, .deviation = 0.1f});
  HairObject& expected =
      run_.add(asset_, {.name = "expected", .settings = settings_, .skeleton = host});
  const HairId first = run_.lastHair();
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_, .skeleton = gpu});
  const HairId second = run_.lastHair();
  double difference = 0, force = 0;
  RigidMotion world;
  for (int frame = 0; frame < kShakenFrames; ++frame) {
    if (frame == kTeleport) {
      world = elsewhere();
      for (const HairId id : {first, second}) expectOk(run_.scene.teleport(id, world.transform()));
    }
    const AffineTransform bone = shakenHead(frame, world).transform();
    setBone(run_.scene.skeleton(host), bone);
    std::vector<float> floats;
    for (const Float4& row : bone.rows) floats.insert(floats.end(), {row.x, row.y, row.z, row.w});
    palette.write(floats);
    run_.scene.skeleton(gpu).setBones({.buffer = palette.id()}, bone);
    setGravity(expected, world);
    setGravity(hair, world);
    run_.step();
    keepLargest(difference, maxDistance(run_.positions(hair), run_.positions(expected), {}));
    keepLargest(force, largestForce(hair));
  }
  printFigure("bones on the GPU [m]", difference);
  EXPECT_GT(force, 1) << "strands push each other";
  EXPECT_LT(difference, 1e-4);
}

}  // namespace
}  // namespace pelage::test
