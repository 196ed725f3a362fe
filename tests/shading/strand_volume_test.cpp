// Light that passes from fiber to fiber: slabs and a ball of fibers reflect and transmit what a
// path tracer says, and nothing is added or not finite.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "reference/shading/fiber_volume.h"
#include "shading_test/gpu_structs.h"
#include "shading_test/kernels.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using reference::EyeRay;
using reference::FiberBody;
using reference::FiberPoint;
using reference::kFiberAxis;
using shading_test::ShadeConstants;
using shading_test::ShadeSample;
using shading_test::StrandShading;

constexpr double kEndless = 1e6;  // optical depth
const Vector3d kUp(0, 0, 1);      // from which light comes
// Dark brown, brown and light brown: 0.025 to 0.42.
const std::vector<Vector3d> kColors = {
    {0.030, 0.025, 0.040}, {0.12, 0.08, 0.16}, {0.35, 0.28, 0.42}};

StrandShading fiberMaterial(float share) {
  StrandShading m;
  m.model = {1, 0, 0, 0};
  m.body = {1, 1, 0, share};
  m.fiber = {0.25f, 0.3f, 0.035f, 1.55f};
  return m;
}

/// Points that are spread evenly over the unit cube, by powers of a ratio (Roberts, "The
/// unreasonable effectiveness of quasirandom sequences", 2018): `ratio`^(N + 1) = `ratio` + 1.
template <size_t N>
std::array<double, N> spreadPoint(int index, double ratio) {
  std::array<double, N> point;
  double step = 1;
  for (double& x : point) {
    step /= ratio;
    x = std::fmod(0.5 + index * step, 1.0);
  }
  return point;
}

/// Rays that leave a slab upwards, or downwards, with the density of a Lambert surface's light.
std::vector<EyeRay> slabRays(double thickness, bool up, int count) {
  std::vector<EyeRay> rays;
  for (int i = 0; i < count; ++i) {
    const auto [squared, turn] = spreadPoint<2>(i, 1.32471795724474603);
    const double around = 2 * std::numbers::pi * turn;
    const double side = std::sqrt(1 - squared), z = std::sqrt(squared);
    rays.push_back({Vector3d(0, 0, up ? 0 : -thickness),
                    {side * std::cos(around), side * std::sin(around), up ? z : -z}});
  }
  return rays;
}

/// Rays that leave a ball in directions with z > 0, or z < 0.
std::vector<EyeRay> ballRays(double radius, bool up, int count) {
  std::vector<EyeRay> rays;
  for (int i = 0; i < count; ++i) {
    const auto [z, turn, squared, roll] = spreadPoint<4>(i, 1.16730397826141868);
    const double around = 2 * std::numbers::pi * turn, at = 2 * std::numbers::pi * roll;
    const double side = std::sqrt(1 - z * z);
    const Vector3d toEye(side * std::cos(around), side * std::sin(around), up ? z : -z);
    const Vector3d x = toEye.unitOrthogonal(), y = toEye.cross(x);
    const double out = radius * std::sqrt(squared);
    rays.push_back({x * (out * std::cos(at)) + y * (out * std::sin(at)) +
                        toEye * std::sqrt(radius * radius - out * out),
                    toEye});
  }
  return rays;
}

class StrandVolume : public GpuTest {
 protected:
  std::vector<Float4> shade(const StrandShading& material, const std::vector<ShadeSample>& samples,
                            bool sky) {
    const auto count = static_cast<uint32_t>(samples.size());
    const GuardedBuffer<ShadeSample> sampleBuffer(gpu(), "samples", samples);
    const GuardedBuffer<StrandShading> materialBuffer(gpu(), "materials",
                                                      std::vector<StrandShading>{material});
    const GuardedBuffer<Float4> results(gpu(), "results", std::vector<Float4>(samples.size()));
    dispatch(gpu(), shading_test::shadeVolumeVariant(), samples.size(), [&](PassBuilder& pass) {
      sampleBuffer.bindTo(pass, "g_shadeSamples");
      materialBuffer.bindTo(pass, "g_shadeMaterials");
      results.bindTo(pass, "g_shaded");
      pass.constants("ShadeConstants", ShadeConstants{count, 1, 1, sky ? 1u : 0u});
    });
    return results.read();
  }

