// shadeStrand() and what it is made of: energy, reciprocity, where highlights are, and arguments
// that must not break it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "reference/shading/fiber_reference.h"
#include "shading_test/gpu_structs.h"
#include "shading_test/kernels.h"
#include "support/extremes.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using shading_test::ShadeConstants;
using shading_test::ShadeSample;
using shading_test::StrandShading;

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kKajiyaKay = 0, kFar = 1, kNear = 2;
const Vector3d kTangent = Vector3d(0.3, -0.8, 0.45).normalized();

/// sumLight() does not read the light of its samples.
const Vector3d kNoLight(0, 0, 0);

/// The direction at theta from the plane across the fiber, phi around it.
Vector3d direction(double theta, double phi) {
  const Vector3d x = kTangent.cross(Vector3d(1, 0, 0)).normalized();
  const Vector3d y = kTangent.cross(x);
  return kTangent * std::sin(theta) + (x * std::cos(phi) + y * std::sin(phi)) * std::cos(theta);
}

StrandShading fiber(uint32_t model, float betaM, float betaN, float tilt = 0.035f) {
  StrandShading m;
  m.model = {model, 0, 0, 0};
  m.fiber = {betaM, betaN, tilt, 1.55f};
  return m;
}

StrandShading kajiyaKay() {
  StrandShading m;
  m.body = {1, 1, 0, 0};
  m.primary = {0.35f, 80, -0.06f, 0};
  m.secondary = {0.45f, 16, 0.12f, 1};
  return m;
}

ShadeSample sample(const Vector3d& toEye, const Vector3d& toLight, const Vector3d& base,
                   double offset = 0, double material = 0) {
  return {toFloat4(kTangent, material), toFloat4(toEye), toFloat4(base, offset), toFloat4(toLight)};
}

class FiberShading : public GpuTest {
 protected:
  std::vector<Float4> shade(const std::vector<StrandShading>& materials,
                            const std::vector<ShadeSample>& samples) {
    return run(shading_test::shadeSamplesVariant(), materials, samples, 1, 1);
  }

  /// Light to the eye from light of 1 / pi from everywhere.
  std::vector<Vector3d> sumLight(const std::vector<StrandShading>& materials,
                                 const std::vector<ShadeSample>& samples) {
    constexpr uint32_t kThetas = 112, kPhis = 80;
    const std::vector<Float4> parts =
        run(shading_test::sumLightVariant(), materials, samples, kThetas, kPhis);
    std::vector<Vector3d> sums(samples.size(), Vector3d::Zero());
    for (size_t i = 0; i < parts.size(); ++i) sums[i / kThetas] += toVector(parts[i]);
    return sums;
  }

 private:
  std::vector<Float4> run(const KernelVariant& kernel, const std::vector<StrandShading>& materials,
                          const std::vector<ShadeSample>& samples, uint32_t thetas, uint32_t phis) {
    const auto count = static_cast<uint32_t>(samples.size());
    const GuardedBuffer<ShadeSample> sampleBuffer(gpu(), "samples", samples);
    const GuardedBuffer<StrandShading> materialBuffer(gpu(), "materials", materials);
    const GuardedBuffer<Float4> results(gpu(), "results",
                                        std::vector<Float4>(samples.size() * thetas));
    dispatch(gpu(), kernel, samples.size() * thetas, [&](PassBuilder& pass) {
      sampleBuffer.bindTo(pass, "g_shadeSamples");
      materialBuffer.bindTo(pass, "g_shadeMaterials");
      results.bindTo(pass, "g_shaded");
      pass.constants("ShadeConstants",
                     ShadeConstants{count, static_cast<uint32_t>(materials.size()), thetas, phis});
    });
    return results.read();
  }
};
INSTANTIATE_TEST_SUITE_P(All, FiberShading, ::testing::ValuesIn(kApis), apiTestName);

