// The scene benchmark computes from times and positions what its columns say.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "scenes/collider_depths.h"
#include "scenes/drawing_measure.h"
#include "scenes/drawing_rows.h"
#include "scenes/frame_figures.h"
#include "scenes/scene_rows.h"
#include "simulation/copy_reference.h"

namespace bench {
namespace {

using pelage::CapsuleCollider;
using pelage::Float3;

TEST(SceneRows, HaveDifferentNamesOfWhichNoneIsInAnotherOne) {
  for (const SceneSize size : {SceneSize::kFull, SceneSize::kSmall, SceneSize::kQuick}) {
    const std::vector<SceneRow> rows = sceneRows(size);
    for (const SceneRow& a : rows)
      for (const SceneRow& b : rows)
        EXPECT_EQ(a.name().find(b.name()) != std::string::npos, &a == &b) << b.name();
  }
}

TEST(SceneRows, HaveTheBaselineBeforeWhatIsComparedWithIt) {
  std::set<std::string> begun;
  for (const SceneRow& row : sceneRows(SceneSize::kFull)) {
    EXPECT_TRUE(row.solver != RowSolver::kBaseline || !begun.contains(row.scene)) << row.scene;
    begun.insert(row.scene);
  }
  EXPECT_EQ(begun.size(), 8u);
}

TEST(FrameFigures, CountPassesOfOneNameTogetherAndAFrameWithoutThemAsZero) {
  FrameFigures figures;
  for (int frame = 0; frame < 4; ++frame) {
    figures.beginFrame();
    figures.add("solve", PassGroup::kSimulation, 0.010);
    figures.add("solve", PassGroup::kSimulation, 0.020);
    if (frame == 3) figures.add("build", PassGroup::kSdf, 0.400);
  }
  ASSERT_EQ(figures.passes().size(), 2u);
  const PassFigure& solve = figures.passes()[0];
  const PassFigure& build = figures.passes()[1];
  EXPECT_EQ(solve.passes, 8u);
  EXPECT_NEAR(spreadOf(solve.us).median, 30, 1e-9);
  EXPECT_EQ(build.passes, 1u);
  ASSERT_EQ(build.us.size(), 4u);
  EXPECT_NEAR(spreadOf(build.us).mean, 100, 1e-9);
  EXPECT_NEAR(figures.of(PassGroup::kSimulation).mean, 30, 1e-9);
  EXPECT_NEAR(figures.of(PassGroup::kSdf).median, 0, 1e-9);
  EXPECT_NEAR(figures.of(PassGroup::kSdf).mean, 100, 1e-9);
  EXPECT_NEAR(figures.frame().mean, 130, 1e-9);
  EXPECT_TRUE(figures.isTimed());
}

TEST(FrameFigures, SumTheDrawingGroupsFrameByFrameAndLeaveTheMeshOut) {
  FrameFigures figures;
  for (int frame = 0; frame < 3; ++frame) {
    figures.beginFrame();
    figures.add("solve", PassGroup::kSimulation, 0.100);
    figures.add("mesh_pixel", PassGroup::kOpaque, 0.500);
    figures.add("splat", PassGroup::kShadow, 0.200);
    // The medians of the two add up to 20, that of the sums is 21.
    figures.add("depth", PassGroup::kDepth, frame == 0 ? 0.011 : 0.010);
    figures.add("build", PassGroup::kPicture, frame == 1 ? 0.011 : 0.010);
    if (frame == 2) figures.add("keep", PassGroup::kKept, 0.001);
  }
  EXPECT_NEAR(drawingTime(figures).median, 21, 1e-9);
  EXPECT_NEAR(drawingTime(figures).mean, 21, 1e-9);
  EXPECT_NEAR(figures.frame().median, 321, 1e-9);
  EXPECT_NEAR(figures.of(PassGroup::kOpaque).median, 500, 1e-9);
  EXPECT_TRUE(figures.has(PassGroup::kKept));
  EXPECT_FALSE(figures.has(PassGroup::kInterpolation));
}

TEST(DrawingRows, HaveNamesOfTheirOwnAndBeginWithThePictureAlone) {
  for (const SceneSize size : {SceneSize::kFull, SceneSize::kSmall, SceneSize::kQuick}) {
    std::set<std::string> names;
    for (const SceneRow& row : sceneRows(size)) names.insert(row.name());
    const std::vector<DrawingRow> rows = drawingRows(size);
    for (const DrawingRow& row : rows) EXPECT_TRUE(names.insert(row.name()).second) << row.name();
    ASSERT_EQ(rows.size(), size == SceneSize::kQuick ? 10u : 16u);
    EXPECT_EQ(rows[0].extra, DrawingExtra::kNone);
    EXPECT_EQ(rows[6].extra, DrawingExtra::kNone);
    EXPECT_EQ(rows[6].guides, 10 * rows[0].guides);
    EXPECT_GT(rows[8].distance, rows[0].distance);
    EXPECT_EQ(rows[8].guides, rows[0].guides);
    if (size != SceneSize::kQuick) {
      EXPECT_EQ(rows[13].characters, 12u);
      EXPECT_TRUE(rows[15].ratBoy);
    }
  }
}

/// A result that passes the smoke test: nothing else is drawn.
DrawingResult drawnAlone() {
  DrawingResult result;
  result.figures.beginFrame();
  for (const PassGroup group : {PassGroup::kSimulation, PassGroup::kSdf, PassGroup::kShadow,
                                PassGroup::kPicture, PassGroup::kOpaque})
    result.figures.add(passGroupName(group), group, 0.001);
  result.fragments = 1;
  result.meanLight = 0.5;
  return result;
}

TEST(CheckDrawing, RefusesMissingAndSuperfluousPassesAndPicturesWithoutHairOrNumbers) {
  EXPECT_TRUE(checkDrawing(drawnAlone()));
  DrawingResult depth = drawnAlone();
  depth.row.extra = DrawingExtra::kDepth;
  EXPECT_FALSE(checkDrawing(depth)) << "no depth";
  depth.figures.add("depth", PassGroup::kDepth, 0.001);
  EXPECT_TRUE(checkDrawing(depth));
  depth.row.extra = DrawingExtra::kNone;
  EXPECT_FALSE(checkDrawing(depth)) << "depth that nobody wants";
  DrawingResult bald = drawnAlone();
  bald.fragments = 0;
  EXPECT_FALSE(checkDrawing(bald));
  for (const double light : {0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    DrawingResult broken = drawnAlone();
    broken.meanLight = light;
    EXPECT_FALSE(checkDrawing(broken)) << light;
  }
}

TEST(CheckDrawing, WantsThePictureOfTheRowAloneBesideDepthAndAnotherOneInOtherLights) {
  std::vector<DrawingResult> results(2, drawnAlone());
  for (const bool same : {false, true}) {
    results[1].meanLight = same ? 0.5 : 0.6;
    for (const DrawingExtra extra :
         {DrawingExtra::kDepth, DrawingExtra::kMotion, DrawingExtra::kStereo}) {
      results[1].row.extra = extra;
      EXPECT_EQ(comparePictures(results).ok(), same);
    }
    results[1].row.extra = DrawingExtra::kEngineLights;
    EXPECT_EQ(comparePictures(results).ok(), !same);
    results[1].row.extra = DrawingExtra::kInterpolation;
    EXPECT_TRUE(comparePictures(results));
  }
}

TEST(PictureError, IsThePsnrOfBytes) {
  const sample::ByteImage black = {1, 2, {0, 0, 0, 0, 0, 0}}, one = {1, 2, {3, 0, 0, 0, 0, 0}};
  EXPECT_NEAR(sample::psnrOf(black, one), 20 * std::log10(255 / std::sqrt(9.0 / 6)), 1e-9);
  EXPECT_EQ(sample::psnrOf(one, one), std::numeric_limits<double>::infinity());
}

struct DriftingRow {
  int run = 0;
  CopyTimes copies;
};

/// Runs rows beside which the copy takes 100 us before and `after` us after.
pelage::Result<DriftingRow> steadiestOf(const std::vector<double>& after) {
  size_t runs = 0;
  return steadiest({.maxRuns = 4, .maxDrift = 0.05}, [&]() -> pelage::Result<DriftingRow> {
    if (runs == after.size()) return pelage::Error{pelage::ErrorCode::kDevice, "one too many"};
    DriftingRow row;
    row.copies = {100, after[runs], 1};
    row.run = static_cast<int>(runs++);
    return row;
  });
}

TEST(CopyTimes, ARowRunsAgainUntilTheCopyBesideItKeepsItsTime) {
  const auto steady = steadiestOf({104});
  ASSERT_TRUE(steady);
  EXPECT_EQ(steady->copies.runs, 1);
  const auto third = steadiestOf({120, 80, 97});
  ASSERT_TRUE(third);
  EXPECT_EQ(third->run, 2);
  EXPECT_EQ(third->copies.runs, 3);
  const auto none = steadiestOf({120, 90, 130, 125});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->run, 1) << "it drifted least";
  EXPECT_EQ(none->copies.runs, 4);
  const auto broken = steadiestOf({std::nan(""), std::nan(""), 106, 120});
  ASSERT_TRUE(broken);
  EXPECT_EQ(broken->run, 2);
  EXPECT_FALSE(steadiestOf({120, 90})) << "an error of a later run is one";
}

TEST(CopyTimes, WithoutTimestampsARowRunsOnce) {
  const auto row = steadiest({}, []() -> pelage::Result<DriftingRow> { return DriftingRow{}; });
  ASSERT_TRUE(row);
  EXPECT_EQ(row->copies.runs, 1);
}

TEST(FrameFigures, AreNotTimedWhereAPassHasNoTimestamp) {
  FrameFigures figures;
  figures.beginFrame();
  figures.add("solve", PassGroup::kSimulation, -1);
  EXPECT_EQ(figures.passes().size(), 1u);
  EXPECT_FALSE(figures.isTimed());
}

TEST(CapsuleDistance, IsThatOfTheNearestOfAllSpheresInIt) {
  const CapsuleCollider capsules[] = {
      {.head = {0, 0, 0}, .headRadius = 0.05f, .tail = {0.2f, 0.1f, 0}, .tailRadius = 0.09f},
      {.head = {0, 0, 0}, .headRadius = 0.05f, .tail = {0.2f, 0.1f, 0}, .tailRadius = 0.05f},
      {.head = {0, 0, 0}, .headRadius = 0.3f, .tail = {0.1f, 0, 0}, .tailRadius = 0.05f},
      {.head = {0.1f, 0, 0}, .headRadius = 0.1f, .tail = {0.1f, 0, 0}, .tailRadius = 0.1f}};
  for (const CapsuleCollider& capsule : capsules)
    for (int k = 0; k < 200; ++k) {
      const auto at = [&](double factor) {
        return static_cast<float>(0.4 * std::sin(factor * (k + 1)));
      };
      const Float3 point = {at(1.3), at(2.1), at(3.7)};
      double least = 1e9;
      for (int i = 0; i <= 20000; ++i) {
        const double t = i / 20000.0;
        const auto mix = [&](float a, float b) { return a + t * (static_cast<double>(b) - a); };
        const double x = point.x - mix(capsule.head.x, capsule.tail.x);
        const double y = point.y - mix(capsule.head.y, capsule.tail.y);
        const double z = point.z - mix(capsule.head.z, capsule.tail.z);
        const double radius = mix(capsule.headRadius, capsule.tailRadius);
        least = std::min(least, std::sqrt(x * x + y * y + z * z) - radius);
      }
      EXPECT_NEAR(capsuleDistance(capsule, point), least, 1e-6);
    }
}

TEST(DepthsInMesh, AreTheDistanceFromTheSurfaceInsideAndZeroOutside) {
  const auto box = pelage::reference::box({-1, -0.02f, -1}, {1, 0.02f, 1});
  const Float3 points[] = {{0, 0.015f, 0}, {0.3f, 0, 0.2f}, {0, 0.03f, 0}, {2, 0, 0}};
  const std::vector<double> depths = depthsInMesh(box, points);
  ASSERT_EQ(depths.size(), 4u);
  EXPECT_NEAR(depths[0], 0.005, 1e-7);
  EXPECT_NEAR(depths[1], 0.02, 1e-7);
  EXPECT_EQ(depths[2], 0);
  EXPECT_EQ(depths[3], 0);
}

}  // namespace
}  // namespace bench
