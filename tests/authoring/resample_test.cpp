// Resampling of curves: where the vertices are, and whether the reported deviation is true.
#include "pelage/authoring/hair_curves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/random.h"
#include "polyline.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using detail::Vector;
using test::expectError;
using test::expectOk;
using test::kNan;
using test::required;
using test::valueOf;

constexpr VertexPlacement kBoth[] = {VertexPlacement::kEven, VertexPlacement::kFitted};

void addCurve(HairCurves& curves, const std::vector<Float3>& points) {
  curves.vertexCounts.push_back(static_cast<uint32_t>(points.size()));
  curves.positions.insert(curves.positions.end(), points.begin(), points.end());
}

// Wavy hair of random lengths, with segments of all sizes; some vertices are repeated.
HairCurves wavyCurves(uint32_t count = 40) {
  HairCurves curves;
  for (uint32_t c = 0; c < count; ++c) {
    Random random(7, c);
    std::vector<Float3> points;
    const float size = 0.02f + 0.2f * random.uniform(), bend = 4 + 20 * random.uniform();
    const uint32_t vertices = 2 + random.below(60);
    float t = 0;
    for (uint32_t v = 0; v < vertices; ++v) {
      points.push_back({0.01f * static_cast<float>(c) + 0.1f * size * std::sin(bend * t),
                        size * t - 0.1f * size * t * t, 0.07f * size * std::cos(1.3f * bend * t)});
      if (random.below(8) != 0) t += random.uniform() / static_cast<float>(vertices);
    }
    points.push_back({points[0].x, points[0].y + size, 0.0f});
    addCurve(curves, points);
  }
  return curves;
}

std::vector<Vector> pointsOf(const HairCurves& curves, uint32_t curve) {
  size_t first = 0;
  for (uint32_t c = 0; c < curve; ++c) first += curves.vertexCounts[c];
  std::vector<Vector> points;
  for (uint32_t v = 0; v < curves.vertexCounts[curve]; ++v)
    points.push_back(detail::vectorOf(curves.positions[first + v]));
  return points;
}

std::vector<Vector> pointsOf(const HairAsset& asset, uint32_t strand) {
  std::vector<Vector> points;
  for (uint32_t v = 0; v < asset.verticesPerStrand; ++v)
    points.push_back(detail::vectorOf(asset.positions[strand * asset.verticesPerStrand + v]));
  return points;
}

double distanceTo(const Vector& p, const std::vector<Vector>& line) {
  double squared = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i + 1 < line.size(); ++i)
    test::keepSmallest(squared, detail::squaredDistance(p, line[i], line[i + 1]));
  return std::sqrt(squared);
}

// Hausdorff distance by brute force: at most half a sample's width too small.
double sampledDistance(const std::vector<Vector>& a, const std::vector<Vector>& b, int samples) {
  double largest = 0;
  for (int direction = 0; direction < 2; ++direction) {
    const std::vector<Vector>& from = direction == 0 ? a : b;
    const std::vector<Vector>& to = direction == 0 ? b : a;
    for (size_t i = 0; i + 1 < from.size(); ++i)
      for (int k = 0; k <= samples; ++k)
        test::keepLargest(largest,
                          distanceTo(detail::lerp(from[i], from[i + 1], double(k) / samples), to));
  }
  return largest;
}

double lengthOf(const std::vector<Vector>& points) { return detail::arcLengths(points).back(); }

ResampleResult resample(const HairCurves& curves, const ResampleDef& def) {
  return valueOf(resampleCurves(curves, def));
}

void expectResamplingRefused(const HairCurves& curves, const ResampleDef& def, const char* text) {
  expectError(resampleCurves(curves, def), ErrorCode::kInvalidArgument, text);
}

TEST(Resample, PutsVerticesOntoTheCurveAndKeepsItsEnds) {
  const HairCurves curves = wavyCurves();
  for (const VertexPlacement placement : kBoth)
    for (const uint32_t count : {2u, 3u, 16u, 61u}) {
      const HairAsset asset =
          resample(curves, {.verticesPerStrand = count, .placement = placement}).asset;
      ASSERT_EQ(asset.strandCount, curves.curveCount());
      ASSERT_EQ(asset.verticesPerStrand, count);
      for (uint32_t s = 0; s < asset.strandCount; ++s) {
        const std::vector<Vector> curve = pointsOf(curves, s), strand = pointsOf(asset, s);
        EXPECT_EQ(length(strand.front() - curve.front()), 0);
        EXPECT_EQ(length(strand.back() - curve.back()), 0);
        for (const Vector& p : strand) EXPECT_LT(distanceTo(p, curve), 5e-8);
      }
    }
}