  /// The mean light to the eye along rays that the kernels find: of each ray, at the first fiber.
  Vector3d lightOfKernels(const FiberBody& body, double across, const Vector3d& color,
                          const std::vector<EyeRay>& rays, bool sky, Random& random) {
    std::vector<ShadeSample> samples;
    for (const EyeRay& ray : rays) {
      const FiberPoint at =
          reference::firstFiber(body, ray, random.unit() * reference::fiberShare(body, ray));
      // Light comes straight down, across the fibers.
      samples.push_back({toFloat4(kFiberAxis, 0), toFloat4(ray.toEye, body.toEnd(at.position, kUp)),
                         toFloat4(color, body.toEnd(at.position, -kUp)), toFloat4(kUp, across)});
    }
    const std::vector<Float4> light = shade(fiberMaterial(1), samples, sky);
    Vector3d sum = Vector3d::Zero();
    for (size_t i = 0; i < rays.size(); ++i)
      sum += reference::fiberShare(body, rays[i]) * toVector(light[i]);
    return sum / static_cast<double>(rays.size());
  }
};
INSTANTIATE_TEST_SUITE_P(All, StrandVolume, ::testing::ValuesIn(kApis), apiTestName);

/// Light of a body in three colors, by the path tracer.
struct TracedLight {
  std::string name;
  FiberBody body;
  double across;
  std::vector<EyeRay> rays;
  bool sky;
  std::vector<Vector3d> light;  // [color]
};

TracedLight traced(std::string name, const FiberBody& body, double across, std::vector<EyeRay> rays,
                   bool sky, int paths) {
  TracedLight result{std::move(name), body, across, std::move(rays), sky, {}};
  std::vector<EyeRay> all;
  while (static_cast<int>(all.size()) < paths)
    all.insert(all.end(), result.rays.begin(), result.rays.end());
  const reference::Fiber fiber{.betaM = 0.25, .betaN = 0.3, .tilt = 0.035};
  std::vector<double> absorptions;
  for (const Vector3d& color : kColors)
    for (const double albedo : color)
      absorptions.push_back(reference::absorptionOf(albedo, fiber.betaN));
  const std::vector<double> light =
      reference::lightOfPaths(body, fiber, absorptions, sky ? Vector3d::Zero() : kUp, all, 7);
  for (size_t i = 0; i < kColors.size(); ++i)
    result.light.emplace_back(light[3 * i], light[3 * i + 1], light[3 * i + 2]);
  return result;
}

const std::vector<TracedLight>& allTraced() {
  static const std::vector<TracedLight> all = [] {
    constexpr int kRays = 32000, kPaths = 64000;
    const FiberBody thin = reference::fiberSlab(4), thick = reference::fiberSlab(12),
                    ball = reference::fiberBall(3);
    std::vector<TracedLight> cases;
    for (const bool up : {true, false})
      cases.push_back(traced(up ? "slab_4_reflects" : "slab_4_transmits", thin, kEndless,
                             slabRays(4, up, kRays), false, kPaths));
    // Nothing that can be seen passes the thick slab, nor is seen through it.
    for (const bool sky : {false, true})
      cases.push_back(traced(sky ? "slab_12_reflects_sky" : "slab_12_reflects", thick, kEndless,
                             slabRays(12, true, kRays), sky, kPaths));
    for (const bool up : {true, false})
      cases.push_back(traced(up ? "ball_6_reflects" : "ball_6_transmits", ball, 6,
                             ballRays(3, up, kRays), false, kPaths));
    return cases;
  }();
  return all;
}

TEST_P(StrandVolume, SendsOnTheLightThatPathsFind) {
  Random random(5);
  for (const TracedLight& e : allTraced()) {
    double worst = 0;
    for (size_t i = 0; i < kColors.size(); ++i) {
      const Vector3d light = lightOfKernels(e.body, e.across, kColors[i], e.rays, e.sky, random);
      // The light of three near colors is more precise than that of one.
      const double share = light.sum() / e.light[i].sum() - 1;
      EXPECT_LT(std::abs(share), 0.06) << e.name << ", color " << i << ": " << light.transpose()
                                       << " for " << e.light[i].transpose();
      RecordProperty(e.name + "_" + std::to_string(i), std::to_string(100 * share) + " %");
      keepLargest(worst, std::abs(share));
    }
    RecordProperty(e.name, std::to_string(worst));
  }
}

TEST_P(StrandVolume, ShinesOnTheEdgeOfDenseHairWithoutAMap) {
  constexpr double kDense = 16;  // optical depth
  std::vector<ShadeSample> samples;
  const Vector3d toEye = Vector3d(0, 1, 2).normalized();
  for (const Vector3d& color : kColors)
    for (const double front : {-1.0, 0.0})
      samples.push_back({toFloat4(kFiberAxis, 0), toFloat4(toEye, front), toFloat4(color, kDense),
                         toFloat4(kUp, kDense)});
  const std::vector<Float4> together = shade(fiberMaterial(1), samples, false);
  const std::vector<Float4> alone = shade(fiberMaterial(0), samples, false);
  for (size_t i = 0; i < samples.size(); i += 2) {
    const double open = toVector(together[i]).sum(), dense = toVector(together[i + 1]).sum();
    EXPECT_NEAR(open / dense, 1, 1e-5);
    EXPECT_GT(open, 1.05 * toVector(alone[i]).sum());
  }
}

}  // namespace
}  // namespace pelage::test
