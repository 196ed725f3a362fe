// Guide selection: what follow hairs reproduce, and whether the reported errors are true.
#include "pelage/authoring/guides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <set>
#include <string_view>
#include <vector>

#include "follow_fit.h"
#include "hair_clusters.h"
#include "pelage/demo/groom.h"
#include "pelage/random.h"
#include "points.h"
#include "support/errors.h"
#include "support/extremes.h"

namespace pelage {
namespace {

using detail::Vector;
using test::expectError;
using test::expectOk;
using test::required;
using test::valueOf;

Vector toVector(const Float4& p) { return {double{p.x}, double{p.y}, double{p.z}}; }
double distance(const Float4& a, const Float4& b) { return length(toVector(a) - toVector(b)); }

HairAsset makeGroom(uint32_t strands = 400, uint32_t vertices = 12) {
  static const Result<Groom> groom =
      generateGroom({.strandCount = 400, .verticesPerStrand = 12, .headCellSize = 0.007f});
  EXPECT_TRUE(groom);
  if (!groom) return {};
  if (strands == 400 && vertices == 12) return groom->hair;
  const Result<Groom> other = generateGroom(
      {.strandCount = strands, .verticesPerStrand = vertices, .headCellSize = 0.007f});
  EXPECT_TRUE(other);
  return other ? other->hair : HairAsset{};
}

GuideSelection select(const HairAsset& groom, const GuideDef& def) {
  return valueOf(selectGuides(groom, def));
}

void expectSelectionRefused(const HairAsset& groom, const GuideDef& def, const char* text) {
  expectError(selectGuides(groom, def), ErrorCode::kInvalidArgument, text);
}

// Every hair is a guide or follows; guides are copies; weights and indices are what a scene takes.
void expectComplete(const HairAsset& groom, const GuideSelection& s) {
  std::vector<uint32_t> all = s.source;
  all.insert(all.end(), s.followSource.begin(), s.followSource.end());
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), groom.strandCount);
  for (uint32_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], i);
  ASSERT_TRUE(std::is_sorted(s.source.begin(), s.source.end()));
  ASSERT_EQ(s.followHairs.size(), s.followSource.size());
  ASSERT_EQ(s.followErrors.size(), s.followSource.size());
  ASSERT_EQ(s.guides.strandCount, s.source.size());
  ASSERT_EQ(s.report.guides, s.source.size());
  ASSERT_EQ(s.report.hairs, groom.strandCount);
  const uint32_t count = groom.verticesPerStrand;
  for (size_t g = 0; g < s.source.size(); ++g)
    for (uint32_t v = 0; v < count; ++v)
      ASSERT_EQ(s.guides.positions[g * count + v], groom.positions[s.source[g] * count + v]);
  std::vector<uint32_t> rounds(s.guides.strandCount, 0);
  uint32_t last = 0;
  for (const FollowHair& hair : s.followHairs) {
    ASSERT_LT(hair.guide, s.guides.strandCount);
    // In spreadOrder().
    ASSERT_GE(rounds[hair.guide], last);
    last = rounds[hair.guide]++;
    ASSERT_LT(hair.otherGuides[0], s.guides.strandCount);
    ASSERT_LT(hair.otherGuides[1], s.guides.strandCount);
    ASSERT_GE(hair.otherWeights[0], 0);
    ASSERT_GE(hair.otherWeights[1], 0);
    ASSERT_LE(hair.otherWeights[0] + hair.otherWeights[1], 1);
    ASSERT_LE(std::abs(hair.offset.w), kMaxFittedTipFactor);
  }
}