TEST(Resample, EvenVerticesDivideTheArcLengthEvenly) {
  // A quarter of the way along an L of two sides is the middle of the first side.
  HairCurves curves;
  addCurve(curves, {{0, 0, 0}, {0, 0.1f, 0}, {0, 0.1f, 0}, {0, 0.5f, 0}, {0.5f, 0.5f, 0}});
  const HairAsset asset = resample(curves, {.verticesPerStrand = 5}).asset;
  const Float3 expected[] = {
      {0, 0, 0}, {0, 0.25f, 0}, {0, 0.5f, 0}, {0.25f, 0.5f, 0}, {0.5f, 0.5f, 0}};
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_NEAR(asset.positions[v].x, expected[v].x, 1e-7f);
    EXPECT_NEAR(asset.positions[v].y, expected[v].y, 1e-7f);
  }
}

TEST(Resample, FittedSegmentsStayWithinTheirLimits) {
  const HairCurves curves = wavyCurves();
  const uint32_t count = 12;
  const HairAsset asset =
      resample(curves, {.verticesPerStrand = count, .placement = VertexPlacement::kFitted}).asset;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const std::vector<Vector> strand = pointsOf(asset, s);
    const double even = lengthOf(pointsOf(curves, s)) / (count - 1);
    // A chord is shorter than its arc; half a candidate's width is what a corner moves it.
    EXPECT_LE(length(strand[1] - strand[0]), even * 1.05);
    for (uint32_t v = 0; v + 1 < count; ++v)
      EXPECT_LE(length(strand[v + 1] - strand[v]), even * 2.1);
  }
}

TEST(Resample, FittingAStraightHairIsEven) {
  HairCurves curves;
  addCurve(curves, {{0, 0, 0}, {0, 0.03f, 0}, {0, 0.12f, 0}});
  const HairAsset asset =
      resample(curves, {.verticesPerStrand = 7, .placement = VertexPlacement::kFitted}).asset;
  // To half a candidate, as the curve's own vertices are candidates.
  for (uint32_t v = 0; v < 7; ++v)
    EXPECT_NEAR(asset.positions[v].y, 0.02f * static_cast<float>(v), 0.02f / 24 + 1e-6f);
}

TEST(Resample, FittingDeviatesLessThanEvenVertices) {
  const HairCurves curves = wavyCurves();
  const ResampleReport even = resample(curves, {.verticesPerStrand = 12}).report;
  const ResampleReport fitted =
      resample(curves, {.verticesPerStrand = 12, .placement = VertexPlacement::kFitted}).report;
  EXPECT_LT(fitted.maxDeviation, 0.8f * even.maxDeviation);
  EXPECT_LT(fitted.meanDeviation, 0.8f * even.meanDeviation);
}

TEST(Resample, ReportsTheDistanceThatDenseSamplingFinds) {
  const HairCurves curves = wavyCurves();
  for (const VertexPlacement placement : kBoth) {
    const ResampleResult result =
        resample(curves, {.verticesPerStrand = 9, .placement = placement});
    double largest = 0, sum = 0, change = 0;
    uint32_t worst = 0;
    for (uint32_t s = 0; s < curves.curveCount(); ++s) {
      const std::vector<Vector> curve = pointsOf(curves, s), strand = pointsOf(result.asset, s);
      const double distance = sampledDistance(curve, strand, 24);
      if (distance > largest) worst = s;
      test::keepLargest(largest, distance);
      sum += distance;
      test::keepLargest(change, std::abs(lengthOf(strand) / lengthOf(curve) - 1));
    }
    // Samples are at most 0.25 m / 24 apart, but next to the largest distance much less is missed.
    EXPECT_GE(result.report.maxDeviation, largest * (1 - 1e-6));
    EXPECT_LE(result.report.maxDeviation, largest * 1.01);
    EXPECT_NEAR(result.report.meanDeviation, sum / curves.curveCount(), 0.01 * largest);
    EXPECT_EQ(result.report.worstCurve, worst);
    EXPECT_NEAR(result.report.maxLengthChange, change, 1e-5);
    EXPECT_EQ(result.report.strands, curves.curveCount());
  }
}

