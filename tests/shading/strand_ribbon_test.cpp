// The ribbons of strand_common.hlsli: width is kept, however thin a fiber is, and nothing breaks
// them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pelage/view.h"
#include "reference/strand_reference.h"
#include "shading_test/gpu_structs.h"
#include "shading_test/kernels.h"
#include "support/matrices.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using shading_test::RibbonConstants;
using shading_test::RibbonResult;
using shading_test::RibbonSample;

constexpr float kViewWidth = 640, kViewHeight = 360;

class StrandRibbon : public GpuTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    const Matrix4 clip =
        lookAt({0.1f, 0.2f, 1}, {0, 0, 0}, {0, 1, 0}, 0.9f, kViewWidth / kViewHeight, 0.1f, 10.0f);
    std::copy(std::begin(clip.rows), std::end(clip.rows), std::begin(constants_.ribbonClip));
    constants_.ribbonEye = {0.1f, 0.2f, 1, 1};
    constants_.ribbonViewport = {0, 0, kViewWidth, kViewHeight};
    worldToClip_ = toMatrix(clip);
  }

  std::vector<RibbonResult> measure(const std::vector<RibbonSample>& samples) {
    const GuardedBuffer<RibbonSample> given(gpu(), "samples", samples);
    const GuardedBuffer<RibbonResult> results(gpu(), "results",
                                              std::vector<RibbonResult>(samples.size()));
    run(shading_test::measureRibbonsVariant(), samples.size(), [&](PassBuilder& builder) {
      given.bindTo(builder, "g_ribbonSamples");
      results.bindTo(builder, "g_ribbonResults");
    });
    return results.read();
  }

  std::vector<float> cover(const std::vector<Float2>& samples) {
    const GuardedBuffer<Float2> given(gpu(), "pixels", samples);
    const GuardedBuffer<float> results(gpu(), "coverage", std::vector<float>(samples.size()));
    run(shading_test::coverPixelsVariant(), samples.size(), [&](PassBuilder& builder) {
      given.bindTo(builder, "g_pixelSamples");
      results.bindTo(builder, "g_pixelCoverage");
    });
    return results.read();
  }

  static Eigen::Vector2d pixelOf(const Float4& clip) {
    const auto w = static_cast<double>(clip.w);
    return {(static_cast<double>(clip.x) / w * 0.5 + 0.5) * double{kViewWidth},
            (static_cast<double>(clip.y) / w * 0.5 + 0.5) * double{kViewHeight}};
  }
  Eigen::Vector2d pixelOf(const Vector3d& p) const {
    const Eigen::Vector4d clip = worldToClip_ * p.homogeneous();
    return {(clip.x() / clip.w() * 0.5 + 0.5) * double{kViewWidth},
            (clip.y() / clip.w() * 0.5 + 0.5) * double{kViewHeight}};
  }

  Eigen::Matrix4d worldToClip_;

 private:
  template <class Bind>
  void run(const KernelVariant& kernel, size_t count, const Bind& bind) {
    constants_.ribbonCount = static_cast<uint32_t>(count);
    dispatch(gpu(), kernel, count, [&](PassBuilder& pass) {
      bind(pass);
      pass.constants("RibbonConstants", constants_);
    });
  }

  RibbonConstants constants_ = {};
};
INSTANTIATE_TEST_SUITE_P(All, StrandRibbon, ::testing::ValuesIn(kApis), apiTestName);

TEST_P(StrandRibbon, CoversItsWidthWhereverItLiesInThePixels) {
  const std::vector<double> widths = {0.01, 0.03, 0.1, 0.3, 0.7, 0.99, 1, 1.5, 3.2, 7.77, 20};
  constexpr int kOffsets = 37, kRange = 12;
  std::vector<Float2> samples;
  for (const double width : widths)
    for (int offset = 0; offset < kOffsets; ++offset)
      for (int pixel = -kRange; pixel <= kRange; ++pixel)
        samples.push_back(
            {static_cast<float>(pixel + (offset + 0.3) / kOffsets), static_cast<float>(width / 2)});
  const std::vector<float> coverage = cover(samples);
  size_t at = 0;
  for (const double width : widths)
    for (int offset = 0; offset < kOffsets; ++offset) {
      double sum = 0;
      for (int pixel = -kRange; pixel <= kRange; ++pixel, ++at) {
        EXPECT_GE(coverage[at], 0);
        EXPECT_LE(coverage[at], std::min(1.0, width) + 1e-6);
        // The ribbon has every pixel that is covered at all.
        if (std::abs(static_cast<double>(samples[at].x)) > width / 2 + 0.5 + 1e-6) {
          EXPECT_EQ(coverage[at], 0);
        }
        sum += static_cast<double>(coverage[at]);
      }
      EXPECT_NEAR(sum, width, 1e-3 * width) << "width " << width << " offset " << offset;
    }
}

