// Strands between the last two states of the simulation: where they are drawn, and that nothing of
// it is there where nobody asks for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/skeleton.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/lists.h"
#include "support/pictures.h"
#include "support/plain_asset.h"
#include "support/scene_run.h"
#include "support/strand_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

AffineTransform rolled(double degrees, Float3 move) {
  const double half = degrees * std::numbers::pi / 360;
  return rigidTransform(
      {0, 0, static_cast<float>(std::sin(half)), static_cast<float>(std::cos(half))}, move);
}

/// xyz alone; infinite where something is not a number, or there is nothing.
double maxDistance(const std::vector<Float4>& a, const std::vector<Float4>& b) {
  if (a.empty() || a.size() != b.size()) return kInfinity;
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double off = (toVector(a[i]) - toVector(b[i])).norm();
    if (!std::isfinite(off)) return kInfinity;
    keepLargest(largest, off);
  }
  return largest;
}

std::vector<Float4> moved(const std::vector<Float4>& points, const AffineTransform& by) {
  std::vector<Float4> result;
  for (const Float4& p : points) {
    const auto row = [&](int i) {
      const Float4& r = by.rows[i];
      return double{r.x} * double{p.x} + double{r.y} * double{p.y} + double{r.z} * double{p.z} +
             double{r.w};
    };
    result.push_back(toFloat4(Vector3d(row(0), row(1), row(2)), double{p.w}));
  }
  return result;
}

class StrandInterpolation : public SceneRunTest<std::tuple<Api, Solver>> {
 protected:
  HairObject& add(bool storesFollows) {
    HairAsset asset = wavyAsset(12, 9);
    // One strand is shorter: its last vertices are where it ends.
    for (size_t v = 6; v < 9; ++v) asset.positions[9 + v] = asset.positions[9 + 5];
    expectOk(asset.process());
    const auto follows = asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f});
    EXPECT_TRUE(follows);
    HairDef def = {.followHairs = *follows, .storeFollowHairs = storesFollows};
    def.settings.solver = std::get<1>(GetParam());
    HairObject& hair = run_.add(asset, def);
    hair.interpolates = true;
    return hair;
  }
  HairObject& hair() { return run_.scene.hair(run_.lastHair()); }
  void pose(int frame) {
    const AffineTransform now = rolled(6 * frame, {0.02f * static_cast<float>(frame), 0, 0});
    hair().setBones({&now, 1});
  }
  void move(int frames) {
    for (int i = 0; i < frames; ++i) {
      pose(frame_++);
      run_.step();
    }
  }
  /// A frame that simulates nothing, between the states.
  void place(float share) {
    PassList list;
    expectOk(run_.scene.simulate(0, list));
    expectOk(run_.scene.interpolate(share, list));
    run_.execute(list);
  }
  std::vector<Float4> drawn(float share) {
    place(share);
    return run_.read(hair().buffers().drawnPositions);
  }
  std::vector<Float4> positions() { return run_.positions(hair()); }
  std::vector<Float4> tangents() { return run_.read(hair().buffers().tangents); }
  /// [2][guide][2]
  std::vector<Float4> roots() {
    const BufferRange range = hair().rootTransforms();
    const std::vector<Float4> state = run_.read(range.buffer);
    const auto first = state.begin() + static_cast<ptrdiff_t>(range.offset / sizeof(Float4));
    return {first, first + static_cast<ptrdiff_t>(range.size / sizeof(Float4))};
  }

  int frame_ = 0;
};

TEST_P(StrandInterpolation, EndsAreTheStatesAndTheMiddleIsTheirMean) {
  add(true);
  move(4);
  const std::vector<Float4> before = positions(), tangentsBefore = tangents();
  move(1);
  const std::vector<Float4> now = positions(), tangentsNow = tangents();
  EXPECT_GT(maxDistance(before, now), 0.01);
  EXPECT_TRUE(sameBits(drawn(1), now));
  EXPECT_LT(maxDistance(run_.read(hair().buffers().drawnTangents), tangentsNow), 1e-4);
  EXPECT_TRUE(sameBits(drawn(0), before));
  EXPECT_LT(maxDistance(run_.read(hair().buffers().drawnTangents), tangentsBefore), 1e-4);
  for (const float share : {0.5f, 0.2f}) {
    std::vector<Float4> expected;
    for (size_t i = 0; i < now.size(); ++i)
      expected.push_back(
          toFloat4(toVector(before[i]) + double{share} * (toVector(now[i]) - toVector(before[i]))));
    EXPECT_LT(maxDistance(drawn(share), expected), 2e-7) << share;
    for (const Float4& tangent : run_.read(hair().buffers().drawnTangents))
      ASSERT_NEAR(toVector(tangent).norm(), 1, 1e-5);
  }
  // The simulation does not notice.
  EXPECT_TRUE(sameBits(positions(), now));
}