TEST_P(FiberShading, SendsOnAllLightThatItDoesNotAbsorb) {
  std::vector<StrandShading> materials;
  for (const float betaM : {0.1f, 0.3f, 1.0f})
    for (const float betaN : {0.15f, 0.3f, 1.0f}) {
      materials.push_back(fiber(kFar, betaM, betaN));
      materials.push_back(fiber(kNear, betaM, betaN));
      materials.push_back(fiber(kFar, betaM, betaN));
      materials.back().body.z = 0.6f;
      // Without refraction TT goes straight on, from all of the width.
      materials.push_back(fiber(kFar, betaM, betaN));
      materials.back().fiber.w = 1;
    }
  std::vector<ShadeSample> samples;
  for (size_t m = 0; m < materials.size(); ++m)
    for (const double theta : {0.0, 0.7, -1.3})
      for (const double offset : {0.0, 0.6, -0.97}) {
        if (offset != 0.0 && materials[m].model.x == kFar) continue;
        samples.push_back(
            sample(direction(theta, 0.4), kNoLight, {1, 1, 1}, offset, static_cast<double>(m)));
      }
  const std::vector<Vector3d> sums = sumLight(materials, samples);
  double worst = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    const auto& m = materials[static_cast<size_t>(samples[i].tangent.w)];
    EXPECT_NEAR(sums[i].x(), 1, 0.005)
        << "model " << m.model.x << " beta_m " << m.fiber.x << " beta_n " << m.fiber.y;
    keepLargest(worst, std::abs(sums[i].x() - 1));
  }
  RecordProperty("worst", std::to_string(worst));
}

TEST_P(FiberShading, SendsOnLessTheDarkerItIs) {
  std::vector<StrandShading> materials = {fiber(kFar, 0.3f, 0.3f), fiber(kNear, 0.3f, 0.3f),
                                          fiber(kFar, 0.2f, 0.6f)};
  materials[2].body.z = 0.4f;
  const std::vector<double> albedos = {0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1};
  std::vector<ShadeSample> samples;
  for (size_t m = 0; m < materials.size(); ++m)
    for (const double theta : {0.0, 1.0})
      for (const double albedo : albedos)
        samples.push_back(sample(direction(theta, 0), kNoLight, {albedo, albedo, albedo}, 0.3,
                                 static_cast<double>(m)));
  const std::vector<Vector3d> sums = sumLight(materials, samples);
  for (size_t i = 0; i < sums.size(); ++i) {
    EXPECT_LE(sums[i].x(), 1.005);
    EXPECT_GT(sums[i].x(), 0.01) << "the surface mirrors light whatever is inside";
    if (i % albedos.size() > 0) {
      EXPECT_GT(sums[i].x(), sums[i - 1].x() + 1e-4);
    }
  }
}

/// Light that a material sends to the eye, by the reference.
struct Expected {
  StrandShading material;
  std::vector<ShadeSample> samples;
  std::vector<Vector3d> light;
};

Expected expectedOf(uint32_t model, float betaN) {
  Expected result;
  result.material = fiber(model, 0.25f, betaN);
  Random random(7);
  const Vector3d base(0.9, 0.4, 0.05);
  reference::Fiber f;
  f.betaM = 0.25;
  f.betaN = static_cast<double>(betaN);
  f.tilt = static_cast<double>(result.material.fiber.z);
  for (int i = 0; i < 150; ++i) {
    const double thetaEye = random.between(-1.2, 1.2);
    // Around the highlights; elsewhere there is little to compare.
    const double thetaLight = std::clamp(-thetaEye + random.between(-0.4, 0.4), -1.5, 1.5);
    const Vector3d eye = direction(thetaEye, random.between(-3, 3));
    const Vector3d light = direction(thetaLight, random.between(-3, 3));
    const double offset = model == kNear ? random.between(-0.98, 0.98) : 0;
    result.samples.push_back(sample(eye, light, base, offset));
    Vector3d value;
    for (int c = 0; c < 3; ++c) {
      f.absorption = reference::absorptionOf(base[c], f.betaN);
      value[c] = kPi * (model == kNear ? reference::nearScattering(f, kTangent, eye, light, offset)
                                       : reference::farScattering(f, kTangent, eye, light, 120));
    }
    result.light.push_back(value);
  }
  return result;
}

