// Hair whose positions are given: by an application, and by a CachePlayer from a file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "pelage/cache_player.h"
#include "stress/stress_run.h"
#include "support/test_folder.h"

namespace pelage::test {
namespace {

constexpr uint32_t kGivenStrands = 37, kGivenVertices = 12, kGivenFrames = 12;

// Compares the guides' vertices, which come first; infinite where there are too few.
double distanceFromGiven(const std::vector<Float4>& drawn, const std::vector<Float3>& expected) {
  double largest = drawn.size() < expected.size() ? HUGE_VAL : 0;
  for (size_t i = 0; i < std::min(drawn.size(), expected.size()); ++i)
    keepLargest(largest, distance(drawn[i], {expected[i].x, expected[i].y, expected[i].z, 0}));
  return largest;
}

class GivenHair : public SceneTest {
 protected:
  GivenHair() : asset_(wavyAsset(kGivenStrands, kGivenVertices)) {}

  // The bind pose, which bends more with each frame.
  std::vector<Float3> shape(int frame, Float3 at = {}) const {
    std::vector<Float3> positions;
    for (const Float4& p : asset_.positions) {
      const float bend = 0.3f * static_cast<float>(frame) * p.z;
      positions.push_back(
          {at.x + p.x + bend * p.z, at.y + p.y - bend * bend, at.z + p.z + 0.002f * bend});
    }
    return positions;
  }
  CachePlayer player(CachePlayerDef def = {}) const {
    auto writer = HairCacheWriter::create(path_, {.name = "shot",
                                                  .strandCount = kGivenStrands,
                                                  .verticesPerStrand = kGivenVertices,
                                                  .keyInterval = 4});
    EXPECT_TRUE(writer);
    for (int f = 0; f < static_cast<int>(kGivenFrames); ++f) EXPECT_TRUE(writer->append(shape(f)));
    EXPECT_TRUE(writer->close());
    return *required(CachePlayer::open(path_, def));
  }
  void show(CachePlayer& player, double frame, HairObject& hair) {
    const auto shown = player.show(frame, hair);
    ASSERT_TRUE(shown) << shown.error().message;
    run_.step();
  }
  double drawnFrom(const HairObject& hair, const std::vector<Float3>& expected) const {
    return distanceFromGiven(run_.positions(hair), expected);
  }
  // The motion that draws get: from where the vertices were before.
  double movedFrom(const HairObject& hair, const std::vector<Float3>& expected) const {
    return distanceFromGiven(run_.read(hair.buffers().previousPositions), expected);
  }

