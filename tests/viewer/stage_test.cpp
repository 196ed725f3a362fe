// Camera and clock of the viewer.
#include <gtest/gtest.h>

#include <cmath>

#include "stage/orbit_camera.h"
#include "stage/play_clock.h"

namespace {

using pelage::Float3;
using viewer::PlayClock;

float distance(const Float3& a, const Float3& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

viewer::OrbitCamera someCamera() {
  sample::Camera from;
  from.eye = {1, 2, 3};
  from.target = {0.5f, 1, -1};
  from.verticalFov = 0.5f;
  from.near = 0.1f;
  from.far = 20;
  viewer::OrbitCamera camera;
  camera.frame(from);
  return camera;
}

TEST(OrbitCamera, StandsWhereItWasPut) {
  const viewer::OrbitCamera camera = someCamera();
  EXPECT_LT(distance(camera.eye(), {1, 2, 3}), 1e-5f);
  EXPECT_LT(distance(camera.target(), {0.5f, 1, -1}), 1e-6f);
}

TEST(OrbitCamera, KeepsItsDistanceWhileItTurns) {
  viewer::OrbitCamera camera = someCamera();
  const float before = distance(camera.eye(), camera.target());
  for (int i = 0; i < 100; ++i) {
    camera.orbit(0.7f, i < 50 ? 0.3f : -0.9f);
    EXPECT_NEAR(distance(camera.eye(), camera.target()), before, 1e-4f);
    EXPECT_TRUE(std::isfinite(camera.view(640, 480).worldToClip.rows[0].x));
  }
}

TEST(OrbitCamera, TurningBackComesBack) {
  viewer::OrbitCamera camera = someCamera();
  camera.orbit(0.4f, -0.2f);
  camera.orbit(-0.4f, 0.2f);
  EXPECT_LT(distance(camera.eye(), {1, 2, 3}), 1e-5f);
}

TEST(OrbitCamera, ComesNearerByTheFactor) {
  viewer::OrbitCamera camera = someCamera();
  const float before = camera.distance();
  camera.zoom(2);
  EXPECT_NEAR(camera.distance(), before / 2, 1e-5f);
  camera.zoom(std::nanf(""));
  EXPECT_NEAR(camera.distance(), before / 2, 1e-5f);
  for (int i = 0; i < 200; ++i) camera.zoom(2);
  EXPECT_GT(camera.distance(), 0);
}

// A point under a pixel projects onto that pixel.
TEST(OrbitCamera, PointsUnderAPixelProjectOntoIt) {
  const viewer::OrbitCamera camera = someCamera();
  constexpr uint32_t kWidth = 640, kHeight = 480;
  const pelage::View view = camera.view(kWidth, kHeight);
  const Float3 plane = {0.2f, 1.3f, 0.4f};
  for (const float x : {0.1f, 0.5f, 0.8f}) {
    for (const float y : {0.2f, 0.5f, 0.95f}) {
      const Float3 p = camera.pointAt(x, y, float{kWidth} / kHeight, plane);
      float clip[4];
      for (int i = 0; i < 4; ++i) {
        const pelage::Float4& row = view.worldToClip.rows[i];
        clip[i] = row.x * p.x + row.y * p.y + row.z * p.z + row.w;
      }
      EXPECT_NEAR(clip[0] / clip[3], 2 * x - 1, 1e-4f);
      EXPECT_NEAR(clip[1] / clip[3], 1 - 2 * y, 1e-4f);
    }
  }
}

TEST(PlayClock, FixedFramesTakeASixtiethWhateverTheyTook) {
  PlayClock clock;
  clock.fixed = true;
  EXPECT_EQ(clock.advance(5, {}), PlayClock::kStep);
  EXPECT_EQ(clock.advance(0, {}), PlayClock::kStep);
  EXPECT_EQ(clock.time, 2 * PlayClock::kStep);
}

TEST(PlayClock, RealFramesTakeTheirTimeUpToTheLongest) {
  PlayClock clock;
  clock.speed = 0.5;
  EXPECT_EQ(clock.advance(0.02, {}), 0.01);
  EXPECT_EQ(clock.advance(100, {}), PlayClock::kLongest);
  EXPECT_EQ(clock.advance(-1, {}), 0);
}

TEST(PlayClock, NothingMovesWhilePausedButForASingleStep) {
  PlayClock clock;
  clock.playing = false;
  EXPECT_EQ(clock.advance(0.02, {}), 0);
  clock.steps = true;
  EXPECT_EQ(clock.advance(0.02, {}), PlayClock::kStep);
  EXPECT_EQ(clock.advance(0.02, {}), 0);
  EXPECT_EQ(clock.time, PlayClock::kStep);
}

TEST(PlayClock, MotionsStartOverOrEnd) {
  PlayClock clock;
  clock.fixed = true;
  clock.time = 2.99;
  clock.advance(0, {1, 3});
  EXPECT_NEAR(clock.time, 1 + 2.99 + PlayClock::kStep - 3, 1e-12);
  clock.loops = false;
  clock.time = 2.99;
  EXPECT_NEAR(clock.advance(0, {1, 3}), 0.01, 1e-12);
  EXPECT_EQ(clock.time, 3);
  EXPECT_FALSE(clock.playing);
}

}  // namespace
