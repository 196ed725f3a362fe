// Transparency::kHybrid* and kShortCut: a fixed number of layers a pixel, and what is left of the
// rest.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "oit/tangle.h"

namespace pelage::test {
namespace {

constexpr uint32_t kLayerPixels = 32, kStrands = 540;
constexpr Transparency kLayerMethods[] = {Transparency::kShortCut, Transparency::kHybrid4,
                                          Transparency::kHybrid8, Transparency::kHybrid16};

uint32_t layersOf(Transparency method) {
  return method == Transparency::kHybrid4    ? 4
         : method == Transparency::kHybrid8  ? 8
         : method == Transparency::kHybrid16 ? 16
                                             : 3;
}

// The error over the pixels of at most so many fragments.
CompositeError errorWithin(const RenderedImage& image, std::vector<ExactPixel> exact,
                           uint32_t layers) {
  for (ExactPixel& pixel : exact)
    if (pixel.fragments > layers) pixel = {};
  return compositeError(image, exact);
}

// Composite of the hair in view: the draws of lists have all that a capture needs.
std::vector<ExactPixel> exactOf(TangleRun& scene, const View& view) {
  scene.render(view, {.method = Transparency::kWindowed});
  return scene.exact(view);
}

class LayeredTransparency : public TangleTest {
 protected:
  /// Strands that lie at a z each, 2 cm wide and across the view.
  HairId addStack(Scene& scene, const std::vector<float>& depths, float opacity,
                  const std::vector<Float4>& colors = {}) {
    HairAsset stack;
    stack.strandCount = static_cast<uint32_t>(depths.size());
    stack.verticesPerStrand = 2;
    for (size_t s = 0; s < depths.size(); ++s) {
      stack.positions.push_back({-0.1f, 0, depths[s], 0});
      stack.positions.push_back({0.1f, 0, depths[s], 1});
      if (!colors.empty()) stack.vertexColor.insert(stack.vertexColor.end(), 2, colors[s]);
    }
    expectOk(stack.process());
    HairDef def = tangleHair({.radius = 0.02f, .opacity = opacity});
    if (!colors.empty()) def.material.rootColor = def.material.tipColor = {1, 1, 1};
    def.material.tipRadiusRatio = 1;
    return valueOf(scene.addHair(stack, def));
  }

