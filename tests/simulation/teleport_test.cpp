// Teleports: an object that is taken elsewhere in the middle of its motion, against the same that
// is not.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "pelage/skeleton.h"
#include "stress/stress_run.h"

namespace pelage::test {
namespace {

struct Drawn {
  std::vector<Float4> positions, tangents;
};

class Teleport : public SolverTest {
 protected:
  Teleport() {
    settings_.wind = {.velocity = {0, 0, 0.3f}, .gustStrength = 0, .strandVariation = 0};
  }
  void teleport(const RigidMotion& motion) {
    expectOk(run_.scene.teleport(run_.lastHair(), motion.transform()));
  }
  Drawn drawn(const HairObject& hair) const {
    return {run_.positions(hair), run_.read(hair.buffers().tangents)};
  }

  /// A head that turns and goes, in a world that is moved.
  void setInputs(HairObject& hair, int frame, const RigidMotion& world) {
    const double t = pace_ * frame;
    const RigidMotion head = RigidMotion::about(0.5 * std::sin(0.2 * t), Vector3d(1, 2, -0.5),
                                                Vector3d(0.01 * t, 0.1 * std::sin(0.3 * t), 0));
    setBone(hair, (world * head).transform());
    const Float3 ball =
        toFloat3(world(toVector(toFloat4(Vector3d(0.1 + 0.01 * t, -0.08 + 0.002 * t, 0.02)))));
    const CapsuleCollider capsule = {
        .head = ball,
        .headRadius = 0.09f,
        .tail = ball,
        .tailRadius = 0.09f,
        .angularVelocity = toFloat3(world.rotation * Vector3d(0.5, 0, 1))};
    hair.setColliders({&capsule, pace_ < 1 ? 1u : 0u});
    hair.settings.gravity = toFloat3(world.rotation * Vector3d(0, -9.81, 0));
    hair.settings.wind.velocity = toFloat3(world.rotation * Vector3d(0, 0, 0.3));
  }
  /// The frames from `first` on, with a teleport before that one.
  std::vector<Drawn> tell(const HairAsset& asset, const HairDef& def, int first, int frames,
                          const std::vector<RigidMotion>& teleports) {
    HairObject& hair = run_.add(asset, def);
    std::vector<Drawn> story;
    RigidMotion world;
    contactRecords_ = 0;
    for (int frame = 0; frame < frames; ++frame) {
      if (frame == first) {
        for (const RigidMotion& motion : teleports) {
          teleport(motion);
          world = motion * world;
        }
      }
      setInputs(hair, frame, world);
      run_.step(frame % 4 == 3 ? 1.0f / 40 : 1.0f / 60);
      if (frame >= first) story.push_back(drawn(hair));
    }
    if (hair.buffers().contactWords != BufferId::kInvalid) {
      const auto words = run_.read<uint32_t>(hair.buffers().contactWords);
      contactRecords_ = readContactCounters(std::as_bytes(std::span(words))).records;
    }
    run_.clear();
    return story;
  }

  /// Speed of the head; below 1 there is a ball in its way. Contacts that begin and end in every
  /// frame of a fast head make a difference of rounding into one of millimeters.
  double pace_ = 1;
  uint32_t contactRecords_ = 0;  ///< of the last story's last frame
};

const std::vector<std::vector<RigidMotion>>& teleports() {
  static const std::vector<std::vector<RigidMotion>> kAll = {
      {RigidMotion::about(2.2, {1, -2, 0.7}, {7, -3, 12})},
      {RigidMotion::about(1.1, {0, 1, 3}, {-2, 0.3, 1.7}),
       RigidMotion::about(3.1, {1, 1, 0}, {5, 5, -9})}};
  return kAll;
}

// K18
TEST_P(Teleport, TheFramesAfterItAreThoseOfHairThatWasAlwaysThere) {
  const HairAsset asset = wavyAsset(40, 12);
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f}));
  const HairDef def = {.settings = settings_,
                       .followHairs = follows,
                       .storeFollowHairs = true,
                       .collidingHair = CollidingHair::kGuidesAndFollows};
  for (const double pace : {1.0, 0.2}) {
    pace_ = pace;
    const std::vector<Drawn> still = tell(asset, def, 20, 28, {});
    if (pace < 1) {
      EXPECT_GT(contactRecords_, 10u);
    }
    for (const std::vector<RigidMotion>& motions : teleports()) {
      RigidMotion all;
      for (const RigidMotion& motion : motions) all = motion * all;
      const std::vector<Drawn> moved = tell(asset, def, 20, 28, motions);
      ASSERT_EQ(moved.size(), still.size());
      const RigidMotion rotation = all.withoutShift();
      for (size_t i = 0; i < moved.size(); ++i) {
        const double off = maxDistance(moved[i].positions, still[i].positions, all);
        printFigure("pace " + std::to_string(pace) + ", frame " + std::to_string(i) + " [m]", off);
        EXPECT_LT(off, i == 0 ? 1e-5 : 1e-3) << i;
        EXPECT_LT(maxDistance(moved[i].tangents, still[i].tangents, rotation), i == 0 ? 1e-3 : 5e-2)
            << i;
      }
    }
  }
}