TEST(Guides, TheReportIsWhatThePlacedHairsShow) {
  const HairAsset groom = makeGroom();
  for (const uint32_t guidesPerHair : {1u, 2u, 3u}) {
    const GuideSelection s = select(groom, {.guideCount = 40, .guidesPerHair = guidesPerHair});
    expectComplete(groom, s);
    ASSERT_EQ(s.source.size(), 40u);
    const Result<std::vector<Float4>> evaluated =
        required(evaluateFollowHairs(s.guides, s.followHairs));
    const uint32_t count = groom.verticesPerStrand;
    double largest = 0, sum = 0, squares = 0;
    uint32_t worst = 0;
    for (size_t i = 0; i < s.followSource.size(); ++i) {
      double own = 0;
      for (uint32_t v = 0; v < count; ++v) {
        const double d =
            distance((*evaluated)[i * count + v], groom.positions[s.followSource[i] * count + v]);
        test::keepLargest(own, d);
        sum += d;
        squares += d * d;
      }
      // The root is exact, but for the rounding of a sum.
      EXPECT_LT(distance((*evaluated)[i * count], groom.positions[s.followSource[i] * count]),
                1e-7);
      EXPECT_NEAR(s.followErrors[i], own, 1e-8);
      if (own > largest) worst = s.followSource[i];
      test::keepLargest(largest, own);
      const FollowHair& hair = s.followHairs[i];
      EXPECT_TRUE(guidesPerHair >= 3 || hair.otherWeights[1] == 0);
      EXPECT_TRUE(guidesPerHair >= 2 || hair.otherWeights[0] == 0);
    }
    const auto vertices = static_cast<double>(evaluated->size());
    EXPECT_NEAR(s.report.maxError, largest, 1e-8);
    EXPECT_NEAR(s.report.meanError, sum / vertices, 1e-8);
    EXPECT_NEAR(s.report.rmsError, std::sqrt(squares / vertices), 1e-8);
    EXPECT_EQ(s.report.worstHair, worst);
  }
}

TEST(Guides, PlacesFollowHairsAsTheKernelSays) {
  // kernels/simulation/follow_vertex.hlsli: mean of the guides + offset (1 + (w - 1) v / (V - 1)).
  HairAsset guides;
  guides.strandCount = 3;
  guides.verticesPerStrand = 5;
  Random random(5);
  for (int i = 0; i < 15; ++i)
    guides.positions.push_back(
        {random.uniform(), random.uniform(), random.uniform(), static_cast<float>(i)});
  const FollowHair hairs[] = {
      {.guide = 1, .offset = {0.1f, 0.2f, -0.3f, 3}},
      {.guide = 2, .offset = {1, 2, 3, 0}, .otherGuides = {0, 1}, .otherWeights = {0.25f, 0.125f}},
      {.guide = 2, .offset = {0, 0, 0, 1}, .otherGuides = {0, 1}, .otherWeights = {0, 1}},
  };
  const Result<std::vector<Float4>> evaluated = required(evaluateFollowHairs(guides, hairs));
  for (size_t h = 0; h < 3; ++h)
    for (size_t v = 0; v < 5; ++v) {
      const FollowHair& hair = hairs[h];
      const double others[] = {double{hair.otherWeights[0]}, double{hair.otherWeights[1]}};
      Vector p = toVector(guides.positions[hair.guide * 5 + v]) * (1 - others[0] - others[1]);
      for (size_t k = 0; k < 2; ++k)
        p += toVector(guides.positions[hair.otherGuides[k] * 5 + v]) * others[k];
      p += toVector(hair.offset) * (1 + (double{hair.offset.w} - 1) * static_cast<double>(v) / 4);
      EXPECT_LT(length(toVector((*evaluated)[h * 5 + v]) - p), 1e-6);
      EXPECT_EQ((*evaluated)[h * 5 + v].w, static_cast<float>((h == 2 ? 1 : hair.guide) * 5 + v));
    }
}

TEST(Guides, FittingIsBetterThanCopying) {
  const HairAsset groom = makeGroom();
  const GuideReport one = select(groom, {.guideCount = 40, .guidesPerHair = 1}).report;
  const GuideReport two = select(groom, {.guideCount = 40, .guidesPerHair = 2}).report;
  const GuideReport three = select(groom, {.guideCount = 40, .guidesPerHair = 3}).report;
  EXPECT_EQ(one.rmsErrorUnfitted, three.rmsErrorUnfitted);
  EXPECT_LT(one.rmsError, one.rmsErrorUnfitted);
  EXPECT_LT(two.rmsError, one.rmsError);
  EXPECT_LT(three.rmsError, two.rmsError);
  EXPECT_LT(three.rmsError, 0.7f * three.rmsErrorUnfitted);
  EXPECT_GE(three.maxError, three.rmsError);
  EXPECT_GE(three.rmsError, three.meanError);
}