TEST_P(FiberShading, IsTheModelOfThePapers) {
  // The same for all APIs.
  static const std::vector<Expected> all = [] {
    std::vector<Expected> cases;
    for (const uint32_t model : {kNear, kFar})
      for (const float betaN : {0.2f, 0.3f, 0.5f, 0.8f}) cases.push_back(expectedOf(model, betaN));
    return cases;
  }();
  for (const Expected& expected : all) {
    const std::vector<Float4> shaded = shade({expected.material}, expected.samples);
    double sum = 0, off = 0, peak = 0, most = 0;
    for (size_t i = 0; i < shaded.size(); ++i) {
      const Vector3d error = (toVector(shaded[i]) - expected.light[i]).cwiseAbs();
      sum += expected.light[i].sum();
      off += error.sum();
      keepLargest(peak, expected.light[i].maxCoeff());
      keepLargest(most, error.maxCoeff<Eigen::PropagateNaN>());
    }
    const bool near = expected.material.model.x == kNear;
    const float betaN = expected.material.fiber.y;
    RecordProperty((near ? "near_" : "far_") + std::to_string(static_cast<int>(betaN * 10)),
                   std::to_string(most / peak) + " " + std::to_string(off / sum));
    // Four parts of half the width stand for all offsets.
    EXPECT_LT(most / peak, near ? 1e-4 : betaN < 0.25f ? 0.06 : 0.03) << "beta_n " << betaN;
    EXPECT_LT(off / sum, near ? 1e-4 : betaN < 0.25f ? 0.05 : 0.02) << "beta_n " << betaN;
  }
}

TEST_P(FiberShading, IsReciprocalWhereLightAndEyeAreAsFarFromTheNormal) {
  // Attenuation goes by the angle of the eye (Chiang et al. 2016): with scales, or at other angles,
  // the model is not reciprocal.
  Random random(3);
  std::vector<StrandShading> materials = {fiber(kFar, 0.3f, 0.3f, 0), fiber(kFar, 0.5f, 0.7f, 0)};
  materials[1].body.z = 0.3f;
  std::vector<ShadeSample> samples;
  for (int i = 0; i < 60; ++i) {
    const double theta = random.between(0, 1.3);
    const Vector3d a = direction(theta, random.between(-3, 3));
    const Vector3d b = direction(i % 2 == 0 ? -theta : theta, random.between(-3, 3));
    samples.push_back(sample(a, b, {0.8, 0.3, 0.1}, 0, i % 4 / 2));
    samples.push_back(sample(b, a, {0.8, 0.3, 0.1}, 0, i % 4 / 2));
  }
  const std::vector<Float4> shaded = shade(materials, samples);
  for (size_t i = 0; i < shaded.size(); i += 2) {
    const Vector3d one = toVector(shaded[i]), other = toVector(shaded[i + 1]);
    EXPECT_LT((one - other).norm(), 2e-3 * one.norm() + 1e-6);
  }
}

/// Angle of the light with the largest value.
double peakOf(const std::vector<double>& thetas, const std::vector<double>& values) {
  const auto best = std::max_element(values.begin(), values.end()) - values.begin();
  return thetas[static_cast<size_t>(best)];
}

TEST_P(FiberShading, LeansThePrimaryToTheRootAndTheSecondaryToTheTip) {
  constexpr double kStep = 0.002;
  std::vector<double> thetas;
  for (double t = -1.2; t <= 1.2; t += kStep) thetas.push_back(t);
  StrandShading primary = kajiyaKay(), secondary = kajiyaKay();
  primary.body.x = secondary.body.x = primary.secondary.x = secondary.primary.x = 0;
  const std::vector<StrandShading> materials = {fiber(kFar, 0.1f, 0.3f, 0.04f), primary, secondary};
  for (const double eye : {0.0, 0.5, -0.7}) {
    std::vector<ShadeSample> samples;
    for (const double material : {0.0, 1.0, 2.0})
      for (const double t : thetas)
        samples.push_back(sample(direction(eye, 1), direction(t, 1), {0, 0.4, 0.9}, 0, material));
    const std::vector<Float4> shaded = shade(materials, samples);
    std::vector<double> r, trt, first, second;
    const size_t n = thetas.size();
    for (size_t i = 0; i < n; ++i) {
      // Red is absorbed but for R; what blue has more than that came from the inside.
      r.push_back(static_cast<double>(shaded[i].x));
      trt.push_back(static_cast<double>(shaded[i].z - shaded[i].x));
      first.push_back(static_cast<double>(shaded[n + i].z));
      second.push_back(static_cast<double>(shaded[2 * n + i].z));
    }
    // The model's peak is off the cone of mirrors by about the variance (d'Eon et al. 2011).
    EXPECT_NEAR(peakOf(thetas, r), -eye - 2 * 0.04, 0.012);
    EXPECT_NEAR(peakOf(thetas, trt), -eye + 4 * 0.04, 0.03);
    EXPECT_NEAR(peakOf(thetas, first), -eye + 2 * std::atan(-0.06), 2 * kStep);
    EXPECT_NEAR(peakOf(thetas, second), -eye + 2 * std::atan(0.12), 2 * kStep);
  }
}