TEST(Resample, MeasuresBothWaysAndInsideOfSegments) {
  // The chord of a hairpin is near the curve, but the curve's bend is 0.1 from the chord.
  const std::vector<Vector> pin = {{0, 0, 0}, {0.1, 0.001, 0}, {0, 0.002, 0}};
  const std::vector<Vector> chord = {{0, 0, 0}, {0, 0.002, 0}};
  EXPECT_NEAR(detail::hausdorffDistance(pin, chord), 0.1, 1e-9);
  EXPECT_NEAR(detail::hausdorffDistance(chord, pin), 0.1, 1e-9);
  // The middle of a base is farthest from the roof over it, in the interior of a segment.
  const std::vector<Vector> base = {{-1, 0, 0}, {1, 0, 0}};
  const std::vector<Vector> roof = {{-1, 0, 0}, {-1, 3, 0}, {1, 3, 0}, {1, 0, 0}};
  const detail::PolylineTree tree(roof);
  EXPECT_NEAR(detail::maxDistance(base, tree, 1e-9), 1.0, 1e-9);
  EXPECT_NEAR(detail::hausdorffDistance(base, roof), 3.0, 1e-9);
}

TEST(Resample, ATreeFindsWhatLookingAtEverySegmentFinds) {
  Random random(3);
  std::vector<Vector> line;
  for (int i = 0; i < 500; ++i)
    line.push_back({random.uniformDouble(), random.uniformDouble(), random.uniformDouble()});
  const detail::PolylineTree tree(line);
  size_t hint = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector p = {2 * random.uniformDouble(), random.uniformDouble(), random.uniformDouble()};
    EXPECT_NEAR(std::sqrt(tree.squaredRange(p, p, hint)), distanceTo(p, line), 1e-14);
  }
}

TEST(Resample, AnErrorBoundHoldsWithTheFewestVertices) {
  const HairCurves curves = wavyCurves(25);
  for (const VertexPlacement placement : kBoth) {
    const float bound = 0.0004f;
    const ResampleReport report =
        resample(curves, {.errorBound = bound, .placement = placement}).report;
    EXPECT_LE(report.maxDeviation, bound);
    ASSERT_GT(report.verticesPerStrand, 3u);
    for (uint32_t count = 2; count < report.verticesPerStrand; ++count)
      EXPECT_GT(resample(curves, {.verticesPerStrand = count, .placement = placement})
                    .report.maxDeviation,
                bound);
  }
}

TEST(Resample, ABoundOutOfReachSaysWhatIsReached) {
  // 400 teeth need more than 256 vertices.
  HairCurves curves;
  std::vector<Float3> teeth;
  for (uint32_t i = 0; i <= 400; ++i)
    teeth.push_back({i % 2 == 0 ? 0.0f : 0.01f, 0.001f * static_cast<float>(i), 0});
  addCurve(curves, {{0, 0, 0}, {0, 1, 0}});
  addCurve(curves, teeth);
  expectResamplingRefused(curves, {.errorBound = 1e-4f}, "256, the most there can be, reach 0.00");
  expectResamplingRefused(curves, {.errorBound = 1e-4f}, "curve 1");
}

TEST(Resample, CarriesAttributesAlongTheCurve) {
  HairCurves curves;
  addCurve(curves, {{0, 0, 0}, {0, 1, 0}});
  addCurve(curves, {{1, 0, 0}, {1, 1, 0}, {1, 3, 0}});
  curves.radii = {1e-4f, 1e-4f, 3e-4f, 3e-4f, 0.0f};
  curves.colors = {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  curves.vertexUv = {{0, 0}, {1, 2}, {0, 0}, {0, 1}, {0, 3}};
  curves.strandUv = {{0.25f, 0.5f}, {0.75f, 1}};
  curves.inverseMasses = {0, 1, 0, 0, 2};
  const ResampleResult result = resample(curves, {.verticesPerStrand = 7, .unitRadius = 5e-5f});
  const HairAsset& asset = result.asset;
  EXPECT_EQ(asset.strandUv, curves.strandUv);
  EXPECT_NEAR(asset.vertexColor[3].x, 0.5f, 1e-6f);
  EXPECT_NEAR(asset.vertexUv[3].y, 1.0f, 1e-6f);
  EXPECT_NEAR(asset.vertexUv[7 + 4].y, 2.0f, 1e-6f);
  EXPECT_NEAR(asset.vertexColor[7 + 4].z, 0.5f, 1e-6f);
  // Curve 1: 3e-4 over 1 m, then 3e-4 to 0 over 2 m. Both: 1e-4 over 1 m and 2e-4 over 3 m.
  EXPECT_NEAR(result.report.fiberRadius, 1.75e-4f, 1e-9f);
  ASSERT_EQ(asset.strandThickness.size(), 2u);
  EXPECT_NEAR(asset.strandThickness[0], 2, 1e-6f);
  EXPECT_NEAR(asset.strandThickness[1], 4, 1e-6f);
  EXPECT_NEAR(asset.positions[3].w, 0.5f, 1e-6f);
  // Between two kinematic vertices all is kinematic.
  EXPECT_EQ(asset.positions[7 + 2].w, 0);
  EXPECT_NEAR(asset.positions[7 + 4].w, 1.0f, 1e-6f);
  HairAsset processed = asset;
  expectOk(processed.process());
}

TEST(Resample, HoldsTheRootAndOnRequestTheTip) {
  HairCurves curves = wavyCurves(3);
  for (const bool both : {false, true}) {
    const HairAsset asset =
        resample(curves, {.verticesPerStrand = 6, .bothEndsImmovable = both}).asset;
    for (size_t v = 0; v < asset.positions.size(); ++v)
      EXPECT_EQ(asset.positions[v].w, v % 6 < 2 || (both && v % 6 > 3) ? 0 : 1);
  }
}

TEST(Resample, KeepsCurvesWithoutLengthAndCountsThem) {
  HairCurves curves;
  addCurve(curves, {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}});
  addCurve(curves, {{0, 0, 0}, {0, 1e-30f, 0}});
  addCurve(curves, {{-1e6f, 1e6f, 0}, {1e6f, 1e6f, 0}, {1e6f, -1e6f, 1e6f}});
  for (const VertexPlacement placement : kBoth) {
    ResampleResult result = resample(curves, {.verticesPerStrand = 9, .placement = placement});
    EXPECT_EQ(result.report.zeroLengthCurves, 1u);
    for (uint32_t v = 0; v < 9; ++v) EXPECT_EQ(result.asset.positions[v].z, 3);
    expectOk(result.asset.process());
    EXPECT_TRUE(std::isfinite(result.report.maxDeviation));
    EXPECT_TRUE(std::isfinite(result.report.maxLengthChange));
  }
}