TEST_P(Teleport, APauseShowsHairWhereItIsNow) {
  const HairAsset asset = wavyAsset(20, 8);
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f}));
  HairObject& hair =
      run_.add(asset, {.settings = settings_, .followHairs = follows, .storeFollowHairs = true});
  for (int frame = 0; frame < 10; ++frame) {
    setInputs(hair, frame, {});
    hair.setColliders({});
    run_.step();
  }
  const Drawn before = drawn(hair);
  const RigidMotion motion = RigidMotion::about(2.2, {1, -2, 0.7}, {40, -3, 12});
  teleport(motion);
  // In a world that is shifted as well.
  expectOk(run_.scene.shiftOrigin({40, 0, 10}));
  RigidMotion there = motion;
  there.shift -= Vector3d(40, 0, 10);
  run_.step(0);
  const Drawn after = drawn(hair);
  EXPECT_LT(maxDistance(after.positions, before.positions, there), 1e-5);
  EXPECT_LT(maxDistance(after.tangents, before.tangents, there.withoutShift()), 1e-5);
  run_.step(0);
  EXPECT_EQ(drawn(hair).positions, after.positions) << "once";
  expectOk(run_.scene.shiftOrigin({-40, 0, -10}));
}

TEST_P(Teleport, ALostFrameIsNotTheEndOfIt) {
  const HairAsset asset = wavyAsset(20, 8);
  const RigidMotion motion = RigidMotion::about(2.2, {1, -2, 0.7}, {4, -3, 12});
  std::vector<Drawn> ends;
  for (const int lost : {0, 1, 2}) {
    HairObject& hair = run_.add(asset, {.settings = settings_});
    for (int frame = 0; frame < 8; ++frame) {
      setInputs(hair, frame, {});
      run_.step();
    }
    const double time = run_.scene.time();
    PassList list;
    const auto loseFrame = [&](const RigidMotion& world) {
      setInputs(hair, 8, world);
      expectOk(run_.scene.simulate(1.0f / 60, list));
      run_.scene.finish(list);
      expectOk(run_.device()->update(run_.scene.resources()));
    };
    // Written before the teleport, and behind it.
    if (lost == 1) loseFrame({});
    teleport(motion);
    if (lost == 2) loseFrame(motion);
    for (int frame = 8; frame < 10; ++frame) {
      setInputs(hair, frame, motion);
      run_.step();
    }
    EXPECT_NEAR(run_.scene.time(), time + 2.0 / 60, 1e-6);
    ends.push_back(drawn(hair));
    run_.clear();
  }
  for (const size_t i : {1u, 2u}) {
    EXPECT_LT(maxDistance(ends[i].positions, ends[0].positions, {}), 1e-6) << i;
    EXPECT_LT(maxDistance(ends[i].tangents, ends[0].tangents, {}), 1e-5) << i;
  }
}

TEST_P(Teleport, SleepingHairSleepsOn) {
  if (!exact()) return;
  settings_.wind = {};
  settings_.damping = 0.3f;
  const HairAsset asset = wavyAsset(40, 8);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 600 && (frame == 0 || run_.awake(hair) > 0); ++frame) run_.step();
  ASSERT_EQ(run_.awake(hair), 0u);
  const Drawn before = drawn(hair);
  const RigidMotion motion = RigidMotion::about(2.2, {0, 1, 0}, {100, 0.5, -30});
  teleport(motion);
  setBone(hair, motion.transform());
  for (int frame = 0; frame < 3; ++frame) {
    run_.step();
    EXPECT_EQ(run_.awake(hair), 0u);
  }
  EXPECT_LT(maxDistance(drawn(hair).positions, before.positions, motion), 2e-5) << "at 100 m";
}