  /// Clip z is the world's, w is 1.
  static View flatView(uint32_t pixels, bool reversedDepth) {
    View view;
    view.worldToClip.rows[0] = {20, 0, 0, 0};
    view.worldToClip.rows[1] = {0, 20, 0, 0};
    view.worldToClip.rows[2] = {0, 0, 1, 0};
    view.worldToClip.rows[3] = {0, 0, 0, 1};
    view.eye = {0, 0, reversedDepth ? 100.0f : -100.0f};
    view.width = view.height = pixels;
    view.reversedDepth = reversedDepth;
    return view;
  }
};

TEST_P(LayeredTransparency, IsExactWhereTheLayersSufficeAndTheBetterTheMoreThereAre) {
  // At least so many dB, whole picture.
  constexpr double kWanted[] = {23, 43, 54, 57};
  TangleRun& scene = tangleRun();
  scene.add({.strands = kStrands});
  for (const bool reversedDepth : {false, true}) {
    const float opacity = reversedDepth ? 1.0f : 0.33f;
    scene.hair().material.opacity = opacity;
    const View view = tangleView(kLayerPixels, reversedDepth);
    const std::vector<ExactPixel> exact = exactOf(scene, view);
    double last = 0;
    for (size_t i = 0; i < std::size(kLayerMethods); ++i) {
      const RenderedImage image = scene.render(view, {.method = kLayerMethods[i]});
      const uint32_t layers = layersOf(kLayerMethods[i]);
      const CompositeError error = compositeError(image, exact);
      const CompositeError within = errorWithin(image, exact, layers);
      std::cout << apiName(GetParam()) << " opacity " << opacity
                << (reversedDepth ? " reversed, " : ", ") << layers << " layers: PSNR "
                << error.psnr << " dB; where they suffice " << within.psnr << " dB, worst "
                << 255 * within.worst << "/255\n";
      ASSERT_GT(error.pixels, kLayerPixels * kLayerPixels / 2);
      EXPECT_GT(error.psnr, last) << layers << " layers";
      EXPECT_GE(error.psnr, kWanted[i]) << layers << " layers";
      last = error.psnr;
      EXPECT_GT(within.pixels, 100u);
      // The rounding of colours and alphas to a word.
      EXPECT_GE(within.psnr, 57) << layers << " layers";
      EXPECT_LE(within.worst, 2.5 / 255) << layers << " layers";
      // The transmittance is exact, whatever is in front.
      for (size_t p = 0; p < exact.size(); ++p) {
        ASSERT_NEAR(static_cast<double>(image.pixels[p].w), 1 - exact[p].transmittance, 0.008);
      }
    }
  }
}

TEST_P(LayeredTransparency, DoesNotDependOnTheOrderOfArrival) {  // K36
  std::vector<TransparencySettings> methods;
  for (const Transparency method : kLayerMethods) methods.push_back({.method = method});
  expectNoOrderOfStrands({.strands = kStrands}, tangleView(kLayerPixels), methods);
}

TEST_P(LayeredTransparency, TellsApartWhatIsAtOneDepth) {  // K38
  // Six of one depth, of different colours, and two of another.
  const std::vector<float> depths = {0.5f, 0.25f, 0.5f, 0.5f, 0.5f, 0.25f, 0.5f, 0.5f};
  std::vector<Float4> colors;
  for (size_t i = 0; i < depths.size(); ++i)
    colors.push_back({0.1f * static_cast<float>(i), 0.9f - 0.1f * static_cast<float>(i), 0.4f,
                      0.2f + 0.1f * static_cast<float>(i)});
  const View view = flatView(12, false);
  std::vector<RenderedImage> images[2];
  for (const bool reversed : {false, true}) {
    TangleRun scene(GetParam());
    std::vector<float> z = depths;
    std::vector<Float4> c = colors;
    if (reversed) std::reverse(z.begin(), z.end()), std::reverse(c.begin(), c.end());
    addStack(scene.run.scene, z, 1, c);
    scene.run.step();
    for (const Transparency method : kLayerMethods)
      images[reversed].push_back(scene.render(view, {.method = method}));
    double left = 1;
    for (const Float4& color : colors) left *= 1 - static_cast<double>(color.w);
    // All of them count, of whatever depth.
    for (const RenderedImage& image : images[reversed])
      EXPECT_NEAR(static_cast<double>(image.pixels[6 * 12 + 6].w), 1 - left, 0.01);
  }
  for (size_t i = 0; i < std::size(kLayerMethods); ++i)
    EXPECT_TRUE(sameBits(images[0][i], images[1][i])) << layersOf(kLayerMethods[i]);
}

TEST_P(LayeredTransparency, DrawsOverWhatIsOpaqueAndNotBehindIt) {
  TangleRun& scene = tangleRun();
  scene.add({.strands = kStrands});
  const HairId quad = addStack(scene.run.scene, {0.02f}, 1);
  scene.run.step();
  HairObject& wall = scene.run.scene.hair(quad);
  for (const bool reversedDepth : {false, true}) {
    const View view = tangleView(kLayerPixels, reversedDepth);
    const auto show = [&](bool opaque) {
      wall.visible = opaque;
      scene.hair().visible = !opaque;
    };
    // In a list of its own, before that of the hair.
    const auto drawWall = [&] {
      show(true);
      scene.lists.assign(1, {});
      expectOk(scene.run.scene.draw(view, tangleLights(), {.method = Transparency::kStochastic},
                                    scene.lists));
      show(false);
    };
    drawWall();
    const RenderedImage behind = scene.renderLists(view).value();
    // The exact composite of the hair that is not behind the wall.
    std::vector<PassList> hair(1);
    expectOk(scene.run.scene.draw(view, tangleLights(), {}, hair));
    const BufferId shadows = scene.run.scene.shadowWords();
    FragmentCapture capture(scene.resources(), 1 << 17);
    drawWall();
    scene.lists.push_back(hair[0]);
    scene.lists.emplace_back();
    capture.addDraws(hair[0], shadows, scene.lists.back());
    scene.renderLists(view);
    const std::vector<ExactPixel> exact =
        FragmentCapture::composite(capture.read(*scene.run.device()), view);

    for (const Transparency method : kLayerMethods) {
      drawWall();
      std::vector<PassList> lists(1);
      expectOk(scene.run.scene.draw(view, tangleLights(), {.method = method}, lists));
      std::move(lists.begin(), lists.end(), std::back_inserter(scene.lists));
      RenderedImage image = scene.renderLists(view).value();
      uint32_t covered = 0;
      for (size_t i = 0; i < image.pixels.size(); ++i) {
        Float4& p = image.pixels[i];
        const Float4& b = behind.pixels[i];
        if (exact[i].fragments == 0) {
          EXPECT_EQ(p, b) << "pixel " << i;
        }
        const auto through = static_cast<float>(exact[i].transmittance);
        covered += b.w > 0 && exact[i].fragments > 0 ? 1 : 0;
        p = {p.x - through * b.x, p.y - through * b.y, p.z - through * b.z, p.w - through * b.w};
      }
      EXPECT_GT(covered, 60u);
      const CompositeError within = errorWithin(image, exact, layersOf(method));
      EXPECT_GE(within.psnr, 55) << layersOf(method);
      EXPECT_GE(compositeError(image, exact).psnr, 24) << layersOf(method);
    }
  }
}

TEST_P(LayeredTransparency, StandsAlphasOfZeroAndOneAndThousandsOfLayers) {
  tangleRun().add({.strands = 200, .opacity = 0});
  const View view = tangleView(kLayerPixels);
  for (const Transparency method : kLayerMethods) {
    for (const Float4& p : tangleRun().render(view, {.method = method}).pixels)
      ASSERT_EQ(p, Float4{}) << layersOf(method);
  }
  std::vector<float> depths;
  for (int i = 0; i < 2000; ++i) depths.push_back(0.3f + 1e-4f * static_cast<float>(i));
  tangleRun().hair().visible = false;
  TangleRun& scene = tangleRun();
  const HairId stack = addStack(scene.run.scene, depths, 1);
  scene.run.step();
  for (const float opacity : {0.002f, 1.0f}) {
    scene.run.scene.hair(stack).material.opacity = opacity;
    const View narrow = flatView(4, false);
    const ExactPixel exact = exactOf(scene, narrow)[2 * 4 + 2];
    EXPECT_GE(exact.fragments, 2000u);
    for (const Transparency method : kLayerMethods) {
      const Float4 seen = scene.render(narrow, {.method = method}).pixels[2 * 4 + 2];
      // The rounding of so many small alphas.
      EXPECT_NEAR(static_cast<double>(seen.w), 1 - exact.transmittance, 0.02) << layersOf(method);
      EXPECT_NEAR(static_cast<double>(seen.x), exact.color[0], 0.03) << layersOf(method);
    }
  }
}

TEST_P(LayeredTransparency, KeepsThinCoverage) {  // K39
  // A hundredth of a pixel, over which ShortCut's classic drops it.
  tangleRun().add({.strands = 120, .radius = 0.000013f});
  const View view = tangleView(48);
  const std::vector<ExactPixel> exact = exactOf(tangleRun(), view);
  for (const Transparency method : kLayerMethods) {
    const RenderedImage image = tangleRun().render(view, {.method = method});
    double expected = 0;
    for (const ExactPixel& pixel : exact) expected += 1 - pixel.transmittance;
    EXPECT_GT(expected, 1);
    EXPECT_NEAR(coverage(image) / expected, 1, 0.05) << layersOf(method);
  }
}

TEST_P(LayeredTransparency, OrdersDepthsFromTheNearestToTheFarthestThereIs) {
  // Neighbouring floats, and both ends; what is as far as an empty target is not drawn.
  std::vector<float> depths = {0.0f, std::numeric_limits<float>::min(), 1e-6f,
                               0.5f, std::nextafter(0.5f, 1.0f),        std::nextafter(1.0f, 0.0f),
                               1.0f};
  std::vector<Float4> colors;
  for (size_t i = 0; i < depths.size(); ++i)
    colors.push_back({0.1f + 0.12f * static_cast<float>(i % 2), i % 3 == 0 ? 0.8f : 0.1f,
                      0.1f * static_cast<float>(i), 0.5f});
  TangleRun& scene = tangleRun();
  addStack(scene.run.scene, depths, 1, colors);
  scene.run.step();
  for (const bool reversedDepth : {false, true}) {
    for (const uint32_t size : {12u, 1u}) {
      const View view = flatView(size, reversedDepth);
      const std::vector<ExactPixel> exact = exactOf(scene, view);
      for (const Transparency method : kLayerMethods) {
        const RenderedImage image = scene.render(view, {.method = method});
        EXPECT_TRUE(allFinite(image));
        const size_t middle = (size / 2) * size + size / 2;
        EXPECT_GE(exact[middle].fragments, 4u);
        EXPECT_NEAR(static_cast<double>(image.pixels[middle].w), 1 - exact[middle].transmittance,
                    0.01);
        if (layersOf(method) >= 8) {
          EXPECT_LE(compositeError(image, exact).worst, 2.0 / 255)
              << layersOf(method) << (reversedDepth ? " reversed" : "");
        }
      }
    }
  }
}

TEST_P(LayeredTransparency, StandsStrandsAtAndBehindTheEye) {
  tangleRun().add({.strands = 300});
  for (const bool reversedDepth : {false, true}) {
    const View view = viewFromInside(kLayerPixels, reversedDepth);
    const std::vector<ExactPixel> exact = exactOf(tangleRun(), view);
    for (const Transparency method : kLayerMethods) {
      const RenderedImage image = tangleRun().render(view, {.method = method});
      EXPECT_TRUE(allFinite(image));
      EXPECT_GE(compositeError(image, exact).psnr, 24) << layersOf(method);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, LayeredTransparency, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