// No other weights or factor may be better than those of the fit.
TEST(Guides, TheFitIsALeastOne) {
  const HairAsset groom = makeGroom();
  const uint32_t count = groom.verticesPerStrand;
  const auto strandOf = [&](uint32_t hair) {
    return std::span<const Float4>(groom.positions.data() + hair * count, count);
  };
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const uint32_t target = random.below(groom.strandCount);
    std::vector<detail::Candidate> candidates;
    for (int k = 0; k < 3; ++k) {
      const uint32_t guide = random.below(groom.strandCount);
      candidates.push_back({guide, strandOf(guide).data()});
    }
    const auto errorOf = [&](const FollowHair& hair) {
      std::vector<Float4> evaluated(count);
      detail::evaluateFollowHair(
          hair, count, [&](uint32_t guide) { return strandOf(guide).data(); }, evaluated.data());
      double sum = 0;
      for (uint32_t v = 0; v < count; ++v)
        sum += std::pow(distance(evaluated[v], strandOf(target)[v]), 2);
      return sum;
    };
    const double least = errorOf(detail::fitFollowHair(strandOf(target), candidates, 3));
    const Vector root = toVector(strandOf(target)[0]);
    // A grid over all weights and factors.
    for (int a = 0; a <= 10; ++a)
      for (int b = 0; a + b <= 10; ++b)
        for (int w = -20; w <= 20; ++w) {
          FollowHair hair;
          hair.guide = candidates[0].guide;
          hair.otherGuides[0] = candidates[1].guide;
          hair.otherGuides[1] = candidates[2].guide;
          hair.otherWeights[0] = 0.1f * static_cast<float>(a) * 0.9999f;
          hair.otherWeights[1] = 0.1f * static_cast<float>(b) * 0.9999f;
          const double weights[] = {1 - double{hair.otherWeights[0]} - double{hair.otherWeights[1]},
                                    double{hair.otherWeights[0]}, double{hair.otherWeights[1]}};
          Vector offset = root;
          for (size_t k = 0; k < 3; ++k) offset -= toVector(candidates[k].strand[0]) * weights[k];
          hair.offset = {static_cast<float>(offset.x), static_cast<float>(offset.y),
                         static_cast<float>(offset.z), 0.5f * static_cast<float>(w)};
          // Alternating between weights and factor may end in another valley, a little higher.
          EXPECT_LT(least, errorOf(hair) * 1.02 + 1e-12) << trial;
        }
  }
}

TEST(Guides, ShiftedCopiesOfAGuideAreReproduced) {
  const HairAsset few = makeGroom();
  HairAsset groom;
  groom.strandCount = 60;
  groom.verticesPerStrand = few.verticesPerStrand;
  Random random(2);
  for (uint32_t s = 0; s < groom.strandCount; ++s) {
    const Float3 shift = {0.02f * random.uniform(), 0.02f * random.uniform(),
                          0.02f * random.uniform()};
    for (uint32_t v = 0; v < groom.verticesPerStrand; ++v) {
      // Six shapes, ten copies each.
      const Float4& p = few.positions[(s / 10 * 50) * groom.verticesPerStrand + v];
      groom.positions.push_back({p.x + shift.x, p.y + shift.y, p.z + shift.z, p.w});
    }
  }
  for (const uint32_t guidesPerHair : {1u, 3u}) {
    const GuideSelection s =
        select(groom, {.guideCount = 6, .guidesPerHair = guidesPerHair, .rootWeight = 0.01f});
    EXPECT_LT(s.report.maxError, 2e-7f);
    EXPECT_LT(s.report.maxErrorUnfitted, 2e-7f);
    std::set<uint32_t> shapes;
    for (const uint32_t source : s.source) shapes.insert(source / 10);
    EXPECT_EQ(shapes.size(), 6u);
  }
}

