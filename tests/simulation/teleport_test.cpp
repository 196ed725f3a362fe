// Teleports: an object that is taken elsewhere in the middle of its motion, against the same that
// is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/extremes.h"
#include "support/required_devices.h"

namespace pelage::test {
namespace {

struct Motion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3d shift = {0, 0, 0};

  Vector3d operator()(const Float3& p) const {
    return rotation * toVector({p.x, p.y, p.z, 0}) + shift;
  }
  Vector3d operator()(const Float4& p) const { return rotation * toVector(p) + shift; }
  Motion operator*(const Motion& first) const {
    return {rotation * first.rotation, rotation * first.shift + shift};
  }
  AffineTransform transform() const { return toTransform(rotation, shift); }
};

Float3 narrow(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Motion turned(double angle, const Vector3d& axis, const Vector3d& shift) {
  return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), shift};
}

struct Snapshot {
  std::vector<Float4> positions, tangents;
};

/// Infinite where something is not a number, or there is nothing.
double maxDistance(const std::vector<Float4>& a, const std::vector<Float4>& b, const Motion& ofB) {
  if (a.empty() || a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double distance = (toVector(a[i]) - ofB(b[i])).norm();
    if (std::isnan(distance)) return std::numeric_limits<double>::infinity();
    keepLargest(largest, distance);
  }
  return largest;
}

class Teleport : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  Teleport() : run_(sharedSceneRun(std::get<0>(GetParam()))) {
    settings_.solver = std::get<1>(GetParam());
    settings_.wind = {.velocity = {0, 0, 0.3f}, .gustStrength = 0, .strandVariation = 0};
  }
  void SetUp() override {
    if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    messages_ = run_.device()->messageCount();
  }
  void TearDown() override {
    run_.clear();
    if (run_.device() != nullptr) {
      EXPECT_EQ(run_.device()->messageCount(), messages_) << "the driver or a layer complained";
    }
  }
  bool exact() const { return settings_.solver == Solver::kExact; }
  void teleport(const Motion& motion) {
    expectOk(run_.scene.teleport(run_.lastHair(), motion.transform()));
  }
  Snapshot snapshot(const HairObject& hair) const {
    return {run_.positions(hair), run_.read(hair.buffers().tangents)};
  }
  uint32_t awake(const HairObject& hair) const {
    const std::vector<uint32_t> words = run_.read<uint32_t>(hair.buffers().sleep);
    return readCounters(std::as_bytes(std::span(words))).awakeStrands;
  }

  /// A head that turns and goes, in a world that is moved.
  void setInputs(HairObject& hair, int frame, const Motion& world) {
    const double t = pace_ * frame;
    const Motion head = turned(0.5 * std::sin(0.2 * t), Vector3d(1, 2, -0.5),
                               Vector3d(0.01 * t, 0.1 * std::sin(0.3 * t), 0));
    const AffineTransform bone = (world * head).transform();
    hair.setBones({&bone, 1});
    const Float3 ball = narrow(world(narrow(Vector3d(0.1 + 0.01 * t, -0.08 + 0.002 * t, 0.02))));
    const CapsuleCollider capsule = {
        .head = ball,
        .headRadius = 0.09f,
        .tail = ball,
        .tailRadius = 0.09f,
        .angularVelocity = narrow(world.rotation * Vector3d(0.5, 0, 1))};
    hair.setColliders({&capsule, pace_ < 1 ? 1u : 0u});
    hair.settings.gravity = narrow(world.rotation * Vector3d(0, -9.81, 0));
    hair.settings.wind.velocity = narrow(world.rotation * Vector3d(0, 0, 0.3));
  }
  /// The frames from `first` on, with a teleport before that one.
  std::vector<Snapshot> tell(const HairAsset& asset, const HairDef& def, int first, int frames,
                             const std::vector<Motion>& teleports) {
    HairObject& hair = run_.add(asset, def);
    std::vector<Snapshot> story;
    Motion world;
    contactRecords_ = 0;
    for (int frame = 0; frame < frames; ++frame) {
      if (frame == first) {
        for (const Motion& motion : teleports) {
          teleport(motion);
          world = motion * world;
        }
      }
      setInputs(hair, frame, world);
      run_.step(frame % 4 == 3 ? 1.0f / 40 : 1.0f / 60);
      if (frame >= first) story.push_back(snapshot(hair));
    }
    if (hair.buffers().contactWords != BufferId::kInvalid) {
      const auto words = run_.read<uint32_t>(hair.buffers().contactWords);
      contactRecords_ = readContactCounters(std::as_bytes(std::span(words))).records;
    }
    run_.clear();
    return story;
  }

  SceneRun& run_;
  SimulationSettings settings_;
  /// Of the head; below 1 there is a ball in its way. Contacts that a fast head begins and ends in
  /// every frame make a difference of rounding into one of millimeters.
  double pace_ = 1;
  uint32_t contactRecords_ = 0;  ///< of the last story's last frame

 private:
  uint32_t messages_ = 0;
};

const std::vector<std::vector<Motion>>& teleports() {
  static const std::vector<std::vector<Motion>> kAll = {
      {turned(2.2, {1, -2, 0.7}, {7, -3, 12})},
      {turned(1.1, {0, 1, 3}, {-2, 0.3, 1.7}), turned(3.1, {1, 1, 0}, {5, 5, -9})}};
  return kAll;
}

