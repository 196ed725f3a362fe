// The words of fragments and layers (fragment_packing.hlsli, layer_packing.hlsli): what goes in
// comes out, but for rounding, and no value reaches into its neighbour's bits.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "oit_test/gpu_structs.h"
#include "oit_test/kernels.h"
#include "support/extremes.h"
#include "support/gpu_fixture.h"
#include "support/not_numbers.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using oit_test::PackingConstants;
using oit_test::PackingResult;
using oit_test::PackingSample;

class Packing : public GpuTest {
 protected:
  std::vector<PackingResult> pack(const std::vector<PackingSample>& samples,
                                  bool reversed = false) {
    const GuardedBuffer<PackingSample> given(gpu(), "samples", samples);
    const GuardedBuffer<PackingResult> results(gpu(), "results",
                                               std::vector<PackingResult>(samples.size()));
    PackingConstants constants = {};
    constants.packingCount = static_cast<uint32_t>(samples.size());
    constants.packingReversed = reversed ? 1 : 0;
    dispatch(gpu(), oit_test::packSamplesVariant(), samples.size(), [&](PassBuilder& pass) {
      given.bindTo(pass, "g_packingSamples");
      results.bindTo(pass, "g_packingResults");
      pass.constants("PackingConstants", constants);
    });
    return results.read();
  }

  static PackingSample sample(const Vector3d& color, double alpha, const Vector3d& tangent,
                              double depth) {
    return {toFloat4(color, alpha), toFloat4(tangent, depth)};
  }
  static std::vector<PackingSample> randomSamples(double mostColor) {
    Random random(5);
    std::vector<PackingSample> samples;
    for (int i = 0; i < 4000; ++i) {
      const Vector3d color(random.unit(), random.unit(), random.unit());
      samples.push_back(sample(mostColor * color * random.unit(), random.unit(), random.vector(2),
                               random.unit()));
    }
    return samples;
  }
};
INSTANTIATE_TEST_SUITE_P(All, Packing, testing::ValuesIn(kApis), apiTestName);

double rootError(float stored, float given) {
  return std::abs(std::sqrt(double{stored}) - std::sqrt(double{given}));
}

TEST_P(Packing, FragmentsComeBackWithinHalfAStep) {
  for (const bool reversed : {false, true}) {
    const std::vector<PackingSample> samples = randomSamples(1);
    const std::vector<PackingResult> results = pack(samples, reversed);
    double red = 0, blue = 0, alpha = 0, angle = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const PackingResult& r = results[i];
      keepLargest(red, rootError(r.color.x, samples[i].color.x));
      keepLargest(red, rootError(r.color.y, samples[i].color.y));
      keepLargest(blue, rootError(r.color.z, samples[i].color.z));
      keepLargest(alpha, rootError(r.color.w, samples[i].color.w));
      const Vector3d given = toVector(samples[i].tangent).normalized();
      keepLargest(angle, (toVector(r.tangent) - given).norm());
      EXPECT_EQ(r.tangent.w, samples[i].tangent.w) << "depth keeps its bits";
    }
    EXPECT_LT(red, 0.501 / 2047);
    EXPECT_LT(blue, 0.501 / 1023);
    EXPECT_LT(alpha, 0.501 / 1023);
    // Half a step of both octahedral coordinates moves the third by both; vectors on the octahedron
    // are at least 1 / sqrt(3) long.
    EXPECT_LT(angle, 0.501 / 1023 * std::sqrt(6.0) * std::sqrt(3.0));
  }
}

TEST_P(Packing, FragmentsOfTilesComeBackForEveryNumberOfSegments) {
  for (const bool reversed : {false, true}) {
    const std::vector<PackingSample> samples = randomSamples(1);
    const std::vector<PackingResult> results = pack(samples, reversed);
    for (size_t i = 0; i < samples.size(); ++i) {
      const PackingResult& r = results[i];
      const uint32_t depth = std::bit_cast<uint32_t>(samples[i].tangent.w);
      const uint32_t key = (reversed ? ~depth : depth) & ((1u << 30) - 1);
      EXPECT_EQ(r.tileKey, key >> (r.tileBits - 24));
      EXPECT_NEAR(r.tileRoot, 1023 * std::sqrt(double{samples[i].color.w}), 0.501);
      EXPECT_EQ(r.tileSegment,
                std::bit_cast<uint32_t>(samples[i].color.x) & ((1u << r.tileBits) - 1));
    }
  }
}