TEST(Guides, MixturesOfGuidesAreReproduced) {
  // Hairs that are means of the three guides, and fan out towards their tips.
  const HairAsset few = makeGroom();
  const uint32_t count = few.verticesPerStrand;
  HairAsset groom;
  groom.verticesPerStrand = count;
  const uint32_t corners[] = {3, 90, 250};
  Random random(8);
  for (uint32_t s = 0; s < 30; ++s) {
    double weights[] = {0, 0, 0};
    if (s < 3) weights[s] = 1;
    if (s >= 3) {
      weights[0] = 0.2 + 0.3 * random.uniformDouble();
      weights[1] = 0.2 + 0.2 * random.uniformDouble();
      weights[2] = 1 - weights[0] - weights[1];
    }
    for (uint32_t v = 0; v < count; ++v) {
      Vector p;
      for (size_t k = 0; k < 3; ++k)
        p += toVector(few.positions[corners[k] * count + v]) * weights[k];
      const double fan = s < 3 ? 0 : 1 + 1.5 * v / (count - 1);
      p += Vector{0.001, -0.002, 0.001} * fan;
      groom.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y),
                                 static_cast<float>(p.z), v < 2 ? 0.0f : 1.0f});
    }
    ++groom.strandCount;
  }
  std::vector<detail::Candidate> candidates;
  for (uint32_t k = 0; k < 3; ++k) candidates.push_back({k, groom.positions.data() + k * count});
  for (uint32_t s = 3; s < 30; ++s) {
    const std::span<const Float4> strand(groom.positions.data() + s * count, count);
    const FollowHair hair = detail::fitFollowHair(strand, candidates, 3);
    EXPECT_NEAR(hair.offset.w, 2.5f, 0.01f);
    std::vector<Float4> evaluated(count);
    detail::evaluateFollowHair(
        hair, count, [&](uint32_t k) { return candidates[k].strand; }, evaluated.data());
    for (uint32_t v = 0; v < count; ++v) EXPECT_LT(distance(evaluated[v], strand[v]), 2e-6);
  }
}

TEST(Guides, WhenEveryHairIsAGuideNothingFollows) {
  const HairAsset groom = makeGroom();
  const GuideDef defs[] = {{.guideCount = 400}, {.guideCount = 5000}, {.guideErrorBound = 1e-12f}};
  for (const GuideDef& def : defs) {
    const GuideSelection s = select(groom, def);
    expectComplete(groom, s);
    EXPECT_TRUE(s.followHairs.empty());
    EXPECT_EQ(s.guides.positions, groom.positions);
    EXPECT_EQ(s.guides.strandThickness, groom.strandThickness);
    EXPECT_EQ(s.report.maxError, 0);
  }
}

TEST(Guides, AnErrorBoundHoldsWithFewerGuidesWhenItIsLooser) {
  const HairAsset groom = makeGroom();
  size_t before = groom.strandCount;
  for (const float bound : {0.002f, 0.006f, 0.02f, 10.0f}) {
    const GuideSelection s = select(groom, {.guideErrorBound = bound});
    expectComplete(groom, s);
    EXPECT_LE(s.report.maxError, bound);
    EXPECT_LT(s.source.size(), before);
    before = s.source.size();
  }
  EXPECT_EQ(before, 1u);
}

TEST(Guides, SeedsDecideAndNothingElse) {
  const HairAsset groom = makeGroom();
  const GuideSelection a = select(groom, {.guideCount = 30, .seed = 5});
  const GuideSelection b = select(groom, {.guideCount = 30, .seed = 5});
  const GuideSelection c = select(groom, {.guideCount = 30, .seed = 6});
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.followHairs, b.followHairs);
  EXPECT_NE(a.source, c.source);
}

TEST(Guides, MoreGuidesErrLess) {
  const HairAsset groom = makeGroom();
  float before = std::numeric_limits<float>::infinity();
  for (const uint32_t count : {1u, 8u, 64u, 256u}) {
    const float error = select(groom, {.guideCount = count}).report.rmsError;
    EXPECT_LT(error, before);
    before = error;
  }
}

