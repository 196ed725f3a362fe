// HairObject::setRestPose(): another rest pose for hair that goes on as it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

constexpr uint32_t kStyledStrands = 40, kStyledVertices = 12;

/// Other curls from the same roots: edges behind the first one are rotated about an axis, more and
/// more towards the tip, and have other lengths.
HairAsset restyled(const HairAsset& asset, double angle, double scale) {
  HairAsset other = asset;
  const uint32_t n = asset.verticesPerStrand;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    Vector3d p = toVector(asset.positions[s * n + 1]);
    for (uint32_t v = 2; v < n; ++v) {
      const size_t at = size_t{s} * n + v;
      const Vector3d edge = toVector(asset.positions[at]) - toVector(asset.positions[at - 1]);
      const Eigen::AngleAxisd turn(angle * v / n, Vector3d(1, 0.3, -0.2).normalized());
      p += scale * (turn * edge);
      other.positions[at] = toFloat4(p, 1);
    }
  }
  expectOk(other.process());
  return other;
}

class RestPose : public StressTest {
 protected:
  void SetUp() override {
    StressTest::SetUp();
    makeHairReturnSoon();
    settings_.globalStiffness = 0;
  }
  HairObject& add(const HairAsset& asset, bool levelOfDetail = false) {
    id_ = StressTest::add(asset, {.settings = settings_, .levelOfDetail = levelOfDetail});
    return hair();
  }
  HairObject& hair() { return run_.scene.hair(id_); }
  void pose(int frame) {
    const double t = std::min(frame, 20);
    setBone(hair(), RigidMotion::about(0.02 * t, {0, 0.6, 0.8}, {0.005 * t, 0, 0}).transform());
  }
  void step(int frame) {
    pose(frame);
    run_.step();
  }
  std::vector<Float4> positions() { return run_.positions(hair()); }

  HairId id_ = HairId::kInvalid;
};

TEST_P(RestPose, ThePresentOneChangesNothing) {
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  std::vector<std::vector<Float4>> ends;
  for (const bool set : {false, true}) {
    add(asset);
    for (int frame = 0; frame < 20; ++frame) {
      if (set && frame % 5 == 2) {
        expectOk(hair().setRestPose(asset.positions));
      }
      step(frame);
    }
    ends.push_back(positions());
    const std::vector<Float4> tangents = run_.read(hair().buffers().tangents);
    ends.back().insert(ends.back().end(), tangents.begin(), tangents.end());
    remove(id_);
  }
  EXPECT_TRUE(sameBits(ends[0], ends[1]));
}

TEST_P(RestPose, HairSettlesWhereThatOfAFreshObjectDoes) {
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  for (const auto& [scale, globalStiffness] : {std::pair(1.0, 0.0f), std::pair(0.7, 0.2f)}) {
    settings_.globalStiffness = globalStiffness;
    const HairAsset other = restyled(asset, 0.8, scale);
    constexpr int kFrames = 200;
    add(other);
    for (int frame = 0; frame < kFrames; ++frame) step(frame);
    const std::vector<Float4> fresh = positions();
    remove(id_);
    add(asset, exact());
    for (int frame = 0; frame < 10; ++frame) step(frame);
    const std::vector<Float4> before = positions();
    expectOk(hair().setRestPose(other.positions));
    for (int frame = 10; frame < kFrames; ++frame) step(frame);
    const std::vector<Float4> changed = positions();
    remove(id_);
    EXPECT_GT(maxDistance(before, fresh), 0.02);
    const double off = maxDistance(changed, fresh);
    printFigure(label() + ", scale " + std::to_string(scale) + ", globalStiffness " +
                    std::to_string(globalStiffness) + " [m]",
                off);
    EXPECT_LT(off, 1e-3);
    double stretch = 0;
    for (uint32_t s = 0; s < kStyledStrands; ++s)
      keepLargest(stretch, stretchOf(other, changed, s, 1e-6));
    EXPECT_LT(stretch, 1e-3);
  }
}

// In the frame of the change, against the same frame without it. The exact solver keeps directions;
// the classic one finds them anew for the new lengths.
TEST_P(RestPose, NoVertexJumpsFartherThanLengthsChange) {
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  const HairAsset other = restyled(asset, 0, 1.1);
  std::vector<std::vector<Float4>> frames;
  for (const bool set : {false, true}) {
    add(asset);
    for (int frame = 0; frame < 12; ++frame) step(frame);
    if (set) expectOk(hair().setRestPose(other.positions));
    step(12);
    frames.push_back(positions());
    remove(id_);
  }
  double before = 0, whole = 0, stretch = 0;
  for (uint32_t s = 0; s < kStyledStrands; ++s) {
    double change = 0, largest = 0;
    for (uint32_t v = 1; v < kStyledVertices; ++v) {
      const size_t at = size_t{s} * kStyledVertices + v;
      change += std::abs(double{other.restLengths[at - 1]} - double{asset.restLengths[at - 1]});
      const double jump = distance(frames[0][at], frames[1][at]);
      if (v == 1) {
        ASSERT_LT(jump, 1e-5) << s;
        continue;
      }
      keepLargest(before, jump / change);
      keepLargest(largest, jump);
    }
    keepLargest(whole, largest / change);
    keepLargest(stretch, stretchOf(other, frames[1], s, 1e-6));
  }
  printFigure(label() + ", jump over the change of the lengths before the vertex", before);
  printFigure(label() + ", jump over the change of the strand's length", whole);
  EXPECT_LT(exact() ? before : whole, exact() ? 1.01 : 2);
  EXPECT_LT(stretch, 1e-3);
}

