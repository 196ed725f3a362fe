// The size of a groom, and the unit that it is in.
#include "pelage/hair_asset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/errors.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;
using test::required;

/// Straight strands of three vertices along x, of these lengths.
HairAsset groomOf(std::initializer_list<float> lengths) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(lengths.size());
  asset.verticesPerStrand = 3;
  float z = -1;
  for (const float length : lengths) {
    for (const float share : {0.0f, 0.25f, 1.0f})
      asset.positions.push_back({share * length, 2, z, share > 0.5f ? 1.0f : 0.0f});
    z += 0.5f;
  }
  return asset;
}

TEST(HairSize, IsTheMeanAndTheMaximumOfTheLengthsAndTheBoundsOfTheVertices) {
  const auto size = required(measureHair(groomOf({0.1f, 0.3f, 0.2f})));
  EXPECT_NEAR(size->meanLength, 0.2, 1e-7);
  EXPECT_NEAR(size->maxLength, 0.3, 1e-7);
  EXPECT_EQ(size->low, (Float3{0, 2, -1}));
  EXPECT_EQ(size->high, (Float3{0.3f, 2, 0}));
}

TEST(HairSize, LeavesOutTheVerticesThatAStrandDoesNotHave) {
  HairAsset asset = groomOf({1, 1});
  asset.vertexCounts = {2, 3};
  const auto size = required(measureHair(asset));
  EXPECT_NEAR(size->meanLength, 0.625, 1e-7);
  EXPECT_NEAR(size->maxLength, 1, 1e-7);
}

TEST(HairSize, RefusesWhatIsNoGroom) {
  EXPECT_FALSE(measureHair({}));
  HairAsset asset = groomOf({1});
  asset.positions[1].y = kNan;
  expectError(measureHair(asset), "vertex 1");
}

TEST(UnitGuess, NamesNoUnitForHairInMeters) {
  for (const double length : {kMinMeanLength, 0.02, 0.3, kMaxMeanLength}) {
    EXPECT_TRUE(guessUnits(length).empty()) << length;
    EXPECT_EQ(unitWarning({length, length, {}, {}}), "") << length;
  }
}

TEST(UnitGuess, NamesTheLikeliestUnitFirst) {
  struct Case {
    double meanLength;
    const char* unit;
    float scale;
  };
  // Hair of 3 cm to 60 cm in centimeters and millimeters, and hair that was scaled once too often.
  for (const Case& c : {Case{28, "centimeters", 0.01f}, Case{60, "centimeters", 0.01f},
                        Case{11, "centimeters", 0.01f}, Case{280, "millimeters", 0.001f},
                        Case{600, "millimeters", 0.001f}, Case{0.00028, "meters times 0.001", 1000},
                        Case{0.0009, "meters times 0.01", 100}}) {
    const auto guesses = guessUnits(c.meanLength);
    ASSERT_FALSE(guesses.empty()) << c.meanLength;
    EXPECT_STREQ(guesses[0].unit, c.unit) << c.meanLength;
    EXPECT_EQ(guesses[0].scale, c.scale);
    EXPECT_NEAR(guesses[0].meanLength, c.meanLength * c.scale, 1e-6 * c.meanLength);
    const std::string warning = unitWarning({c.meanLength, c.meanLength, {}, {}});
    EXPECT_NE(warning.find(std::string("Is it in ") + c.unit), std::string::npos) << warning;
  }
}

TEST(UnitGuess, KnowsInches) {
  bool found = false;
  for (const UnitGuess& guess : guessUnits(12)) found |= guess.scale == 0.0254f;
  EXPECT_TRUE(found);
}

TEST(UnitGuess, OffersOnlyScalesThatMakeHairOfIt) {
  for (double length = 1e-7; length < 1e7; length *= 1.7)
    for (const UnitGuess& guess : guessUnits(length)) {
      EXPECT_GE(guess.meanLength, kMinMeanLength);
      EXPECT_LE(guess.meanLength, kMaxMeanLength);
    }
}

TEST(UnitGuess, WarnsAboutLengthsThatNoUnitExplains) {
  for (const double length : {0.0, 1e9, double{kNan}}) {
    EXPECT_TRUE(guessUnits(length).empty()) << length;
    EXPECT_NE(unitWarning({length, length, {}, {}}), "") << length;
  }
}

TEST(ScaleHair, ScalesTheSizeAndDropsWhatWasDerived) {
  HairAsset asset = groomOf({10, 30});
  ASSERT_TRUE(asset.process());
  ASSERT_TRUE(scaleHair(asset, 0.01f));
  EXPECT_FALSE(packRest(asset)) << "the rest shape is that of before";
  const auto size = required(measureHair(asset));
  EXPECT_NEAR(size->meanLength, 0.2, 1e-7);
  EXPECT_NEAR(size->low.z, -0.01, 1e-7);
  EXPECT_EQ(asset.positions[2].w, 1);  // the mass is not a length
  EXPECT_TRUE(asset.process());
}

TEST(ScaleHair, RefusesScalesOutOfRangeAndChangesNothing) {
  const HairAsset before = groomOf({10, 30});
  for (const float scale : {0.0f, -1.0f, kNan, 1e10f, 1e-10f, 1e5f}) {
    HairAsset asset = before;
    EXPECT_FALSE(scaleHair(asset, scale)) << scale;
    EXPECT_EQ(asset.positions, before.positions) << scale;
  }
}

}  // namespace
}  // namespace pelage