TEST_P(StrandInterpolation, RootsOfComputedFollowHairsAreBetweenTheirPoses) {
  add(false);
  move(3);
  const std::vector<Float4> states = roots();
  const size_t half = states.size() / 2;
  const std::vector<Float4> now(states.begin(), states.begin() + static_cast<ptrdiff_t>(half));
  const std::vector<Float4> before(states.begin() + static_cast<ptrdiff_t>(half), states.end());
  const auto placed = [&](float share) {
    place(share);
    return run_.read(hair().buffers().drawnRoots);
  };
  const auto firstHalf = [&](const std::vector<Float4>& all) {
    return std::vector<Float4>(all.begin(), all.begin() + static_cast<ptrdiff_t>(half));
  };
  const std::vector<Float4> first = placed(1);
  EXPECT_TRUE(sameBits(firstHalf(first), now));
  // Nothing was drawn before.
  EXPECT_TRUE(std::memcmp(first.data(), first.data() + half, half * sizeof(Float4)) == 0);
  const std::vector<Float4> second = placed(0);
  EXPECT_TRUE(sameBits(firstHalf(second), before));
  EXPECT_TRUE(std::memcmp(second.data() + half, now.data(), half * sizeof(Float4)) == 0);
  const std::vector<Float4> third = placed(0.5f);
  for (size_t i = 0; i < half; i += 2) {
    const Vector3d middle = (toVector(now[i + 1]) + toVector(before[i + 1])) / 2;
    ASSERT_LT((toVector(third[i + 1]) - middle).norm(), 1e-6);
    // Half of 6 degrees.
    const auto rotation = [](const Float4& q) {
      return Eigen::Quaterniond(double{q.w}, double{q.x}, double{q.y}, double{q.z});
    };
    ASSERT_NEAR(rotation(third[i]).norm(), 1, 1e-6);
    ASSERT_NEAR(rotation(third[i]).angularDistance(rotation(before[i])), 3 * std::numbers::pi / 180,
                1e-4);
    ASSERT_NEAR(rotation(third[i]).angularDistance(rotation(now[i])), 3 * std::numbers::pi / 180,
                1e-4);
  }
}

TEST_P(StrandInterpolation, AResetHasNoStateBefore) {
  add(true);
  move(4);
  hair().reset();
  // Shown where it will begin, before it moves.
  const std::vector<Float4> waiting = drawn(0);
  EXPECT_TRUE(sameBits(waiting, positions()));
  frame_ = 20;
  move(1);
  const std::vector<Float4> now = positions();
  for (const float share : {0.0f, 0.5f, 1.0f}) EXPECT_TRUE(sameBits(drawn(share), now)) << share;
  move(1);
  EXPECT_TRUE(sameBits(drawn(0), now));
}

TEST_P(StrandInterpolation, ATeleportTakesBothStatesAlong) {
  for (const bool simulated : {true, false}) {
    add(true);
    hair().simulated = simulated;
    frame_ = 0;
    move(4);
    const std::vector<Float4> before = positions();
    move(1);
    const AffineTransform motion = rolled(130, {7, -3, 12});
    expectOk(run_.scene.teleport(run_.lastHair(), motion));
    // In a pause.
    EXPECT_LT(maxDistance(drawn(0), moved(before, motion)), 1e-5);
    EXPECT_TRUE(sameBits(drawn(1), positions()));
    // And in a frame that moves.
    const std::vector<Float4> there = positions();
    const AffineTransform back = rolled(-40, {-2, 5, 1});
    expectOk(run_.scene.teleport(run_.lastHair(), back));
    run_.step();
    EXPECT_LT(maxDistance(drawn(0), moved(there, back)), 1e-5);
    EXPECT_TRUE(sameBits(drawn(1), positions()));
    EXPECT_LT(maxDistance(drawn(0), positions()), 0.1);
    run_.clear();
  }
}