TEST(Resample, RefusesWhatCannotBeAStrand) {
  const HairCurves good = wavyCurves(3);
  expectResamplingRefused({}, {}, "no curves");
  expectResamplingRefused(good, {.verticesPerStrand = 1}, "vertices per strand are 1");
  expectResamplingRefused(good, {.verticesPerStrand = 257}, "vertices per strand are 257");
  expectResamplingRefused(good, {.errorBound = -1}, "error bound is -1");
  expectResamplingRefused(good, {.errorBound = kNan}, "error bound is nan");
  expectResamplingRefused(good, {.unitRadius = 0}, "radius for a thickness of 1 is 0");
  HairCurves bad = good;
  bad.positions[4].y = kNan;
  expectResamplingRefused(bad, {}, "curve 0");
  bad = good;
  addCurve(bad, {{0, 0, 0}});
  expectResamplingRefused(bad, {}, "curve 3 has 1 vertices");
  bad = good;
  bad.radii.assign(bad.positions.size(), 1e-4f);
  bad.radii[1] = -1;
  expectResamplingRefused(bad, {}, "radius at vertex 1 of curve 0");
  bad = good;
  bad.inverseMasses.assign(bad.positions.size(), -1.0f);
  expectResamplingRefused(bad, {}, "inverse mass of vertex 0");
}

TEST(Resample, TellsItsProgressToTheEnd) {
  uint64_t last = 0, end = 1;
  bool ascends = true;
  const Result<ResampleResult> result =
      resampleCurves(wavyCurves(5), {.errorBound = 0.001f}, [&](uint64_t done, uint64_t total) {
        ascends = ascends && done >= last;
        last = done;
        end = total;
      });
  ASSERT_TRUE(result);
  EXPECT_TRUE(ascends);
  EXPECT_EQ(last, end);
}

TEST(Resample, TheMohawkKeepsItsShape) {
  const auto path = std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy/Ratboy_mohawk.tfx";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const Result<HairAsset> mohawk = required(loadTfx(path));
  HairCurves curves;
  for (uint32_t s = 0; s < mohawk->strandCount; s += 4) {
    curves.vertexCounts.push_back(mohawk->verticesPerStrand);
    for (uint32_t v = 0; v < mohawk->verticesPerStrand; ++v) {
      const Float4& p = mohawk->positions[s * mohawk->verticesPerStrand + v];
      curves.positions.push_back({p.x, p.y, p.z});
    }
  }
  const ResampleReport even = resample(curves, {}).report;
  const ResampleReport fitted = resample(curves, {.placement = VertexPlacement::kFitted}).report;
  EXPECT_LT(even.maxDeviation, 0.004f);
  EXPECT_LT(fitted.maxDeviation, 0.0005f);
}

}  // namespace
}  // namespace pelage
