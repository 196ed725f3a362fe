// Camera and clock of the viewer, the arrow of the wind, and picking of hair.
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "hair_pull.h"
#include "interface/help.h"
#include "interface/user_interface.h"
#include "interface/window_layout.h"
#include "stage/controls.h"
#include "stage/orbit_camera.h"
#include "stage/stage.h"
#include "support/test_folder.h"

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

bool overlap(const viewer::WindowArea& a, const viewer::WindowArea& b) {
  return a.corner.x < b.corner.x + b.size.x && b.corner.x < a.corner.x + a.size.x &&
         a.corner.y < b.corner.y + b.size.y && b.corner.y < a.corner.y + a.size.y;
}

TEST(WindowLayout, CoversNeitherPanelNorArrowNorAnotherWindow) {
  const viewer::OrbitCamera camera = someCamera();
  const Float3 up = camera.up();
  const float most = viewer::kMaxArrowWind;
  for (const auto& [width, height, scale] : {std::tuple(960u, 640u, 1.0f),
                                             {960u, 640u, 1.5f},
                                             {1280u, 800u, 1.0f},
                                             {1600u, 1000u, 1.0f},
                                             {2560u, 1440u, 2.0f}}) {
    viewer::WindowSize size;
    size.width = width;
    size.height = height;
    size.interfaceScale = scale;
    const viewer::WindArrow arrow =
        viewer::windArrowOf(camera, {most * up.x, most * up.y, most * up.z}, size);
    const std::vector<float> heights = {520, 460, 560, 360};
    for (size_t count = 1; count <= heights.size(); ++count) {
      const auto areas = viewer::windowAreas(size, std::span(heights).first(count));
      ASSERT_EQ(areas.size(), count);
      for (size_t i = 0; i < count; ++i) {
        EXPECT_GT(areas[i].corner.x, viewer::kPanelWidth * scale);
        EXPECT_LT(areas[i].corner.x + areas[i].size.x, static_cast<float>(width));
        EXPECT_LE(areas[i].corner.y + areas[i].size.y, arrow.tip.y - arrow.tipRadius + 1e-3f);
        for (size_t k = 0; k < i; ++k) EXPECT_FALSE(overlap(areas[i], areas[k])) << width;
      }
    }
  }
}

// A user may move a window, until another one opens.
TEST(WindowLayout, MakesRoomForAWindowThatOpens) {
  viewer::UserInterface interface(1);
  ImGui::GetIO().Fonts->Build();
  viewer::WindowSize size;
  size.width = size.pixelWidth = 960;
  size.height = size.pixelHeight = 640;
  viewer::WindowLayout layout;
  ImVec2 corner;
  float height = 0;
  const auto build = [&](bool other, bool moves = false) {
    interface.build(size, 0.01, [&] {
      layout.begin(size, {true, other, false, false});
      layout.place(viewer::SideWindow::kSettings);
      if (moves) ImGui::SetNextWindowPos({300, 100});
      ImGui::Begin("settings");
      corner = ImGui::GetWindowPos();
      height = ImGui::GetWindowHeight();
      ImGui::End();
    });
  };
  build(false);
  const float first = corner.x, alone = height;
  build(false, true);
  build(false);
  EXPECT_EQ(corner.x, 300);
  build(true);
  EXPECT_EQ(corner.x, first);
  EXPECT_LT(height, alone / 2 + 1);
}

TEST(Interface, HasTheScalableFontOfThePackages) {
  viewer::UserInterface interface(2);
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  fonts.Build();
  EXPECT_EQ(fonts.Fonts[0]->FontSize, 28);
  EXPECT_EQ(std::string_view(fonts.ConfigData[0].Name).substr(0, 10), "DejaVuSans");
}

TEST(Help, HasTheLinesOfTheDocumentation) {
  const std::string page =
      pelage::test::textOf(std::filesystem::path(PELAGE_SOURCE_DIR) / "docs/viewer.md");
  for (const viewer::HelpLine& line : viewer::helpLines()) {
    std::string expected = std::string("\n    ") + line.keys;
    expected.resize(std::max(expected.size() + 1, size_t{1 + 4 + 43}), ' ');
    EXPECT_NE(page.find(expected + line.action + "\n"), std::string::npos) << line.keys;
  }
}

TEST(StageControls, KeepsCamerasOnKeys) {
  viewer::Stage stage;
  viewer::StageControls controls;
  const viewer::WindowSize size;
  const auto key = [&](viewer::Key code, bool down) {
    controls.take(viewer::KeyPressed{code, down}, size, stage);
  };
  const auto keep = [&](viewer::Key code) {
    key(viewer::kKeyLeftControl, true);
    key(code, true);
    key(viewer::kKeyLeftControl, false);
  };
  stage.camera = someCamera();
  keep('2');
  stage.camera.orbit(1, 0.1f);
  keep('9');
  const Float3 second = stage.camera.eye();
  key('2', true);
  EXPECT_EQ(stage.camera.eye(), someCamera().eye());
  key('1', true);  // nothing was kept
  EXPECT_EQ(stage.camera.eye(), someCamera().eye());
  key('9', true);
  EXPECT_EQ(stage.camera.eye(), second);
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