TEST(Guides, ACloserRootCountsMoreWithALargerWeight) {
  const HairAsset groom = makeGroom();
  const auto meanOffset = [&](float rootWeight) {
    const GuideSelection s =
        select(groom, {.guideCount = 60, .guidesPerHair = 1, .rootWeight = rootWeight});
    double sum = 0;
    for (const FollowHair& hair : s.followHairs) {
      const Float4& o = hair.offset;
      sum += length(Vector{double{o.x}, double{o.y}, double{o.z}});
    }
    return sum / static_cast<double>(s.followHairs.size());
  };
  EXPECT_LT(meanOffset(4), 0.8 * meanOffset(0.1f));
}

TEST(Guides, MedoidsAreTheBestOfTheirClusters) {
  const HairAsset groom = makeGroom();
  const detail::HairFeatures features(groom, 0.5);
  std::vector<uint32_t> hairs(groom.strandCount);
  std::iota(hairs.begin(), hairs.end(), 0u);
  const std::vector<uint32_t> medoids = detail::findMedoids(features, hairs, 20, 1);
  ASSERT_EQ(medoids.size(), 20u);
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const auto squared = [&](uint32_t a, uint32_t b) {
    return detail::squaredDistance(features[a], features[b], features.size(), kFar);
  };
  const detail::FeatureTree tree(features, medoids);
  std::vector<std::vector<uint32_t>> clusters(groom.strandCount);
  std::vector<detail::Neighbor> found;
  double total = 0, random = 0;
  for (const uint32_t hair : hairs) {
    // The tree finds what looking at all finds.
    tree.nearest(features[hair], 1, found);
    uint32_t nearest = medoids[0], some = 0;
    for (const uint32_t medoid : medoids)
      if (squared(hair, medoid) < squared(hair, nearest)) nearest = medoid;
    ASSERT_EQ(found[0].hair, nearest);
    for (uint32_t k = 0; k < 20; ++k)
      if (squared(hair, k) < squared(hair, some)) some = k;
    total += double{squared(hair, nearest)};
    random += double{squared(hair, some)};
    clusters[nearest].push_back(hair);
  }
  EXPECT_LT(total, 0.8 * random);
  for (const uint32_t medoid : medoids) {
    const auto costOf = [&](uint32_t hair) {
      double sum = 0;
      for (const uint32_t other : clusters[medoid]) sum += double{squared(hair, other)};
      return sum;
    };
    for (const uint32_t other : clusters[medoid])
      EXPECT_GE(costOf(other), costOf(medoid) * (1 - 1e-5));
  }
}

TEST(Guides, FeaturesKeepTheDistanceOfHairs) {
  const HairAsset groom = makeGroom();
  const detail::HairFeatures features(groom, 0.5);
  const uint32_t count = groom.verticesPerStrand;
  for (uint32_t a = 0; a < 20; ++a) {
    const uint32_t b = a + 100;
    const Float4* pa = groom.positions.data() + a * count;
    const Float4* pb = groom.positions.data() + b * count;
    const Vector roots = toVector(pa[0]) - toVector(pb[0]);
    double expected = 0.25 * dot(roots, roots);
    for (uint32_t v = 0; v < count; ++v) {
      const Vector d = toVector(pa[v]) - toVector(pb[v]) - roots;
      expected += dot(d, d) / count;
    }
    EXPECT_NEAR(detail::squaredDistance(features[a], features[b], features.size(), 1e9f), expected,
                1e-4 * expected);
  }
}

TEST(Guides, EqualHairsAndHairsWithoutLengthAreFine) {
  HairAsset groom;
  groom.strandCount = 12;
  groom.verticesPerStrand = 256;
  groom.positions.assign(12 * 256, {1e6f, -1e6f, 1e6f, 1});
  for (const uint32_t count : {1u, 5u}) {
    GuideSelection s = select(groom, {.guideCount = count});
    expectComplete(groom, s);
    EXPECT_EQ(s.report.maxError, 0);
    EXPECT_EQ(s.source.size(), count);
    expectOk(s.guides.process());
  }
  EXPECT_EQ(select(groom, {.guideErrorBound = 1e-3f}).source.size(), 1u);
  groom.strandCount = 1;
  groom.verticesPerStrand = 2;
  groom.positions = {{0, 0, 0, 0}, {0, 1, 0, 0}};
  EXPECT_EQ(select(groom, {.guideCount = 1}).source.size(), 1u);
}