// K18
TEST_P(Teleport, TheFramesAfterItAreThoseOfHairThatWasAlwaysThere) {
  const HairAsset asset = wavyAsset(40, 12);
  const auto follows = asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f});
  ASSERT_TRUE(follows);
  const HairDef def = {.settings = settings_,
                       .followHairs = *follows,
                       .storeFollowHairs = true,
                       .collidingHair = CollidingHair::kGuidesAndFollows};
  for (const double pace : {1.0, 0.2}) {
    pace_ = pace;
    const std::vector<Snapshot> still = tell(asset, def, 20, 28, {});
    if (pace < 1) {
      EXPECT_GT(contactRecords_, 10u);
    }
    for (const std::vector<Motion>& motions : teleports()) {
      Motion all;
      for (const Motion& motion : motions) all = motion * all;
      const std::vector<Snapshot> moved = tell(asset, def, 20, 28, motions);
      ASSERT_EQ(moved.size(), still.size());
      const Motion rotation = {all.rotation, {0, 0, 0}};
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
  const auto follows = asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f});
  ASSERT_TRUE(follows);
  HairObject& hair =
      run_.add(asset, {.settings = settings_, .followHairs = *follows, .storeFollowHairs = true});
  for (int frame = 0; frame < 10; ++frame) {
    setInputs(hair, frame, {});
    hair.setColliders({});
    run_.step();
  }
  const Snapshot before = snapshot(hair);
  const Motion motion = turned(2.2, {1, -2, 0.7}, {40, -3, 12});
  teleport(motion);
  // In a world that is shifted as well.
  expectOk(run_.scene.shiftOrigin({40, 0, 10}));
  Motion there = motion;
  there.shift -= Vector3d(40, 0, 10);
  run_.step(0);
  const Snapshot after = snapshot(hair);
  EXPECT_LT(maxDistance(after.positions, before.positions, there), 1e-5);
  EXPECT_LT(maxDistance(after.tangents, before.tangents, {there.rotation, {0, 0, 0}}), 1e-5);
  run_.step(0);
  EXPECT_EQ(snapshot(hair).positions, after.positions) << "once";
  expectOk(run_.scene.shiftOrigin({-40, 0, -10}));
}

TEST_P(Teleport, ALostFrameIsNotTheEndOfIt) {
  const HairAsset asset = wavyAsset(20, 8);
  const Motion motion = turned(2.2, {1, -2, 0.7}, {4, -3, 12});
  std::vector<Snapshot> ends;
  for (const int lost : {0, 1, 2}) {
    HairObject& hair = run_.add(asset, {.settings = settings_});
    for (int frame = 0; frame < 8; ++frame) {
      setInputs(hair, frame, {});
      run_.step();
    }
    const double time = run_.scene.time();
    PassList list;
    const auto loseFrame = [&](const Motion& world) {
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
    ends.push_back(snapshot(hair));
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
  for (int frame = 0; frame < 600 && (frame == 0 || awake(hair) > 0); ++frame) run_.step();
  ASSERT_EQ(awake(hair), 0u);
  const Snapshot before = snapshot(hair);
  const Motion motion = turned(2.2, {0, 1, 0}, {100, 0.5, -30});
  teleport(motion);
  const AffineTransform bone = motion.transform();
  hair.setBones({&bone, 1});
  for (int frame = 0; frame < 3; ++frame) {
    run_.step();
    EXPECT_EQ(awake(hair), 0u);
  }
  EXPECT_LT(maxDistance(snapshot(hair).positions, before.positions, motion), 2e-5) << "at 100 m";
}

TEST_P(Teleport, NeedsARigidMotionOfAnObjectOfTheScene) {
  const HairAsset asset = wavyAsset(3, 8);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  run_.step();
  run_.step();
  const Snapshot before = snapshot(hair);
  AffineTransform scaled, mirrored, sheared, nan, far;
  scaled.rows[0].x = scaled.rows[1].y = scaled.rows[2].z = 1.1f;
  mirrored.rows[1].y = -1;
  sheared.rows[0].y = 0.2f;
  nan.rows[2].z = std::numeric_limits<float>::quiet_NaN();
  far.rows[1].w = 1e9f;
  for (const AffineTransform& bad : {scaled, mirrored, sheared, nan, far}) {
    const Result<void> refused = run_.scene.teleport(run_.lastHair(), bad);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("teleport()"), std::string::npos);
  }
  EXPECT_FALSE(run_.scene.teleport({}, {}));
  Scene other;
  EXPECT_FALSE(other.teleport(run_.lastHair(), {}));
  run_.step(0);
  EXPECT_EQ(snapshot(hair).positions, before.positions);
}

INSTANTIATE_TEST_SUITE_P(All, Teleport, testing::ValuesIn(solversOnApis()), stressTestName);

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
  const Motion motion = turned(2.2, {1, -2, 0.7}, {7, -3, 12});
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
  PassList list;
  PassBuilder builder(list);
  builder.dispatch(moveRigidlyVariant({}), constants.movedCount);
  buffer.bindTo(builder, "g_movedElements");
  builder.constants("MoveRigidlyConstants", constants);
  expectOk(builder.finish());
  gpu().hazards.resolve(list);
  expectOk(gpu().device()->update(gpu().resources));
  expectOk(gpu().device()->execute(list));
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
    Motion part = motion;
    if (block == 1) part.shift.setZero();
    EXPECT_LT((toVector(moved[i]) - part(data[i])).norm(), 1e-5) << i;
    EXPECT_EQ(bits(moved[i]), bits(data[i])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, MoveRigidly, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
