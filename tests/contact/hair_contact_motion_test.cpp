// Hair-hair contact of objects that are taken elsewhere and rotated, and of those whose bones an
// engine has on the GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/engine_buffer.h"
#include "support/extremes.h"
#include "support/hair_bundle.h"
#include "support/required_devices.h"

namespace pelage::test {
namespace {

constexpr int kFrames = 26, kTeleport = 18;
constexpr BundleDef kBundle = {.strands = 150, .vertices = 12, .radius = 0.02, .length = 0.2};

struct World {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3d shift = {0, 0, 0};

  Vector3d operator()(const Float4& p) const { return rotation * toVector(p) + shift; }
  AffineTransform transform() const { return toTransform(rotation, shift); }
};

World rotated() {
  return {Eigen::AngleAxisd(2.2, Vector3d(1, -2, 0.7).normalized()).toRotationMatrix(),
          Vector3d(7, -3, 12)};
}

/// Shakes the bundle, so that strands push and rub each other.
World headAt(int frame, const World& world) {
  const Eigen::AngleAxisd rotation(0.5 * std::sin(0.5 * frame), Vector3d(1, 0.3, 0.5).normalized());
  const Vector3d shift(0.03 * std::sin(0.6 * frame), 0.01 * frame, 0);
  return {world.rotation * rotation.toRotationMatrix(), world.rotation * shift + world.shift};
}

using Story = std::vector<std::vector<Float4>>;  // [frame] positions

/// \return infinity where something is not a number, or there is nothing.
double distanceOf(const std::vector<Float4>& a, const std::vector<Float4>& b, const World& ofB) {
  double largest = a.size() == b.size() && !a.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    keepLargest(largest, (toVector(a[i]) - ofB(b[i])).norm());
  return std::isnan(largest) ? std::numeric_limits<double>::infinity() : largest;
}

class HairContactMotion : public testing::TestWithParam<Api> {
 protected:
  HairContactMotion() : run_(sharedSceneRun(GetParam())), asset_(bundle(kBundle)) {
    settings_.contact = {.stiffness = 1, .friction = 0.2f, .cellSize = 0x1p-6f};
  }
  void SetUp() override {
    if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    messages_ = run_.device()->messageCount();
  }
  void TearDown() override {
    if (run_.device() == nullptr) return;
    run_.clear();
    EXPECT_EQ(run_.device()->messageCount(), messages_) << "the driver or a layer complained";
  }
  /// Largest acceleration that contact gives a vertex [m/s2].
  double largestForce(const HairObject& hair) const {
    double largest = 0;
    if (hair.buffers().contactForces == BufferId::kInvalid) return largest;
    for (const Float4& force : run_.read(hair.buffers().contactForces))
      keepLargest(largest, toVector(force).norm());
    return largest;
  }
  void setGravity(HairObject& hair, const World& world) const {
    const Vector3d g = world.rotation * Vector3d(0, -9.81, 0);
    hair.settings.gravity = {static_cast<float>(g.x()), static_cast<float>(g.y()),
                             static_cast<float>(g.z())};
  }
  /// \param at the frame that a teleport comes before; none beyond the last one
  Story tell(int at, const World& to) {
    HairObject& hair = run_.add(asset_, {.settings = settings_});
    Story story;
    World world;
    force_ = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      if (frame == at) {
        expectOk(run_.scene.teleport(run_.lastHair(), to.transform()));
        world = to;
      }
      const AffineTransform bone = headAt(frame, world).transform();
      hair.setBones({&bone, 1});
      setGravity(hair, world);
      run_.step();
      story.push_back(run_.positions(hair));
      keepLargest(force_, largestForce(hair));
    }
    run_.clear();
    return story;
  }

  SceneRun& run_;
  HairAsset asset_;
  SimulationSettings settings_;
  double force_ = 0;  ///< of the last story