TEST_P(Teleport, NeedsARigidMotionOfAnObjectOfTheScene) {
  const HairAsset asset = wavyAsset(3, 8);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  run_.step();
  run_.step();
  const Drawn before = drawn(hair);
  AffineTransform scaled, mirrored, sheared, nan, far;
  scaled.rows[0].x = scaled.rows[1].y = scaled.rows[2].z = 1.1f;
  mirrored.rows[1].y = -1;
  sheared.rows[0].y = 0.2f;
  nan.rows[2].z = std::numeric_limits<float>::quiet_NaN();
  far.rows[1].w = 1e9f;
  for (const AffineTransform& bad : {scaled, mirrored, sheared, nan, far}) {
    expectError(run_.scene.teleport(run_.lastHair(), bad), "teleport()");
  }
  EXPECT_FALSE(run_.scene.teleport({}, {}));
  Scene other;
  EXPECT_FALSE(other.teleport(run_.lastHair(), {}));
  run_.step(0);
  EXPECT_EQ(drawn(hair).positions, before.positions);
}

INSTANTIATE_TEST_SUITE_P(All, Teleport, solversOnFirstApi(), solverTestName);

// ---- the kernel

class MoveRigidly : public GpuTest {};

Eigen::Vector4d toVector4(const Float4& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z),
          static_cast<double>(v.w)};
}

TEST_P(MoveRigidly, MovesEachKindAndKeepsTheRest) {
  using namespace move_rigidly;
  std::vector<Float4> data;
  for (uint32_t i = 0; i < 40; ++i) {
    const double t = i;
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.3 * t, Vector3d(1, 0.2 * t, -2).normalized()));
    data.push_back(toFloat4(q.vec(), q.w()));
    // Words that are no floats, as records have them.
    if ((i + 3) / 2 % 3 != 2) data.back().w = std::bit_cast<float>(0xf0001u + i);
  }
  data[20] = {0, 0, 0, 0};
  const GuardedBuffer<Float4> buffer(gpu(), "elements", data);
  const RigidMotion motion = RigidMotion::about(2.2, {1, -2, 0.7}, {7, -3, 12});
  const Eigen::Quaterniond q(motion.rotation);
  MoveRigidlyConstants constants = {};
  constants.movedFirst = 3;
  constants.movedCount = 30;
  constants.movedBlock = 2;
  constants.movedPeriod = 3;
  constants.movedKinds =
      kMovesPoint | kMovesDirection << kMovedKindBits | kMovesFrame << (2 * kMovedKindBits);
  constants.moveRotation = toFloat4(q.vec(), q.w());
  constants.moveShift = toFloat4(motion.shift);
  dispatch(gpu(), moveRigidlyVariant({}), constants.movedCount, [&](PassBuilder& pass) {
    buffer.bindTo(pass, "g_movedElements");
    pass.constants("MoveRigidlyConstants", constants);
  });
  const std::vector<Float4> moved = buffer.read();
  ASSERT_EQ(moved.size(), data.size());
  for (size_t i = 0; i < data.size(); ++i) {
    const auto bits = [&](const Float4& v) { return std::bit_cast<uint32_t>(v.w); };
    if (i < 3 || i >= 33) {
      EXPECT_EQ(std::memcmp(&moved[i], &data[i], sizeof(Float4)), 0) << i;
      continue;
    }
    const size_t block = (i - 3) / 2 % 3;
    if (block == 2) {
      const Eigen::Vector4d old = toVector4(data[i]);
      const Eigen::Quaterniond expected =
          q * Eigen::Quaterniond(old.w(), old.x(), old.y(), old.z());
      EXPECT_LT((toVector4(moved[i]) - expected.coeffs()).norm(), 1e-6) << i;
      continue;
    }
    RigidMotion part = motion;
    if (block == 1) part.shift.setZero();
    EXPECT_LT((toVector(moved[i]) - part(data[i])).norm(), 1e-5) << i;
    EXPECT_EQ(bits(moved[i]), bits(data[i])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, MoveRigidly, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
