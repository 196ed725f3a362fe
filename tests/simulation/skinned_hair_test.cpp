// Hair that is not simulated: it moves rigidly with its bones, and goes on from there.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/plain_asset.h"

namespace pelage::test {
namespace {

/// A head that turns, and goes through more than one origin of the object.
RigidMotion walkOfHead(int frame) {
  return RigidMotion::about(0.7 * std::sin(0.2 * frame), {1, 2, -0.5},
                            {0, 0.01 * frame, 0.12 * frame});
}

class SkinnedHair : public SolverTest {
 protected:
  SkinnedHair() : asset_(wavyAsset(37, 12)) {
    // See StressTest.
    settings_.wind = {.velocity = {0, 0, 1e-4f}, .gustStrength = 0, .strandVariation = 0};
  }
  void step(HairObject& hair, const RigidMotion& motion, float dt = 1.0f / 60) {
    setBone(hair, motion.transform());
    run_.step(dt);
  }

  HairAsset asset_;
  double along_ = 0;  ///< that the roots have gone [m]
};

TEST_P(SkinnedHair, MovesRigidlyWithItsBones) {
  const std::vector<FollowHair> follows =
      valueOf(asset_.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.02f}));
  HairObject& hair = run_.add(asset_, {.settings = settings_,
                                       .followHairs = follows,
                                       .storeFollowHairs = true,
                                       .collidingHair = CollidingHair::kGuidesAndFollows});
  hair.simulated = false;
  setCollider(hair, {.head = {0, 0, 0.5f}, .headRadius = 0.2f, .tailRadius = 0.1f});
  step(hair, {});
  // All strands, in the bind pose.
  const std::vector<Float4> bind = run_.positions(hair);
  const std::vector<Float4> bindTangents = run_.read(hair.buffers().tangents);
  ASSERT_EQ(bind.size(), 3 * asset_.positions.size());
  EXPECT_LT(
      maxDistance(std::vector<Float4>(bind.begin(), bind.begin() + 37 * 12), asset_.positions),
      1e-6);
  for (int frame = 1; frame < 30; ++frame) {
    // Half way through it is simulated for some frames.
    hair.simulated = frame >= 12 && frame < 20;
    step(hair, walkOfHead(frame), frame % 3 == 0 ? 1.0f / 40 : 1.0f / 60);
    const double off = maxDistance(run_.positions(hair), bind, walkOfHead(frame));
    if (hair.simulated) continue;
    EXPECT_LT(off, 3e-6) << "frame " << frame << ", up to 3.5 m from the origin";
    EXPECT_LT(maxDistance(run_.read(hair.buffers().tangents), bindTangents,
                          walkOfHead(frame).withoutShift()),
              1e-5)
        << "frame " << frame;
  }
}

TEST_P(SkinnedHair, ContinuesWithTheVelocityOfItsRoots) {
  // Nothing acts, so hair that has the velocity of its roots keeps its shape.
  settings_.gravity = {};
  settings_.wind = {};
  for (const float share : {0.0f, 0.75f}) {
    settings_.vspCoefficient = share;
    settings_.damping = 0;
    settings_.airDrag = 0;
    HairObject& hair = run_.add(asset_, {.settings = settings_});
    hair.simulated = false;
    const auto run = [&](double speed, bool simulated) {
      double worst = 0;
      hair.simulated = simulated;
      for (int frame = 0; frame < 8; ++frame) {
        along_ += speed / 60;
        const RigidMotion motion = {.shift = {0, 0.5 * along_, along_}};
        step(hair, motion);
        keepLargest(worst, maxDistance(run_.positions(hair), asset_.positions, motion));
      }
      return worst;
    };
    along_ = 0;
    EXPECT_LT(run(2, false), 3e-6);
    EXPECT_LT(run(2, true), 1e-4) << "VSP " << share << ", 2 m/s";
    EXPECT_LT(run(2, false), 3e-6);
    run_.clear();
  }
}

TEST_P(SkinnedHair, DoesNotJumpWhenItIsSimulatedAgain) {
  HairObject& hair = run_.add(asset_, {.settings = settings_});
  hair.simulated = false;
  std::vector<std::vector<Float4>> story;
  const auto turn = [](int frame) {
    return RigidMotion::about(0.03 * frame, {0, 1, 0}, {0, 0, 0.02 * frame});
  };
  double before = 0, after = 0;
  for (int frame = 0; frame < 24; ++frame) {
    hair.simulated = frame >= 12;
    step(hair, turn(frame));
    story.push_back(run_.positions(hair));
    if (frame < 3) continue;
    // Changes of the velocity from frame to frame, times the frame's length.
    double jerk = 0;
    for (size_t i = 0; i < story.back().size(); ++i) {
      const size_t n = story.size();
      const Vector3d change =
          toVector(story[n - 1][i]) - 2 * toVector(story[n - 2][i]) + toVector(story[n - 3][i]);
      keepLargest(jerk, change.norm());
    }
    keepLargest(frame < 12 ? before : after, jerk);
    if (frame == 12) {
      EXPECT_LT(maxDistance(story.back(), asset_.positions, turn(frame)), 1e-3)
          << "the first frame";
    }
  }
  // A turn by 0.03 rad bends paths by 0.0009 radii; a velocity that was lost would be 2 cm.
  EXPECT_LT(before, 1e-3);
  EXPECT_LT(after, 4e-3);
}

TEST_P(SkinnedHair, GravityRisesOverTheBlendTime) {
  settings_.vspCoefficient = 0;
  settings_.damping = 0;
  settings_.bendLength = 0;
  settings_.localStiffness = 0;
  settings_.wind = {};
  const HairAsset flat = strandsAt(2, 3, [](uint32_t s, uint32_t v) {
    return Float3{0, 0.1f * static_cast<float>(s), 0.1f * static_cast<float>(v)};
  });
  const auto fall = [&](float blendTime, int frames) {
    HairObject& hair = run_.add(flat, {.settings = settings_});
    hair.simulated = false;
    hair.blendTime = blendTime;
    run_.step();
    run_.step();
    hair.simulated = true;
    for (int frame = 0; frame < frames; ++frame) run_.step();
    const double y = -static_cast<double>(run_.positions(hair)[2].y);
    run_.clear();
    return y;
  };
  EXPECT_GT(fall(0, 1), 0.4 * 9.81 / 3600) << "all of it at once";
  EXPECT_LT(fall(0.5f, 1), 1e-6) << "from none of it";
  // Six frames of a share that rises by 1/30 each, constant within a frame.
  const double expected = 9.81 / 3600 * 27.5 / 30;
  EXPECT_NEAR(fall(0.5f, 6), expected, 0.3 * expected);
  const double full = fall(0, 6);
  EXPECT_LT(fall(0.25f, 6), full);
  EXPECT_LT(fall(0.5f, 6), fall(0.25f, 6));
}

INSTANTIATE_TEST_SUITE_P(All, SkinnedHair, testing::ValuesIn(solversOnRuntimes()), solverTestName);

}  // namespace
}  // namespace pelage::test