TEST_P(StrandRibbon, ReachesHalfAPixelPastTheFiberOnBothSides) {
  Random random(9);
  std::vector<RibbonSample> samples;
  for (int i = 0; i < 300; ++i) {
    const Vector3d position = random.vector(0.25), tangent = random.vector(1).normalized();
    const double radius = std::pow(10, random.between(-6, -2));
    for (const double side : {-1.0, 1.0})
      samples.push_back({toFloat4(position, radius), toFloat4(tangent, side)});
  }
  const std::vector<RibbonResult> results = measure(samples);
  const Vector3d eye(double{0.1f}, double{0.2f}, 1);
  for (size_t i = 0; i < results.size(); i += 2) {
    const RibbonResult &low = results[i], &high = results[i + 1];
    const Vector3d position = toVector(samples[i].position), tangent = toVector(samples[i].tangent);
    const double width =
        reference::projectedWidth(worldToClip_, {double{kViewWidth}, double{kViewHeight}}, eye,
                                  position, tangent, static_cast<double>(samples[i].position.w));
    EXPECT_NEAR(2 * static_cast<double>(low.values.y), width, 1e-3 * width);
    EXPECT_EQ(low.values.y, high.values.y);
    EXPECT_FLOAT_EQ(high.values.x, high.values.y + 0.5f);
    EXPECT_FLOAT_EQ(low.values.x, -high.values.x);
    // Corners are where their distance says.
    const Eigen::Vector2d center = pixelOf(position);
    const Eigen::Vector2d across = pixelOf(high.smoothClip) - pixelOf(low.smoothClip);
    EXPECT_NEAR(across.norm(), width + 1, 1e-3 * width + 2e-3);
    EXPECT_LT(((pixelOf(high.smoothClip) + pixelOf(low.smoothClip)) / 2 - center).norm(), 2e-3);
    // Nearly along the line of sight there is little left of the direction in floats.
    const double sine = tangent.cross(eye - position).norm() / (eye - position).norm();
    const Eigen::Vector2d along = pixelOf(position + 1e-6 * tangent) - center;
    EXPECT_LT(std::abs(across.normalized().dot(along.normalized())), 5e-4 + 4e-6 / sine);
    // The other ribbon is the same fiber: what it is wider, it is fainter.
    const double shown = (pixelOf(high.clip) - pixelOf(low.clip)).norm();
    EXPECT_NEAR(shown * static_cast<double>(high.values.z), width, 2e-3 * width + 1e-6);
  }
}

TEST_P(StrandRibbon, HasNoWidthThatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Vector3d inFront(0.05, 0.02, 0), sight = (Vector3d(0.1, 0.2, 1) - inFront).normalized();
  std::vector<RibbonSample> samples;
  for (const Vector3d& position :
       {inFront, Vector3d(0.1, 0.2, 1), Vector3d(0.1, 0.2, 5), Vector3d(0, 0, 0.9999)})
    for (const Vector3d& tangent :
         {Vector3d(0, 0, 0), sight, Vector3d(0, 1, 0), Vector3d(nan, 0, 1), Vector3d(inf, 0, 0)})
      for (const double radius : {1e-4, 0.0, -1.0, nan, inf, 1e20})
        samples.push_back({toFloat4(position, radius), toFloat4(tangent, 1)});
  const std::vector<RibbonResult> results = measure(samples);
  std::vector<Float2> pixels;
  for (const RibbonResult& result : results) {
    EXPECT_TRUE(isFinite(result.smoothClip));
    EXPECT_TRUE(std::isfinite(result.values.x) && std::isfinite(result.values.y));
    EXPECT_GE(result.values.y, 0);
    EXPECT_LE(std::abs(result.values.x), result.values.y + 0.5f);
    for (const double distance : {0.0, 0.4, nan, inf})
      pixels.push_back({static_cast<float>(distance), result.values.y});
  }
  pixels.push_back({0, static_cast<float>(nan)});
  pixels.push_back({0, -1});
  pixels.push_back({0, static_cast<float>(inf)});
  for (const float share : cover(pixels)) EXPECT_TRUE(share >= 0 && share <= 1) << share;
  // A tangent along the line of sight, or none, still has the fiber's width.
  EXPECT_NEAR(results[6].values.y, results[12].values.y, 0.02 * results[12].values.y);
  EXPECT_NEAR(results[0].values.y, results[12].values.y, 0.02 * results[12].values.y);
}

}  // namespace
}  // namespace pelage::test