TEST_P(FiberShading, TintsTheSecondaryHighlightOnly) {
  StrandShading m = kajiyaKay();
  m.body.x = 0;
  // Where both highlights are, without and with the base colour in the second.
  const Vector3d up = direction(0, 1);
  StrandShading plain = m;
  plain.secondary.w = 0;
  StrandShading first = m;
  first.secondary.x = 0;
  const std::vector<Float4> shaded = shade(
      {m, plain, first}, {sample(up, up, {0.5, 0, 1}, 0, 0), sample(up, up, {0.5, 0, 1}, 0, 1),
                          sample(up, up, {0.5, 0, 1}, 0, 2)});
  const float white = shaded[2].x, both = shaded[1].x;
  ASSERT_GT(both, white);
  EXPECT_FLOAT_EQ(shaded[2].y, white);
  EXPECT_NEAR(shaded[0].x, white + 0.5f * (both - white), 1e-5f);
  EXPECT_NEAR(shaded[0].y, white, 1e-6f);
  EXPECT_NEAR(shaded[0].z, both, 1e-6f);
}

TEST_P(FiberShading, KajiyaKayStaysInItsBounds) {
  StrandShading diffuse = kajiyaKay();
  diffuse.primary.x = diffuse.secondary.x = 0;
  diffuse.body.x = static_cast<float>(1 / kPi);
  const StrandShading all = kajiyaKay();
  std::vector<ShadeSample> samples;
  for (const double theta : {0.0, 0.9, -1.4}) {
    samples.push_back(sample(direction(theta, 0), kNoLight, {0.7, 1, 0}, 0, 0));
    samples.push_back(sample(direction(theta, 0), kNoLight, {0.7, 1, 0}, 0, 1));
  }
  const std::vector<Vector3d> sums = sumLight({diffuse, all}, samples);
  for (size_t i = 0; i < sums.size(); i += 2) {
    // A strength of 1 / pi sends on the base colour's share: sin over the sphere is pi^2.
    EXPECT_LT((sums[i] - Vector3d(0.7, 1, 0)).norm(), 1e-3);
    // Highlights add at most their strength over the whole sphere, of 4 pi.
    for (int c = 0; c < 3; ++c)
      EXPECT_LE(sums[i + 1][c], kPi * samples[i].base.y + 4 * (0.35 + 0.45));
  }
  Random random(11);
  std::vector<ShadeSample> single;
  for (int i = 0; i < 2000; ++i)
    single.push_back(
        sample(random.vector(1).normalized(), random.vector(1).normalized(), {0.3, 0.6, 1}));
  const std::vector<Float4> shaded = shade({all}, single);
  for (const Float4& value : shaded) {
    EXPECT_LE(value.x, 0.3f + 0.35f + 0.45f * 0.3f + 1e-5f);
    EXPECT_LE(value.z, 1 + 0.35f + 0.45f + 1e-5f);
    EXPECT_GE(value.x, 0);
  }
}

TEST_P(FiberShading, KajiyaKayIsItsFormulas) {
  Random random(5);
  const StrandShading m = kajiyaKay();
  std::vector<ShadeSample> samples;
  std::vector<Vector3d> expected;
  const Vector3d base(0.5, 0.2, 0.05);
  for (int i = 0; i < 500; ++i) {
    const Vector3d eye = random.vector(1).normalized(), light = random.vector(1).normalized();
    samples.push_back(sample(eye, light, base));
    const double diffuse = std::sin(std::acos(kTangent.dot(light)));
    const Vector3d normal = kTangent.cross(eye).cross(kTangent).normalized();
    const Vector3d half = (eye + light).normalized();
    const auto highlight = [&](const Float4& lobe) {
      const double cosine =
          (kTangent - normal * static_cast<double>(lobe.z)).normalized().dot(half);
      const double t = std::min(cosine + 1, 1.0);
      return static_cast<double>(lobe.x) * t * t * (3 - 2 * t) *
             std::pow(std::sin(std::acos(cosine)), static_cast<double>(lobe.y));
    };
    expected.push_back(base * (diffuse + highlight(m.secondary)) +
                       Vector3d::Constant(highlight(m.primary)));
  }
  const std::vector<Float4> shaded = shade({m}, samples);
  for (size_t i = 0; i < shaded.size(); ++i)
    EXPECT_LT((toVector(shaded[i]) - expected[i]).norm(), 1e-4);
}