TEST_P(RestPose, FramesThatDoNotRunKeepIt) {
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  const HairAsset other = restyled(asset, 0.8, 1.2);
  std::vector<std::vector<Float4>> ends;
  for (const bool lost : {false, true}) {
    add(asset);
    for (int frame = 0; frame < 8; ++frame) step(frame);
    expectOk(hair().setRestPose(other.positions));
    if (lost) {
      PassList list;
      expectOk(run_.scene.simulate(1.0f / 60, list));
      run_.scene.finish(list);
    }
    for (int frame = 8; frame < 14; ++frame) step(frame);
    ends.push_back(positions());
    remove(id_);
  }
  EXPECT_TRUE(sameBits(ends[0], ends[1]));
}

TEST_P(RestPose, OtherObjectsOfTheAssetKeepTheirs) {
  const auto asset = std::make_shared<const HairAsset>(wavyAsset(kStyledStrands, kStyledVertices));
  const HairAsset other = restyled(*asset, 0.8, 1.2);
  const HairId first = StressTest::add(*asset, {.settings = settings_});
  id_ = StressTest::add(*asset, {.settings = settings_});
  for (int frame = 0; frame < 4; ++frame) step(frame);
  EXPECT_EQ(hair().buffers().rest, run_.scene.hair(first).buffers().rest);
  expectOk(hair().setRestPose(other.positions));
  step(4);
  EXPECT_NE(hair().buffers().rest, run_.scene.hair(first).buffers().rest);
  // And back: nothing is left of it.
  expectOk(hair().setRestPose(asset->positions));
  step(5);
  step(6);
  EXPECT_EQ(hair().buffers().rest, run_.scene.hair(first).buffers().rest);
}

TEST_P(RestPose, HairThatIsNotSimulatedTakesItAtOnce) {
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  HairAsset other = restyled(asset, 0.8, 1.2);
  for (Float4& p : other.positions) p.x += 0.01f;  // the roots, too
  expectOk(other.process());
  add(asset);
  hair().simulated = false;
  for (int frame = 0; frame < 4; ++frame) run_.step();
  EXPECT_LT(maxDistance(positions(), asset.positions), 1e-5);
  expectOk(hair().setRestPose(other.positions));
  run_.step();
  EXPECT_LT(maxDistance(positions(), other.positions), 1e-5);
  // So does a reset.
  hair().simulated = true;
  hair().settings.gravity = {};
  hair().settings.wind.velocity = {};
  expectOk(hair().setRestPose(asset.positions));
  hair().reset();
  run_.step();
  EXPECT_LT(maxDistance(positions(), asset.positions), 1e-4);
}

TEST_P(RestPose, WakesHairThatSleeps) {
  if (!exact()) GTEST_SKIP() << "the classic solver does not sleep";
  settings_.wind.velocity = {};
  settings_.sleep.speed = 0.01f;
  settings_.sleep.time = 0.1f;
  const HairAsset asset = wavyAsset(kStyledStrands, kStyledVertices);
  add(asset);
  for (int frame = 0; frame < 200; ++frame) run_.step();
  ASSERT_EQ(run_.awake(hair()), 0u);
  expectOk(hair().setRestPose(asset.positions));
  run_.step();
  EXPECT_EQ(run_.awake(hair()), 0u);
  expectOk(hair().setRestPose(restyled(asset, 0.8, 1).positions));
  run_.step();
  EXPECT_EQ(run_.awake(hair()), kStyledStrands);
}

INSTANTIATE_TEST_SUITE_P(All, RestPose, solversOnFirstApi(), solverTestName);

TEST(RestPoseViews, SeeHairWhereItsNewPoseIs) {
  Scene scene;
  const HairAsset asset = wavyAsset(3, 5);
  const auto added = required(scene.addHair(asset, {}));
  const auto isSeen = [&](float x) {
    PassList list;
    EXPECT_TRUE(scene.simulate(1.0f / 60, list));
    scene.finish(list);
    setDelivered(list.run);
    View view;
    view.eye = {x, 0, 2};
    view.worldToClip = lookAt(view.eye, {x, 0, 0}, {0, 1, 0}, 0.4f, 1, 0.1f, 10);
    view.width = view.height = 16;
    PassList drawn;
    EXPECT_TRUE(scene.draw(view, {}, drawn));
    return !drawn.passes.empty();
  };
  EXPECT_TRUE(isSeen(0));
  EXPECT_FALSE(isSeen(8));
  std::vector<Float4> moved = asset.positions;
  for (Float4& p : moved) p.x += 8;
  expectOk(scene.hair(*added).setRestPose(moved));
  EXPECT_TRUE(isSeen(8));
  EXPECT_FALSE(isSeen(0));
}

TEST(RestPoseErrors, NameWhatIsWrongAndChangeNothing) {
  Scene scene;
  const HairAsset asset = wavyAsset(3, 5);
  const auto added = required(scene.addHair(asset, {.name = "mane"}));
  HairObject& hair = scene.hair(*added);
  PassList list;
  ASSERT_TRUE(scene.simulate(1.0f / 60, list));
  scene.finish(list);
  setDelivered(list.run);
  const auto expectWrong = [&](const std::vector<Float4>& positions, const char* text) {
    expectError(hair.setRestPose(positions), {"mane", "setRestPose()", text});
  };
  std::vector<Float4> positions = asset.positions;
  positions.pop_back();
  expectWrong(positions, "got 14 positions, but 3 guides of 5 vertices have 15");
  expectWrong({}, "got 0 positions");
  for (const float value : {kNan, kInf, 2e6f}) {
    positions = asset.positions;
    positions[7].y = value;
    expectWrong(positions, "strand 1");
  }
  const BufferId rest = hair.buffers().rest;
  ASSERT_TRUE(scene.simulate(1.0f / 60, list));
  EXPECT_EQ(hair.buffers().rest, rest);
}

}  // namespace
}  // namespace pelage::test