TEST_P(StrandInterpolation, GoesAlongWithTheOriginOfTheWorld) {
  for (const bool simulates : {false, true}) {
    add(true);
    frame_ = 0;
    move(4);
    const std::vector<Float4> first = positions();
    move(1);
    const std::vector<Float4> second = positions();
    drawn(0.5f);
    expectOk(run_.scene.shiftOrigin({3, -2, 5}));
    const AffineTransform shift = rolled(0, {-3, 2, -5});
    if (simulates) {
      const AffineTransform now =
          rolled(6 * (frame_ - 1), {0.02f * static_cast<float>(frame_ - 1) - 3, 2, -5});
      hair().setBones({&now, 1});
      run_.step();
    }
    EXPECT_LT(maxDistance(drawn(0), moved(simulates ? second : first, shift)), 2e-6);
    EXPECT_TRUE(sameBits(drawn(1), positions()));
    expectOk(run_.scene.shiftOrigin({-3, 2, -5}));
    run_.clear();
  }
}

TEST_P(StrandInterpolation, FramesThatDoNotRunChangeNothing) {
  std::vector<std::vector<Float4>> results;
  for (const int lost : {0, 1, 2}) {
    add(true);
    hair().tracksMotion = true;
    frame_ = 0;
    move(3);
    place(0.25f);
    if (lost > 0) {
      PassList list;
      pose(17);
      expectOk(run_.scene.simulate(lost == 1 ? 1.0f / 60 : 0.0f, list));
      expectOk(run_.scene.interpolate(0.9f, list));
      run_.scene.finish(list);
      if (lost == 2) expectOk(run_.device()->update(run_.scene.resources()));
    }
    move(1);
    std::vector<Float4> result = drawn(0.75f);
    const std::vector<Float4> kept = run_.read(hair().buffers().previousPositions);
    result.insert(result.end(), kept.begin(), kept.end());
    results.push_back(result);
    run_.clear();
  }
  EXPECT_TRUE(sameBits(results[0], results[1]));
  EXPECT_TRUE(sameBits(results[0], results[2]));
}

TEST_P(StrandInterpolation, PicturesAreThoseOfTheStates) {
  for (const bool stored : {true, false}) {
    add(stored);
    hair().material.fiberRadius = 0.002f;
    frame_ = 0;
    move(4);
    const RenderedImage before = run_.render({0.1f, 0, 1}, 96);
    move(1);
    const RenderedImage now = run_.render({0.1f, 0, 1}, 96);
    const auto off = [](const RenderedImage& a, const RenderedImage& b) {
      double sum = 0;
      for (size_t i = 0; i < a.pixels.size(); ++i)
        sum += (toVector(a.pixels[i]) - toVector(b.pixels[i])).norm();
      return sum / static_cast<double>(a.pixels.size());
    };
    const double apart = off(before, now);
    EXPECT_GT(apart, 1e-3);
    place(0);
    EXPECT_LT(off(run_.render({0.1f, 0, 1}, 96), before), 1e-2 * apart);
    place(1);
    EXPECT_LT(off(run_.render({0.1f, 0, 1}, 96), now), 1e-2 * apart);
    // The next frame does not ask for it.
    run_.step(0);
    EXPECT_EQ(off(run_.render({0.1f, 0, 1}, 96), now), 0);
    run_.clear();
  }
}

INSTANTIATE_TEST_SUITE_P(All, StrandInterpolation, testing::ValuesIn(solversOnApis()),
                         solverTestName);