TEST_P(FiberShading, WeakensLightWithItsDistance) {
  ShadeSample far = sample(direction(0, 0), 2 * direction(0.2, 1), {1, 1, 1});
  ShadeSample near = far;
  far.light.w = 1;
  ShadeSample inside = far;
  inside.light = {0, 0, 0, 1};
  StrandShading m = kajiyaKay();
  m.body.y = 0.25f;
  const std::vector<Float4> shaded = shade({m}, {near, far, inside});
  EXPECT_NEAR(shaded[1].x, shaded[0].x / 4, 1e-5f);
  EXPECT_FLOAT_EQ(shaded[0].w, 0.25f);
  EXPECT_TRUE(isFinite(shaded[2]));
}

TEST_P(FiberShading, TakesDirectionsOfAnyLength) {
  const std::vector<StrandShading> materials = {kajiyaKay(), fiber(kFar, 0.3f, 0.3f),
                                                fiber(kNear, 0.3f, 0.3f)};
  std::vector<ShadeSample> samples;
  for (const double material : {0.0, 1.0, 2.0}) {
    samples.push_back(
        sample(direction(0.1, 0), direction(-0.2, 1), {0.8, 0.3, 0.1}, 0.2, material));
    samples.push_back(
        sample(3 * direction(0.1, 0), 0.2 * direction(-0.2, 1), {0.8, 0.3, 0.1}, 0.2, material));
    samples.back().tangent = toFloat4(7 * kTangent, material);
  }
  const std::vector<Float4> shaded = shade(materials, samples);
  for (size_t i = 0; i < shaded.size(); i += 2)
    EXPECT_LT((toVector(shaded[i]) - toVector(shaded[i + 1])).norm(), 1e-4);
}

TEST_P(FiberShading, IsFiniteForAnyArgument) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  std::vector<StrandShading> materials;
  for (const uint32_t model : {kKajiyaKay, kFar, kNear, 77u})
    for (const double value : {0.0, 1.0, -1.0, 1e-30, 1e30, nan, inf, -inf}) {
      StrandShading m = kajiyaKay();
      m.model.x = model;
      const auto v = static_cast<float>(value);
      m.fiber = {v, v, v, v};
      materials.push_back(m);
      m.body = m.primary = m.secondary = m.fiber;
      materials.push_back(m);
      m.fiber = {0.3f, 0.3f, 0.03f, 1.55f};
      materials.push_back(m);
    }
  const std::vector<Vector3d> vectors = {{0, 0, 0},       kTangent,      -kTangent,
                                         direction(0, 0), {1e-20, 0, 0}, {1e25, 1, 0},
                                         {nan, 0, 1},     {0, -inf, 0},  direction(1.5706, 2)};
  const std::vector<Vector3d> bases = {
      {0, 0, 0}, {1, 1, 1}, {1e30, 0.5, -3}, {nan, inf, -inf}, {1e-30, 0.2, 1}};
  std::vector<ShadeSample> samples;
  Random random(1);
  const auto pick = [&](const auto& from) {
    return from[static_cast<size_t>(random.unit() * static_cast<double>(from.size()))];
  };
  const std::vector<double> offsets = {0, 1, -1, 0.5, 7, nan, -inf};
  for (size_t m = 0; m < materials.size(); ++m)
    for (int i = 0; i < 60; ++i) {
      ShadeSample s = sample(pick(vectors), pick(vectors), pick(bases), pick(offsets));
      if (i % 3 == 0) s.tangent = toFloat4(pick(vectors));
      if (i % 5 == 0) s.light.w = 1;
      s.tangent.w = static_cast<float>(m);
      samples.push_back(s);
    }
  const std::vector<Float4> shaded = shade(materials, samples);
  for (size_t i = 0; i < shaded.size(); ++i) {
    const Float4& v = shaded[i];
    ASSERT_TRUE(isFinite(v) && std::min({v.x, v.y, v.z, v.w}) >= 0)
        << "sample " << i << " of material " << i / 60 << ": " << v.x << " " << v.y << " " << v.z
        << " " << v.w;
  }
}

}  // namespace
}  // namespace pelage::test
