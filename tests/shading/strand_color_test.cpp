// The color of a strand from its root to its tip, as scenes draw it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "support/errors.h"
#include "support/extremes.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

constexpr uint32_t kRowPixels = 128, kRowVertices = 33;

class StrandColor : public SceneRunTest<> {
 protected:
  void SetUp() override {
    SceneRunTest::SetUp();
    if (run_.device() == nullptr) return;
    HairAsset asset;
    asset.strandCount = 1;
    asset.verticesPerStrand = kRowVertices;
    for (uint32_t v = 0; v < kRowVertices; ++v)
      asset.positions.push_back(
          {-0.2f + 0.4f * static_cast<float>(v) / (kRowVertices - 1), 0, 0, v < 2 ? 0.0f : 1.0f});
    expectOk(asset.process());
    HairObject& hair = run_.add(asset);
    hair.simulated = false;
    StrandMaterial& m = hair.material;
    m.rootColor = {0.2f, 0.6f, 0};
    m.tipColor = {0.8f, 0, 0.4f};
    m.colorVariation = m.diffuseStrength = m.primaryStrength = m.secondaryStrength = 0;
    m.fiberRadius = 0.02f;
    m.tipRadiusRatio = 1;
    run_.step();
  }
  /// Colors of the row across the middle of the strand, from one side to the other.
  std::vector<Float4> row(const Light& light = {.color = {0, 0, 0}, .ambient = {1, 1, 1}}) {
    const View view =
        cameraView({.eye = {0, 0, 1}, .fov = 2 * std::atan(0.2f), .width = kRowPixels});
    PassList list;
    expectOk(run_.scene.draw(view, light, list));
    const auto image = run_.renderLists({&list, 1}, {.width = kRowPixels, .height = kRowPixels});
    EXPECT_TRUE(image) << image.error().message;
    if (!image) return {};
    const auto first = image->pixels.begin() + ptrdiff_t{kRowPixels} * (kRowPixels / 2);
    return {first, first + kRowPixels};
  }
};

TEST_P(StrandColor, TheTipsColorFadesInOverItsShare) {
  StrandMaterial& m = run_.scene.hair(run_.lastHair()).material;
  for (const float share : {1.0f, 0.5f, 0.25f, 0.0f}) {
    m.tipShare = share;
    const std::vector<Float4> pixels = row();
    ASSERT_EQ(pixels.size(), kRowPixels);
    double worst = 0;
    for (uint32_t x = 2; x + 2 < kRowPixels; ++x) {
      const double along = (x + 0.5) / kRowPixels, s = double{share};
      const double tip = s > 0 ? std::clamp((along - (1 - s)) / s, 0.0, 1.0) : 0;
      ASSERT_GT(pixels[x].w, 0.99f) << x;
      keepLargest(worst, std::abs(double{pixels[x].x} - (0.2 + 0.6 * tip)));
      keepLargest(worst, std::abs(double{pixels[x].y} - (0.6 - 0.6 * tip)));
      keepLargest(worst, std::abs(double{pixels[x].z} - 0.4 * tip));
    }
    // The target has 16 bits.
    EXPECT_LT(worst, 2e-3) << share;
  }
}

/// Radiance of an environment, red, by the functions of Ramamoorthi and Hanrahan 2001.
double radianceOf(const EnvironmentLight& e, const Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z();
  const auto red = [](const Float3& color) { return static_cast<double>(color.x); };
  return 0.282095 * red(e.l00) + 0.488603 * (red(e.l1m1) * y + red(e.l10) * z + red(e.l11) * x) +
         1.092548 * (red(e.l2m2) * x * y + red(e.l2m1) * y * z + red(e.l21) * x * z) +
         0.315392 * red(e.l20) * (3 * z * z - 1) + 0.546274 * red(e.l22) * (x * x - y * y);
}

TEST_P(StrandColor, TakesAnEnvironmentByTheSineToTheFiber) {
  StrandMaterial& m = run_.scene.hair(run_.lastHair()).material;
  m.rootColor = m.tipColor = {0.5f, 0.5f, 0.5f};
  const auto lightOf = [&](const EnvironmentLight& environment) {
    const std::vector<Float4> pixels =
        row({.color = {0, 0, 0}, .ambient = {0, 0, 0}, .environment = environment});
    return pixels.size() == kRowPixels ? static_cast<double>(pixels[kRowPixels / 2].x) : -1;
  };
  // The fiber lies along x, and shows its side along z.
  for (Float3 EnvironmentLight::*band :
       {&EnvironmentLight::l1m1, &EnvironmentLight::l10, &EnvironmentLight::l11,
        &EnvironmentLight::l2m2, &EnvironmentLight::l2m1, &EnvironmentLight::l20,
        &EnvironmentLight::l21, &EnvironmentLight::l22}) {
    EnvironmentLight one;
    one.l00 = {4, 0, 0};
    one.*band = {0.8f, 0, 0};
    double sum = 0, weights = 0;
    constexpr int kSteps = 160;
    for (int i = 0; i < kSteps; ++i)
      for (int k = 0; k < kSteps; ++k) {
        const double along = (i + 0.5) / kSteps * 2 - 1,
                     around = (k + 0.5) / kSteps * 2 * std::numbers::pi;
        const double sine = std::sqrt(1 - along * along);
        sum += sine * radianceOf(one, {along, sine * std::cos(around), sine * std::sin(around)});
        weights += sine;
      }
    const double facing = 0.488603 * static_cast<double>(one.l10.x);
    EXPECT_NEAR(lightOf(one), 0.5 * (sum / weights + 2.0 / 3 * facing), 2e-3);
  }
  // Nothing comes from where the sum is negative.
  EXPECT_EQ(lightOf({.l00 = {-1, 0, 0}}), 0);
}

INSTANTIATE_TEST_SUITE_P(All, StrandColor, testing::ValuesIn(kApis), apiTestName);

TEST(StrandColorErrors, NameAShareThatIsNoNumber) {
  Scene scene;
  HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = 2;
  asset.positions = {{0, 0, 0, 0}, {0, 0.1f, 0, 0}};
  expectOk(asset.process());
  const auto hair = required(scene.addHair(asset, {}));
  scene.hair(*hair).material.tipShare = std::numeric_limits<float>::quiet_NaN();
  const View view = cameraView({.eye = {0, 0, 1}, .fov = 0.8f, .width = 8});
  PassList list;
  expectError(scene.draw(view, {}, list), "tipShare");
}

}  // namespace
}  // namespace pelage::test