 private:
  uint32_t messages_ = 0;
};
INSTANTIATE_TEST_SUITE_P(All, HairContactMotion, testing::ValuesIn(kApis), apiTestName);

double largestDifference(const Story& moved, const Story& still, const World& to) {
  double largest = 0;
  for (size_t i = 0; i < kFrames; ++i)
    keepLargest(largest, distanceOf(moved[i], still[i], i < kTeleport ? World{} : to));
  return largest;
}

// The nodes of the grid are at whole cells of the world: a motion that takes these to each other
// changes nothing.
TEST_P(HairContactMotion, ATeleportFromNodesToNodesIsNotNoticed) {
  const Story still = tell(kFrames, {});
  EXPECT_GT(force_, 1) << "strands push each other";
  World exchanged = {{}, Vector3d(7, -3, 12)};
  exchanged.rotation << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const World shifted = {Eigen::Matrix3d::Identity(), Vector3d(7, -3, 12)};
  for (const World& world : {shifted, exchanged}) {
    const Story moved = tell(kTeleport, world);
    printFigure("first frame [m]", distanceOf(moved[kTeleport], still[kTeleport], world));
    printFigure("all frames [m]", largestDifference(moved, still, world));
    EXPECT_LT(distanceOf(moved[kTeleport], still[kTeleport], world), 1e-5);
    EXPECT_LT(largestDifference(moved, still, world), 1e-4);
  }
}

// Any other rotation puts other nodes into the hair. So does one that was always there: a teleport
// makes no more of it than twice that.
TEST_P(HairContactMotion, ATeleportWithARotationTakesContactAlong) {
  const Story still = tell(kFrames, {});
  const Story always = tell(0, rotated());
  const Story moved = tell(kTeleport, rotated());
  double nodes = 0;
  for (size_t i = 0; i < kFrames; ++i)
    keepLargest(nodes, distanceOf(always[i], still[i], rotated()));
  const double difference = largestDifference(moved, still, rotated());
  printFigure("of a teleport [m]", difference);
  printFigure("of other nodes [m]", nodes);
  EXPECT_LT(difference, 2 * nodes + 1e-5);
  EXPECT_LT(nodes, 5e-3);
}

TEST_P(HairContactMotion, BonesOnTheGpuGiveTheContactOfThoseOfTheHost) {
  EngineBuffer palette(run_, "palette", 12);
  const Result<SkeletonId> host = run_.scene.addSkeleton({.name = "host", .boneCount = 1});
  const Result<SkeletonId> gpu = run_.scene.addSkeleton(
      {.name = "gpu", .boneCount = 1, .source = BoneSource::kBuffer, .deviation = 0.1f});
  ASSERT_TRUE(host && gpu);
  HairObject& expected =
      run_.add(asset_, {.name = "expected", .settings = settings_, .skeleton = *host});
  const HairId first = run_.lastHair();
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_, .skeleton = *gpu});
  const HairId second = run_.lastHair();
  double difference = 0, force = 0;
  World world;
  for (int frame = 0; frame < kFrames; ++frame) {
    if (frame == kTeleport) {
      world = rotated();
      for (const HairId id : {first, second}) expectOk(run_.scene.teleport(id, world.transform()));
    }
    const AffineTransform bone = headAt(frame, world).transform();
    run_.scene.skeleton(*host).setBones({&bone, 1});
    std::vector<float> floats;
    for (const Float4& row : bone.rows) floats.insert(floats.end(), {row.x, row.y, row.z, row.w});
    palette.write(floats);
    run_.scene.skeleton(*gpu).setBones({.buffer = palette.id()}, bone);
    setGravity(expected, world);
    setGravity(hair, world);
    run_.step();
    keepLargest(difference, distanceOf(run_.positions(hair), run_.positions(expected), {}));
    keepLargest(force, largestForce(hair));
  }
  printFigure("bones on the GPU [m]", difference);
  EXPECT_GT(force, 1) << "strands push each other";
  EXPECT_LT(difference, 1e-4);
  run_.clear();
  for (const SkeletonId id : {*host, *gpu}) EXPECT_TRUE(run_.scene.removeSkeleton(id));
}

}  // namespace
}  // namespace pelage::test