  HairAsset asset_;
  const TestFolder folder_;
  const std::filesystem::path path_ = folder_ / "hair.pelagecache";
};

constexpr double kCacheBound = 1.001e-4;  // of the cache, and a little rounding of doubles

TEST_P(GivenHair, ACacheIsDrawnToItsBoundInAnyOrderAndMovesFromTheFrameBefore) {
  CachePlayer cache = player();
  EXPECT_EQ(cache.frameCount(), kGivenFrames);
  HairObject& hair = run_.add(asset_);
  hair.tracksMotion = true;
  int before = -100;
  for (const int frame : {0, 1, 2, 3, 3, 5, 4, 11, 10, 99, 2, 1, 7, -3}) {
    SCOPED_TRACE(frame);
    show(cache, frame, hair);
    const int now = std::clamp(frame, 0, static_cast<int>(kGivenFrames) - 1);
    EXPECT_LE(drawnFrom(hair, shape(now)), kCacheBound);
    const bool jumps = std::abs(now - before) > static_cast<int>(CachePlayer::kMaxStep);
    EXPECT_LE(movedFrom(hair, shape(jumps ? now : before)), kCacheBound);
    before = now;
  }
  show(cache, 6.5, hair);
  std::vector<Float3> middle = shape(6);
  for (size_t i = 0; i < middle.size(); ++i) {
    const Float3 a = middle[i], b = shape(7)[i];
    middle[i] = {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
  }
  EXPECT_LE(drawnFrom(hair, middle), kCacheBound);
}

TEST_P(GivenHair, ALoopBeginsAgainWithoutMotion) {
  CachePlayer cache = player({.loops = true, .framesAhead = 2});
  HairObject& hair = run_.add(asset_);
  hair.tracksMotion = true;
  const int last = static_cast<int>(kGivenFrames) - 1;
  for (int frame = last - 1; frame < 2 * static_cast<int>(kGivenFrames) + 2; ++frame) {
    SCOPED_TRACE(frame);
    const int now = frame % static_cast<int>(kGivenFrames);
    show(cache, frame, hair);
    EXPECT_LE(drawnFrom(hair, shape(now)), kCacheBound);
    const bool begins = now == 0 || frame == last - 1;
    EXPECT_LE(movedFrom(hair, shape(begins ? now : now - 1)), kCacheBound);
  }
  show(cache, -1, hair);
  EXPECT_LE(drawnFrom(hair, shape(last)), kCacheBound);
}

TEST_P(GivenHair, FollowHairsAndTangentsFollow) {
  const std::vector<FollowHair> follows =
      valueOf(asset_.generateFollowHairs({.countPerGuide = 1, .maxRadius = 0.01f}));
  HairObject& hair = run_.add(asset_, {.followHairs = follows, .storeFollowHairs = true});
  const auto offsets = [&] {
    const std::vector<Float4> all = run_.positions(hair);
    std::vector<Float3> from;
    const size_t guides = asset_.positions.size();
    for (size_t i = 0; i < guides && all.size() == 2 * guides; ++i) {
      // Each follow hair has a guide of its own.
      const size_t guide = follows[i / kGivenVertices].guide;
      const Float4 &a = all[guide * kGivenVertices + i % kGivenVertices], &b = all[guides + i];
      from.push_back({b.x - a.x, b.y - a.y, b.z - a.z});
    }
    return from;
  };
  expectOk(hair.setPositions(shape(0)));
  run_.step();
  const std::vector<Float3> atFirst = offsets();
  ASSERT_EQ(atFirst.size(), asset_.positions.size());
  const std::vector<Float3> bent = shape(5);
  expectOk(hair.setPositions(bent));
  run_.step();
  const std::vector<Float3> later = offsets();
  const std::vector<Float4> tangents = run_.read(hair.buffers().tangents);
  double moved = 0, turned = 0;
  for (size_t i = 0; i < later.size(); ++i) {
    const Float3 &a = atFirst[i], &b = later[i];
    keepLargest(moved, std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z));
    const size_t v = i % kGivenVertices;
    const Float3 &from = bent[v > 0 ? i - 1 : i], &to = bent[v + 1 < kGivenVertices ? i + 1 : i];
    const double x = double{to.x} - from.x, y = double{to.y} - from.y, z = double{to.z} - from.z;
    const double length = std::hypot(x, y, z);
    const Float4& t = tangents[i];
    keepLargest(turned, std::hypot(t.x - x / length, t.y - y / length, t.z - z / length));
  }
  EXPECT_LT(moved, 1e-6) << "bones stand still, so a follow hair keeps its distance";
  EXPECT_LT(turned, 1e-5);
}

TEST_P(GivenHair, IsSeenWhereItIsFarFromItsBones) {
  HairObject& hair = run_.add(asset_);
  hair.material.fiberRadius = 2e-3f;
  const Float3 far = {40, 0, -30};
  expectOk(hair.setPositions(shape(1, far)));
  run_.step();
  const RenderedImage image = run_.render({far.x, far.y, far.z + 1}, 64);
  double covered = 0;
  for (const Float4& pixel : image.pixels) covered += static_cast<double>(pixel.w);
  EXPECT_GT(covered, 20);
}

TEST_P(GivenHair, GoesWithTheOriginAndTeleportsAndSurvivesLostFrames) {
  HairObject& hair = run_.add(asset_);
  hair.tracksMotion = true;
  expectOk(hair.setPositions(shape(1)));
  run_.step(0);
  EXPECT_EQ(drawnFrom(hair, shape(1)), 0) << "new hair in a frame of 0 s";
  run_.step();
  EXPECT_EQ(drawnFrom(hair, shape(1)), 0);
  // A frame that does not run.
  expectOk(hair.setPositions(shape(2)));
  PassList lost;
  expectOk(run_.scene.simulate(1.0f / 60, lost));
  run_.step();
  EXPECT_EQ(drawnFrom(hair, shape(2)), 0);
  EXPECT_EQ(movedFrom(hair, shape(1)), 0);
  expectOk(run_.scene.shiftOrigin({3, 0, -2}));
  run_.step(0);
  EXPECT_LT(drawnFrom(hair, shape(2, {-3, 0, 2})), 1e-6);
  expectOk(run_.scene.shiftOrigin({-3, 0, 2}));
  run_.step();
  EXPECT_LT(drawnFrom(hair, shape(2)), 1e-6);
  EXPECT_LT(movedFrom(hair, shape(2)), 1e-6) << "a shift is no motion";
  AffineTransform up;
  up.rows[1].w = 4;
  expectOk(run_.scene.teleport(run_.lastHair(), up));
  run_.step();
  EXPECT_LT(drawnFrom(hair, shape(2, {0, 4, 0})), 1e-6);
  expectOk(hair.setPositions({}));
  up.rows[1].w = 0;
  setBone(hair, up);
  run_.step();
  EXPECT_LT(drawnFrom(hair, shape(0)), 0.02) << "simulated again, from the bind pose";
  EXPECT_GT(drawnFrom(hair, shape(0)), 0);
}

TEST_P(GivenHair, WhatDoesNotFitIsRefused) {
  HairObject& hair = run_.add(asset_);
  std::vector<Float3> positions = shape(0);
  EXPECT_FALSE(hair.setPositions(std::span(positions).first(5)));
  positions[7].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(hair.setPositions(positions));
  positions[7].y = 2e6f;
  EXPECT_FALSE(hair.setPositions(positions));
  CachePlayer cache = player();
  EXPECT_FALSE(cache.show(std::numeric_limits<double>::infinity(), hair));
  HairObject& other = run_.add(wavyAsset(kGivenStrands, kGivenVertices + 1));
  EXPECT_FALSE(cache.show(0, other));
  EXPECT_FALSE(CachePlayer::open(path_, {.framesAhead = 0}));
}

TEST_P(GivenHair, AFrameThatIsBrokenIsAnErrorWhenItIsShown) {
  { const CachePlayer writes = player(); }
  {
    // The end of the last frame, before an index of 24 bytes a frame and a footer of 32.
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(-static_cast<std::streamoff>(kGivenFrames * 24 + 32 + 8), std::ios::end);
    file.write("damaged!", 8);
  }
  auto cache = required(CachePlayer::open(path_));
  HairObject& hair = run_.add(asset_);
  const int last = static_cast<int>(kGivenFrames) - 1;
  for (int round = 0; round < 2; ++round) {
    expectError(cache->show(last, hair), "checksum");
    show(*cache, last - 1, hair);
    EXPECT_LE(drawnFrom(hair, shape(last - 1)), kCacheBound);
    show(*cache, 1, hair);
    EXPECT_LE(drawnFrom(hair, shape(1)), kCacheBound);
  }
}

INSTANTIATE_TEST_SUITE_P(All, GivenHair, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