TEST(StrandInterpolationOff, CostsNoPassAndNoBuffer) {
  Scene scene;
  const auto hair = required(scene.addHair(makeAsset(), {}));
  PassList list;
  const auto step = [&](float dt) {
    EXPECT_TRUE(scene.simulate(dt, list));
    EXPECT_TRUE(scene.interpolate(0.5f, list));
    scene.finish(list);
    setDelivered(list.run);
  };
  for (int i = 0; i < 3; ++i) step(1.0f / 60);
  const size_t passes = list.passes.size();
  const uint32_t buffers = scene.resources().count();
  EXPECT_EQ(countPasses(list, "interpolate_strands"), 0u);
  EXPECT_EQ(countPasses(list, "keep_positions"), 0u);
  step(0);
  EXPECT_TRUE(list.passes.empty());

  HairObject& object = scene.hair(*hair);
  object.interpolates = true;
  step(1.0f / 60);
  EXPECT_EQ(list.passes.size(), passes + 2);
  EXPECT_EQ(countPasses(list, "interpolate_strands"), 1u);
  EXPECT_EQ(countPasses(list, "keep_positions"), 1u);
  // Without follow hairs nothing reads roots.
  EXPECT_EQ(countPasses(list, "interpolate_roots"), 0u);
  EXPECT_EQ(scene.resources().count(), buffers + 3);
  EXPECT_NE(object.buffers().drawnPositions, BufferId::kInvalid);
  EXPECT_EQ(object.buffers().drawnRoots, BufferId::kInvalid);
  step(0);
  EXPECT_EQ(list.passes.size(), 1u);
  object.interpolates = false;
  step(1.0f / 60);
  step(1.0f / 60);
  EXPECT_EQ(list.passes.size(), passes);
  EXPECT_EQ(scene.resources().count(), buffers);
  EXPECT_EQ(object.buffers().drawnPositions, BufferId::kInvalid);
  object.interpolates = true;
  step(1.0f / 60);
  EXPECT_GT(scene.bytesOf(*hair).own, 0u);
  EXPECT_TRUE(scene.removeHair(*hair));
  EXPECT_EQ(scene.resources().count(), 0u);
}

// Between the states, hair is where neither of them is.
TEST(StrandInterpolationViews, SeeHairWhereItWasAndWhereItIs) {
  Scene scene;
  const auto hair = required(scene.addHair(makeAsset(), {}));
  HairObject& object = scene.hair(*hair);
  object.interpolates = true;
  for (const float x : {0.0f, 0.0f, 10.0f}) {
    const AffineTransform now = rolled(0, {x, 0, 0});
    object.setBones({&now, 1});
    PassList list;
    ASSERT_TRUE(scene.simulate(1.0f / 60, list));
    scene.finish(list);
    setDelivered(list.run);
  }
  const auto isSeen = [&](float x, bool placed) {
    auto frame = scene.simulate(0);
    EXPECT_TRUE(frame);
    if (placed) {
      EXPECT_TRUE(frame->interpolate(0.5f));
    }
    const View view = cameraView({.eye = {x, 0, 1},
                                  .target = {x, 0, 0},
                                  .fov = 0.4f,
                                  .width = 16,
                                  .nearPlane = 0.1f,
                                  .farPlane = 10});
    const Light light;
    EXPECT_TRUE(frame->draw(view, {&light, 1}));
    EXPECT_TRUE(frame->finish());
    return std::ranges::any_of(frame->steps(), [](const FrameStep& step) {
      return std::ranges::any_of(step.list->passes,
                                 [](const Pass& pass) { return isDraw(pass.kind); });
    });
  };
  for (const float x : {0.0f, 5.0f, 10.0f}) {
    EXPECT_TRUE(isSeen(x, true)) << x;
    EXPECT_EQ(isSeen(x, false), x == 10) << x;
  }
  EXPECT_FALSE(isSeen(-5, true));
  EXPECT_FALSE(isSeen(15, true));
}

TEST(StrandInterpolationErrors, NameWhatIsWrong) {
  Scene scene;
  const auto hair = required(scene.addHair(makeAsset(), {}));
  scene.hair(*hair).interpolates = true;
  auto frame = required(scene.simulate(1.0f / 60));
  for (const float share : {-0.01f, 1.01f, std::numeric_limits<float>::quiet_NaN()})
    expectError(frame->interpolate(share), "0..1");
  EXPECT_TRUE(frame->interpolate(0.5f));
  expectError(frame->interpolate(0.5f), "interpolated already");
  frame = scene.simulate(1.0f / 60);
  ASSERT_TRUE(frame);
  const View view = cameraView({.eye = {0, 0, 1}, .fov = 0.8f, .width = 16});
  const Light light;
  EXPECT_TRUE(frame->draw(view, {&light, 1}));
  expectError(frame->interpolate(0.5f), "drawn already");
  PassList old;
  ASSERT_TRUE(scene.simulate(1.0f / 60, old));
  scene.finish(old);
  setDelivered(old.run);
  PassList list;
  ASSERT_TRUE(scene.simulate(1.0f / 60, list));
  expectError(scene.interpolate(0.5f, old), "earlier frame");
  EXPECT_TRUE(scene.interpolate(0.5f, list));
}

}  // namespace
}  // namespace pelage::test