TEST(Guides, CopiesTheAttributesOfTheGuides) {
  HairAsset groom = makeGroom();
  const size_t vertices = groom.positions.size();
  groom.strandUv.resize(groom.strandCount);
  groom.strandThickness.resize(groom.strandCount);
  groom.vertexUv.resize(vertices);
  groom.vertexColor.resize(vertices);
  for (uint32_t i = 0; i < groom.strandCount; ++i)
    groom.strandUv[i].x = groom.strandThickness[i] = static_cast<float>(i);
  for (size_t i = 0; i < vertices; ++i)
    groom.vertexUv[i].y = groom.vertexColor[i].z = static_cast<float>(i);
  const GuideSelection s = select(groom, {.guideCount = 7});
  for (size_t g = 0; g < 7; ++g) {
    EXPECT_EQ(s.guides.strandUv[g].x, static_cast<float>(s.source[g]));
    EXPECT_EQ(s.guides.strandThickness[g], static_cast<float>(s.source[g]));
    for (uint32_t v = 0; v < groom.verticesPerStrand; ++v) {
      const size_t to = g * groom.verticesPerStrand + v;
      const auto from = static_cast<float>(s.source[g] * groom.verticesPerStrand + v);
      EXPECT_EQ(s.guides.vertexUv[to].y, from);
      EXPECT_EQ(s.guides.vertexColor[to].z, from);
    }
  }
}

TEST(Guides, RefusesWhatItCannotSelectFrom) {
  const HairAsset groom = makeGroom();
  expectSelectionRefused(groom, {}, "either");
  expectSelectionRefused(groom, {.guideCount = 3, .guideErrorBound = 1}, "either");
  expectSelectionRefused(groom, {.guideErrorBound = -1}, "error bound of guides is -1");
  expectSelectionRefused(groom, {.guideErrorBound = std::nanf("")}, "error bound of guides is nan");
  expectSelectionRefused(groom, {.guideCount = 3, .guidesPerHair = 0}, "guides per hair is 0");
  expectSelectionRefused(groom, {.guideCount = 3, .guidesPerHair = 4}, "guides per hair is 4");
  expectSelectionRefused(groom, {.guideCount = 3, .rootWeight = -1}, "weight of the roots is -1");
  expectSelectionRefused({}, {.guideCount = 3}, "no strands");
  HairAsset bad = groom;
  bad.positions[5].x = std::nanf("");
  expectSelectionRefused(bad, {.guideCount = 3}, "strand 0, vertex 5");
  bad = groom;
  bad.vertexCounts.assign(groom.strandCount, groom.verticesPerStrand);
  EXPECT_TRUE(selectGuides(bad, {.guideCount = 3}));
  bad.vertexCounts[9] = 4;
  expectSelectionRefused(bad, {.guideCount = 3}, "strand 9 has 4 vertices");
  std::vector<FollowHair> hairs(1);
  EXPECT_TRUE(evaluateFollowHairs(groom, hairs));
  hairs[0].guide = 400;
  EXPECT_FALSE(evaluateFollowHairs(groom, hairs));
  hairs[0].guide = 0;
  hairs[0].otherWeights[0] = hairs[0].otherWeights[1] = 0.6f;
  EXPECT_FALSE(evaluateFollowHairs(groom, hairs));
}

TEST(Guides, TheMohawkFollowsATenthOfItself) {
  const auto path = std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy/Ratboy_mohawk.tfx";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const Result<HairAsset> mohawk = required(loadTfx(path));
  const GuideSelection s = select(*mohawk, {.guideCount = 223});
  expectComplete(*mohawk, s);
  // The hairs are 80 mm long.
  EXPECT_LT(s.report.rmsError, 0.0035f);
  EXPECT_LT(s.report.rmsError, 0.4f * s.report.rmsErrorUnfitted);
}

}  // namespace
}  // namespace pelage
