// From curves as a file has them to curves that everything else can take.
#include "pelage/authoring/hair_curves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pelage/hair_asset.h"
#include "support/errors.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;

// `count` straight curves of 3 vertices; curve i is i + 1 long and has i in all its arrays.
HairCurves straightCurves(uint32_t count) {
  HairCurves curves;
  for (uint32_t i = 0; i < count; ++i) {
    const auto value = static_cast<float>(i);
    curves.vertexCounts.push_back(3);
    for (uint32_t k = 0; k < 3; ++k) {
      curves.positions.push_back({value, 0.5f * static_cast<float>(k) * (value + 1), 0});
      curves.radii.push_back(value);
      curves.colors.push_back({value, 0, 0, 1});
      curves.vertexUv.push_back({value, 0.25f});
      curves.inverseMasses.push_back(value);
    }
    curves.strandUv.push_back({value, 0.75f});
  }
  return curves;
}

TEST(CurveImport, ScalesAndTurnsTheUpAxisWithoutMirroring) {
  const auto moved = [](const CurveImportDef& def) {
    HairCurves curves;
    curves.vertexCounts = {2};
    curves.positions = {{1, 2, 3}, {0, 0, 0}};
    curves.radii = {1, 1};
    EXPECT_TRUE(prepareCurves(curves, def));
    EXPECT_EQ(curves.radii[0], def.scale);
    return curves.positions[0];
  };
  EXPECT_EQ(moved({}), (Float3{1, 2, 3}));
  EXPECT_EQ(moved({.scale = 0.5f}), (Float3{0.5f, 1, 1.5f}));
  EXPECT_EQ(moved({.upAxis = UpAxis::kZ}), (Float3{1, 3, -2}));
  EXPECT_EQ(moved({.upAxis = UpAxis::kX}), (Float3{-2, 1, 3}));
  EXPECT_EQ(moved({.upAxis = UpAxis::kZ, .invertZ = true}), (Float3{1, 3, 2}));
}

TEST(CurveImport, InvertsVOfAllUv) {
  HairCurves curves = straightCurves(1);
  ASSERT_TRUE(prepareCurves(curves, {.invertV = true}));
  EXPECT_EQ(curves.strandUv[0], (Float2{0, 0.25f}));
  EXPECT_EQ(curves.vertexUv[2], (Float2{0, 0.75f}));
}

TEST(CurveImport, CountsWhatItDropsAndKeepsTheArraysTogether) {
  HairCurves curves = straightCurves(6);
  curves.positions[0].x = kNan;  // curve 0 keeps two vertices
  curves.positions[3].y = kNan;  // curve 1 keeps one
  curves.positions[5].z = 2e6f;
  curves.positions[7] = curves.positions[8] = curves.positions[6];  // curve 2 has no length
  curves.vertexCounts[3] = 1;  // curve 3 is one vertex; its others go to curve 4
  curves.vertexCounts[4] = 5;
  curves.radii[15] = -1;
  curves.colors[16].y = kNan;
  curves.strandUv[5].x = -std::numeric_limits<float>::infinity();
  CurveImportReport report;
  ASSERT_TRUE(prepareCurves(curves, {.minCurveLength = 1.5f}, &report));
  EXPECT_EQ(report.curvesRead, 6u);
  EXPECT_EQ(report.verticesRead, 18u);
  EXPECT_EQ(report.droppedSingleVertex, 1u);
  EXPECT_EQ(report.droppedUnusable, 1u);
  EXPECT_EQ(report.droppedNoLength, 1u);
  EXPECT_EQ(report.droppedShort, 1u);  // curve 0 is 0.5 long
  EXPECT_EQ(report.removedVertices, 3u);
  EXPECT_EQ(report.repairedValues, 3u);
  EXPECT_EQ(report.curvesKept, 2u);
  EXPECT_EQ(report.curvesKept + report.curvesDropped(), report.curvesRead);
  EXPECT_EQ(curves.vertexCounts, (std::vector<uint32_t>{5, 3}));
  EXPECT_EQ(curves.positions[5].x, 5);
  EXPECT_EQ(curves.radii, (std::vector<float>{3, 3, 4, 4, 4, 0, 5, 5}));
  EXPECT_EQ(curves.strandUv[1], (Float2{0, 0.75f}));
  EXPECT_TRUE(validate(curves));
  EXPECT_DOUBLE_EQ(report.minLength, 6);
  EXPECT_DOUBLE_EQ(report.maxLength, report.meanLength * 2 - report.minLength);
}

TEST(CurveImport, ShufflesWholeCurvesTheSameWayForASeed) {
  const auto shuffled = [](uint64_t seed) {
    HairCurves curves = straightCurves(1000);
    EXPECT_TRUE(prepareCurves(curves, {.randomizeStrands = true, .seed = seed}));
    return curves;
  };
  const HairCurves curves = shuffled(5);
  EXPECT_EQ(curves.strandUv, shuffled(5).strandUv);
  EXPECT_NE(curves.strandUv, shuffled(6).strandUv);
  double sum = 0;
  std::vector<float> seen;
  for (uint32_t i = 0; i < 1000; ++i) {
    const float id = curves.strandUv[i].x;
    seen.push_back(id);
    for (uint32_t k = 3 * i; k < 3 * i + 3; ++k) {
      EXPECT_EQ(curves.positions[k].x, id);
      EXPECT_EQ(curves.radii[k], id);
      EXPECT_EQ(curves.inverseMasses[k], id);
      EXPECT_EQ(curves.vertexUv[k].x, id);
      EXPECT_EQ(curves.colors[k].x, id);
    }
    if (i < 200) sum += double{id};
  }
  // The mean of 200 of 0..999 drawn at random: 499.5 with a deviation of 18.
  EXPECT_NEAR(sum / 200, 499.5, 4 * 18);
  std::sort(seen.begin(), seen.end());
  for (uint32_t i = 0; i < 1000; ++i) EXPECT_EQ(seen[i], static_cast<float>(i));
}

TEST(CurveImport, RefusesValuesOutOfRangeAndCurvesOfWhichNothingIsLeft) {
  for (const CurveImportDef& def : {CurveImportDef{.scale = 0},
                                    {.scale = kNan},
                                    {.scale = -1},
                                    {.minCurveLength = -1},
                                    {.minCurveLength = kNan}}) {
    HairCurves curves = straightCurves(2);
    EXPECT_FALSE(prepareCurves(curves, def));
  }
  HairCurves tiny = straightCurves(2);
  expectError(prepareCurves(tiny, {.scale = 1e-6f, .minCurveLength = 0.1f}),
              "2 shorter than 0.1 m");
  HairCurves torn = straightCurves(2);
  torn.radii.pop_back();
  EXPECT_FALSE(prepareCurves(torn, {}));
  torn = straightCurves(2);
  torn.vertexCounts[0] = 0xFFFFFFFFu;
  EXPECT_FALSE(prepareCurves(torn, {}));
}

}  // namespace
}  // namespace pelage