TEST_P(Packing, LayersComeBackWithinHalfAStep) {
  const std::vector<PackingSample> samples = randomSamples(16);
  const std::vector<PackingResult> results = pack(samples);
  double light = 0, alpha = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const Float4 &given = samples[i].color, &stored = results[i].light;
    const double largest = std::max(double{std::max({given.x, given.y, given.z})}, 0.125);
    // The power of two that all channels are relative to.
    const double scale = std::exp2(std::ceil(std::log2(largest)));
    keepLargest(light, (toVector(stored) - toVector(given)).cwiseAbs().maxCoeff() / scale);
    keepLargest(alpha, rootError(stored.w, given.w));
    EXPECT_EQ(results[i].layerAgain, results[i].layer) << "sample " << i;
  }
  EXPECT_LT(light, 0.501 / 127);
  EXPECT_LT(alpha, 1.001 / 255) << "half a step, and what is nearly nothing stays visible";
}

// K37
TEST_P(Packing, AValueOver1LeavesItsNeighboursAlone) {
  std::vector<PackingSample> samples;
  for (const float over : {1.0f, 1.0001f, 2.0f, 1e30f, kInf})
    for (int channel = 0; channel < 4; ++channel) {
      PackingSample s = {{0.25f, 0.25f, 0.25f, 0.25f}, {0, 1, 0, 0.5f}};
      (channel == 0   ? s.color.x
       : channel == 1 ? s.color.y
       : channel == 2 ? s.color.z
                      : s.color.w) = over;
      samples.push_back(s);
    }
  const std::vector<PackingResult> results = pack(samples);
  for (size_t i = 4; i < results.size(); ++i) {
    EXPECT_EQ(results[i].colorWord, results[i % 4].colorWord) << "sample " << i;
    EXPECT_EQ(results[i].shape, results[i % 4].shape) << "sample " << i;
  }
  const PackingResult& red = results[0];
  EXPECT_EQ(red.color.x, 1);
  EXPECT_NEAR(red.color.y, 0.25f, 1e-3);
  EXPECT_NEAR(red.color.z, 0.25f, 2e-3);
}

TEST_P(Packing, AnyInputGivesFiniteValuesInRange) {
  std::vector<PackingSample> samples;
  for (const float x : {0.0f, -1.0f, 1e-30f, 1.0f, 3e38f, kNan, kInf, -kInf})
    for (const float y : {0.0f, 0.5f, kNan, kInf})
      for (const bool inTangent : {false, true})
        samples.push_back(inTangent ? PackingSample{{0.5f, 0.5f, 0.5f, 0.5f}, {x, y, x, y}}
                                    : PackingSample{{x, y, x, x}, {0, 0, 1, y}});
  for (const PackingResult& r : pack(samples)) {
    for (const float share : {r.color.x, r.color.y, r.color.z, r.color.w, r.light.w, r.tangent.w})
      EXPECT_TRUE(share >= 0 && share <= 1) << share;
    for (const float light : {r.light.x, r.light.y, r.light.z})
      EXPECT_TRUE(light >= 0 && light <= 16) << light;
    EXPECT_NEAR(toVector(r.tangent).norm(), 1, 1e-5);
  }
}

TEST_P(Packing, WhatIsHardlyThereStaysALayer) {
  std::vector<PackingSample> samples;
  for (const double alpha : {1e-30, 1e-7, 1e-4, 0.01})
    samples.push_back(sample({0, 0, 0}, alpha, {0, 0, 1}, 0));
  samples.push_back(sample({0.1, 0.1, 0.1}, 0, {0, 0, 1}, 0));
  const std::vector<PackingResult> results = pack(samples);
  for (size_t i = 0; i + 1 < results.size(); ++i) EXPECT_GT(results[i].light.w, 0) << i;
  EXPECT_EQ(results.back().light.w, 0);
}

}  // namespace
}  // namespace pelage::test
