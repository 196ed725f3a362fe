// Camera and clock of the viewer, the arrow of the wind, and picking of hair.
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <vector>

#include "hair_pull.h"
#include "interface/user_interface.h"
#include "stage/controls.h"
#include "stage/orbit_camera.h"
#include "stage/stage.h"

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

TEST(WindArrow, ItsTipSetsTheWindInThePicture) {
  const viewer::OrbitCamera camera = someCamera();
  viewer::WindowSize size;
  size.width = 640;
  size.height = 480;
  const Float3 before = {3, -1, 2};
  const viewer::WindArrow arrow = viewer::windArrowOf(camera, before, size);
  EXPECT_TRUE(arrow.isOnTip(arrow.tip.x, arrow.tip.y));
  EXPECT_FALSE(arrow.isOnTip(arrow.tip.x + 40, arrow.tip.y));
  const auto expectNear = [](const Float3& a, const Float3& b) {
    EXPECT_NEAR(a.x, b.x, 1e-4f);
    EXPECT_NEAR(a.y, b.y, 1e-4f);
    EXPECT_NEAR(a.z, b.z, 1e-4f);
  };
  // Where the tip is already, nothing changes.
  expectNear(viewer::windOfTip(camera, before, size, arrow.tip.x, arrow.tip.y), before);
  // At the base, the wind has no part in the picture.
  const Float3 calm = viewer::windOfTip(camera, {}, size, arrow.base.x + 0.5, arrow.base.y);
  expectNear(calm, {});
  // Far away, the wind is at its maximum.
  const Float3 storm = viewer::windOfTip(camera, {}, size, arrow.base.x + 1e4, arrow.base.y);
  expectNear(storm,
             {viewer::kMaxArrowWind * camera.right().x, viewer::kMaxArrowWind * camera.right().y,
              viewer::kMaxArrowWind * camera.right().z});
}

TEST(WindArrow, IsBelowWindowsAtTheRight) {
  viewer::UserInterface interface(1.5f);
  ImGui::GetIO().Fonts->Build();
  viewer::WindowSize size;
  size.width = size.pixelWidth = 960;
  size.height = size.pixelHeight = 640;
  size.interfaceScale = 1.5f;
  ImVec2 corner;
  for (int frame = 0; frame < 2; ++frame)
    interface.build(size, 0.01, [&] {
      viewer::placeAtRight(size, 380, 520);
      ImGui::Begin("window");
      corner = {ImGui::GetWindowPos().x + ImGui::GetWindowWidth(),
                ImGui::GetWindowPos().y + ImGui::GetWindowHeight()};
      ImGui::End();
    });
  const viewer::OrbitCamera camera = someCamera();
  const Float3 up = camera.up();
  const float most = viewer::kMaxArrowWind;
  const viewer::WindArrow arrow =
      viewer::windArrowOf(camera, {most * up.x, most * up.y, most * up.z}, size);
  EXPECT_GT(corner.x, arrow.base.x);
  EXPECT_LE(corner.y, arrow.tip.y - arrow.tipRadius + 1e-3f);
}

// The panel sets speed and horizontal direction of a wind that the arrow has made rise.
TEST(WindArrow, ThePanelKeepsTheSlopeOfTheWind) {
  const Float3 turned = viewer::turnedWind({3, 4, 0}, 10, 0);
  EXPECT_NEAR(turned.x, 0, 1e-6f);
  EXPECT_NEAR(turned.y, 8, 1e-5f);
  EXPECT_NEAR(turned.z, 6, 1e-5f);
  const Float3 first = viewer::turnedWind({}, 2, 1.5707963f);
  EXPECT_TRUE(std::abs(first.x - 2) < 1e-6f && first.y == 0 && std::abs(first.z) < 1e-6f);
}

// There are two strands of four vertices, one behind the other.
TEST(HairPull, TakesTheVertexUnderTheMouseThatIsInFront) {
  const viewer::OrbitCamera camera = someCamera();
  const pelage::View view = camera.view(640, 480);
  const Float3 target = camera.target(), back = camera.direction();
  std::vector<pelage::Float4> positions;
  for (const float away : {0.0f, -0.1f}) {
    for (int vertex = 0; vertex < 4; ++vertex)
      positions.push_back(
          {target.x + away * back.x, target.y + away * back.y, target.z + away * back.z, 0});
  }
  const auto near = sample::pickVertex(positions, 4, view, 322, 239);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->vertex, 2u);  // the first two are held by bones
  EXPECT_NEAR(near->depth, camera.distance(), 1e-4f);
  EXPECT_FALSE(sample::pickVertex(positions, 4, view, 400, 239));
  positions[2].x = positions[3].x = std::nanf("");
  const auto rear = sample::pickVertex(positions, 4, view, 322, 239);
  ASSERT_TRUE(rear);
  EXPECT_EQ(rear->vertex, 6u);
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
