// strand_vertex and strand_pixel: covered area, light, and what must not break them.
#include <gtest/gtest.h>

#include <cmath>

#include "pelage/view.h"
#include "reference/strand_reference.h"
#include "support/matrices.h"
#include "support/pictures.h"
#include "support/scene_run.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kTargetWidth = 320, kTargetHeight = 200;
constexpr float kStrandFov = 0.7f;

struct Strand {
  Vector3d root, tip;
};

/// Straight strands in front of a camera at z = 1 that looks at the origin.
class DrawStrands : public GpuTest {
 protected:
  static constexpr uint32_t kVertices = 9;

  void SetUp() override {
    GpuTest::SetUp();
    const Matrix4 clip = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, kStrandFov,
                                static_cast<float>(kTargetWidth) / kTargetHeight, 0.1f, 10.0f);
    worldToClip_ = toMatrix(clip);
    std::copy(std::begin(clip.rows), std::end(clip.rows), std::begin(view_.worldToClip));
    const Eigen::Matrix4d inverse = worldToClip_.inverse();
    for (int row = 0; row < 4; ++row) {
      const Eigen::Vector4f r = inverse.row(row).cast<float>();
      view_.clipToWorld[row] = {r.x(), r.y(), r.z(), r.w()};
    }
    view_.eye = {0, 0, 1, 1};
    view_.viewport = {0, 0, kTargetWidth, kTargetHeight};
    view_.ambientColor = {1, 1, 1, 0};
    view_.seed = 5;
    constants_.shadingBody = {0, 1, 0, 0};
    constants_.rootColor = {1, 1, 1, 1};
    constants_.tipColor = {1, 1, 1, 1};
    constants_.renderGuideCount = 1;
    constants_.strandWidening = 1;
    constants_.renderVertexCount = kVertices;
    constants_.tipRadiusRatio = 1;
  }

  RenderedImage draw(const std::vector<Strand>& strands, uint32_t samples,
                     const std::vector<float>& thickness = {}) {
    std::vector<Float4> positions, tangents;
    for (const Strand& strand : strands)
      for (uint32_t v = 0; v < kVertices; ++v) {
        positions.push_back(
            toFloat4(strand.root + (strand.tip - strand.root) * (double{1} * v / (kVertices - 1))));
        tangents.push_back(toFloat4((strand.tip - strand.root).normalized()));
      }
    return drawVertices(positions, tangents, samples, thickness);
  }

  RenderedImage drawVertices(const std::vector<Float4>& positions,
                             const std::vector<Float4>& tangents, uint32_t samples,
                             const std::vector<float>& thickness = {}) {
    std::vector<uint32_t> indices;
    for (uint32_t v = 0; v + 1 < kVertices; ++v)
      for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) indices.push_back(2 * v + corner);
    const auto strandCount = static_cast<uint32_t>(positions.size() / kVertices);
    constants_.renderStrandCount = strandCount;
    constants_.drawnStrands = static_cast<float>(strandCount);
    view_.sampleCount = samples;
    RenderConstants constants = constants_;
    if (!thickness.empty()) constants.strandAttributes |= kThickness;
    const bool attributes = bindsAttributes_ || constants.strandAttributes != 0;

    const GuardedBuffer<Float4> positionBuffer(gpu(), "positions", positions);
    const GuardedBuffer<Float4> tangentBuffer(gpu(), "tangents", tangents);
    const GuardedBuffer<float> thicknessBuffer(gpu(), "thickness", thickness);
    const GuardedBuffer<uint32_t> shadowBuffer(gpu(), "shadows", {0, 0, 0, 0});
    const BufferId indexBuffer = gpu().resources.add("indices", indices, BufferUsage::kIndex);
    expectOk(gpu().device()->update(gpu().resources));

    PassList list;
    PassBuilder builder(list);
    builder.draw(strandVertexVariant({.attributes = attributes}),
                 strandPixelVariant({.stochastic = true}), DrawState{},
                 static_cast<uint32_t>(indices.size()), strandCount, indexBuffer);
    positionBuffer.bindTo(builder, "g_renderPositions");
    tangentBuffer.bindTo(builder, "g_renderTangents");
    for (const char* name : {"g_strandThickness", "g_vertexColors", "g_baseTexture",
                             "g_renderFollowHairRecords", "g_renderRoots"})
      thicknessBuffer.bindTo(builder, name);
    shadowBuffer.bindTo(builder, "g_shadowWords");
    builder.constants("RenderConstants", constants);
    builder.constants("StrandViewConstants", view_);
    expectOk(builder.finish());
    gpu().hazards.resolve(list);
    const RenderTargetDef target = {
        .width = kTargetWidth, .height = kTargetHeight, .samples = samples};
    Result<RenderedImage> image = gpu().device()->render(list, target);
    gpu().hazards.forget(indexBuffer);
    gpu().resources.remove(indexBuffer);
    return imageOf(std::move(image), target);
  }

  Eigen::Vector2d pixelOf(const Vector3d& p) const {
    const Eigen::Vector4d clip = worldToClip_ * p.homogeneous();
    return {(clip.x() / clip.w() * 0.5 + 0.5) * kTargetWidth,
            (0.5 - clip.y() / clip.w() * 0.5) * kTargetHeight};
  }

  /// Area in pixels that a fiber of this radius covers.
  double area(const Strand& strand, double radius, double tipRatio = 1) const {
    constexpr int kSteps = 200;
    const Vector3d tangent = (strand.tip - strand.root).normalized();
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const auto at = [&](double t) -> Vector3d {
        return strand.root + (strand.tip - strand.root) * t;
      };
      const double middle = (i + 0.5) / kSteps;
      const double length =
          (pixelOf(at((i + 1.0) / kSteps)) - pixelOf(at(double{1} * i / kSteps))).norm();
      sum += length * reference::projectedWidth(worldToClip_, {kTargetWidth, kTargetHeight},
                                                {0, 0, 1}, at(middle), tangent,
                                                radius * (1 + (tipRatio - 1) * middle));
    }
    return sum;
  }

  /// Parallel slanted strands that do not touch, up to `width` pixels wide.
  static std::vector<Strand> comb(double slant) {
    std::vector<Strand> strands;
    for (int i = -15; i <= 15; ++i) {
      const double x = 0.03 * i;
      strands.push_back({{x, -0.3, 0.05}, {x + slant, 0.31, -0.1}});
    }
    return strands;
  }

  /// Sample counts of the device.
  std::vector<uint32_t> sampleCounts() {
    std::vector<uint32_t> counts;
    for (const uint32_t samples : {1u, 2u, 4u, 8u})
      if ((gpu().device()->info().sampleCounts & samples) != 0) counts.push_back(samples);
    return counts;
  }

  /// World radius of a fiber that is so many pixels wide at distance 1.
  static double radiusOf(double pixels) {
    return pixels * std::tan(kStrandFov / 2) / kTargetHeight;
  }

  /// Bits of RenderConstants::strandAttributes.
  static constexpr uint32_t kThickness = 1, kVertexColors = 2, kBaseTexture = 4;

  RenderConstants constants_ = {};
  bool bindsAttributes_ = false;  ///< also where there are none
  StrandViewConstants view_ = {};
  Eigen::Matrix4d worldToClip_;
};

// K42
TEST_P(DrawStrands, CoverTheAreaOfTheFiberHoweverThinItIs) {
  for (const uint32_t samples : sampleCounts()) {
    for (const double pixels : {0.05, 0.1, 0.3, 0.9, 1.0, 2.6, 6.0}) {
      for (const double slant : {0.0, 0.021, -0.12}) {
        const std::vector<Strand> strands = comb(slant);
        const double radius = radiusOf(pixels);
        constants_.fiberRadius = static_cast<float>(radius);
        double expected = 0;
        for (const Strand& strand : strands) expected += area(strand, radius);
        const double covered = coverage(draw(strands, samples));
        // Four standard deviations of the dither, and the ends and joints of ribbons.
        const double deviation = 4 / std::sqrt(expected);
        EXPECT_NEAR(covered / expected, 1, 0.015 + (pixels < 1 ? deviation : 0))
            << pixels << " pixels, slant " << slant << ", " << samples << " samples";
      }
    }
  }
}

TEST_P(DrawStrands, TaperToTheTip) {
  const std::vector<Strand> strands = comb(0.1);
  const double radius = radiusOf(4);
  constants_.fiberRadius = static_cast<float>(radius);
  constants_.tipRadiusRatio = 0;
  double expected = 0;
  for (const Strand& strand : strands) expected += area(strand, radius, 0);
  const uint32_t samples = sampleCounts().back();
  EXPECT_NEAR(coverage(draw(strands, samples)) / expected, 1, 0.03);
}

TEST_P(DrawStrands, ScaleWithTheThicknessOfTheStrand) {
  const std::vector<Strand> strands = comb(0.1);
  std::vector<float> thickness;
  const double radius = radiusOf(2);
  constants_.fiberRadius = static_cast<float>(radius);
  double expected = 0;
  for (size_t i = 0; i < strands.size(); ++i) {
    thickness.push_back(0.25f * static_cast<float>(i % 9));
    expected += area(strands[i], radius * static_cast<double>(thickness[i]));
  }
  const uint32_t samples = sampleCounts().back();
  EXPECT_NEAR(coverage(draw(strands, samples, thickness)) / expected, 1, 0.03);
}

TEST_P(DrawStrands, ReadNoAttributeThatTheObjectLacks) {
  // The buffers of attributes have nothing but the pattern behind their elements.
  const std::vector<Strand> strands = comb(0.1);
  constants_.fiberRadius = static_cast<float>(radiusOf(3));
  constants_.rootColor = constants_.tipColor = {0.5f, 0.3f, 0.2f, 1};
  constants_.textureSize = {1, 1};
  view_.ambientColor = {1, 1, 1, 0};
  constants_.shadingBody = {1, 1, 0, 0};
  const RenderedImage plain = draw(strands, 1);
  EXPECT_GT(coverage(plain), 100);
  EXPECT_TRUE(sameBits(draw(strands, 1, std::vector<float>(strands.size(), 1)), plain));
  bindsAttributes_ = true;
  EXPECT_TRUE(sameBits(draw(strands, 1), plain));
  for (const uint32_t attribute : {kThickness, kVertexColors, kBaseTexture}) {
    constants_.strandAttributes = attribute;
    EXPECT_FALSE(sameBits(draw(strands, 1), plain)) << attribute;
  }
}

TEST_P(DrawStrands, LetThroughWhatTheOpacityLeaves) {
  const std::vector<Strand> strands = comb(0.1);
  const double radius = radiusOf(5);
  constants_.fiberRadius = static_cast<float>(radius);
  double expected = 0;
  for (const Strand& strand : strands) expected += area(strand, radius);
  for (const float opacity : {0.0f, 0.3f, 0.75f, 1.0f}) {
    constants_.rootColor.w = opacity;
    for (const uint32_t samples : sampleCounts())
      EXPECT_NEAR(coverage(draw(strands, samples)) / expected, static_cast<double>(opacity), 0.03)
          << opacity << ", " << samples << " samples";
  }
}

TEST_P(DrawStrands, SpreadTheSamplesOfStrandsBehindEachOther) {
  // Two layers of alpha 0.5 let a quarter through; with the same samples they would let half.
  std::vector<Strand> strands;
  for (const double z : {0.0, -0.001}) strands.push_back({{0, -0.2, z}, {0, 0.2, z}});
  constants_.fiberRadius = static_cast<float>(radiusOf(40));
  constants_.rootColor.w = 0.5f;
  for (const uint32_t samples : sampleCounts()) {
    const RenderedImage one = draw({strands[0]}, samples), two = draw(strands, samples);
    EXPECT_NEAR(coverage(two) / coverage(one), 1.5, 0.05) << samples << " samples";
  }
}

// The hash of kernels/base/random_hash.hlsli.
uint32_t pcg(uint32_t value) {
  const uint32_t state = value * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
  return (word >> 22) ^ word;
}

TEST_P(DrawStrands, AreLitAsTheReference) {
  constants_.fiberRadius = static_cast<float>(radiusOf(12));
  view_.ambientColor = {0.1f, 0.2f, 0.3f, 0};
  view_.lightCount = 1;
  view_.lightColors[0] = {1.5f, 1.2f, 0.9f, 0};
  view_.lightShadows[0].x = ~0u;
  constants_.rootColor = {0.5f, 0.3f, 0.2f, 1};
  constants_.tipColor = {0.5f, 0.3f, 0.2f, 1};
  constants_.strandVariation = 0.15f;
  constants_.shadingBody = {1, 1, 0, 0};
  constants_.shadingPrimary = {0.5f, 40, -0.06f, 0};
  constants_.shadingSecondary = {0.6f, 9, 0.12f, 1};
  reference::FiberLight light;
  light.lightColor = toVector(view_.lightColors[0]);
  light.ambient = toVector(view_.ambientColor);
  light.primaryStrength = 0.5;
  light.primaryExponent = 40;
  light.primaryShift = double{0.06f};  // the tilt of the normal, against the highlight's way
  light.secondaryStrength = double{0.6f};
  light.secondaryExponent = 9;
  light.secondaryShift = double{-0.12f};
  const double random = (pcg(0) >> 8) * 0x1p-24 * 2 - 1;
  const Vector3d hair = toVector(constants_.rootColor) * (1 + 0.15 * random);
  Random directions(3);
  for (int i = 0; i < 20; ++i) {
    light.toLight = directions.vector(1).normalized();
    view_.lightDirections[0] = toFloat4(light.toLight);
    const Vector3d tangent = Vector3d(directions.between(-1, 1), directions.between(-1, 1),
                                      directions.between(-0.3, 0.3))
                                 .normalized();
    const RenderedImage image = draw({{-0.2 * tangent, 0.2 * tangent}}, 1);
    // The pixel whose centre is half a pixel beside that of the image.
    const Float4& pixel = image.pixels[kTargetHeight / 2 * kTargetWidth + kTargetWidth / 2];
    const double pixelSize = 2 * std::tan(double{kStrandFov} / 2) / kTargetHeight;
    const Eigen::Vector2d beside(0.5 * pixelSize, -0.5 * pixelSize);
    // As deep as the strand is there.
    const double along = beside.dot(tangent.head<2>()) / tangent.head<2>().squaredNorm();
    const Vector3d point(beside.x(), beside.y(), along * tangent.z());
    const Vector3d expected = light.shade(tangent, (Vector3d(0, 0, 1) - point).normalized(), hair);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(toVector(pixel)[c], expected[c], 0.004 + 0.004 * expected[c])
          << "case " << i << " channel " << c;
  }
}

TEST_P(DrawStrands, StandTangentsAlongTheSightAndVerticesBehindTheEye) {
  constants_.fiberRadius = static_cast<float>(radiusOf(0.5));
  std::vector<Strand> strands = {
      {{0, 0, 0}, {0, 0, 0.5}},      // towards the eye
      {{0, 0, 0}, {0, 0, 3}},        // through the eye
      {{0.1, 0, 0}, {0.3, 0.1, 2}},  // past the eye
      {{0, 0.1, 1.5}, {0, 0.2, 3}},  // behind the eye
      {{0.05, 0, 0}, {0.05, 0, 0}},  // no length at all
      {{1e6, 1e6, -1e7}, {1e6, 2e6, -1e7}},
      {{0, 0, 1}, {0, 0.1, 0.5}},  // out of the eye itself
  };
  std::vector<Float4> positions, tangents;
  for (const Strand& strand : strands)
    for (uint32_t v = 0; v < kVertices; ++v) {
      positions.push_back(
          toFloat4(strand.root + (strand.tip - strand.root) * (double{1} * v / (kVertices - 1))));
      const Vector3d along = strand.tip - strand.root;
      tangents.push_back(toFloat4(along.norm() > 0 ? along.normalized() : Vector3d::Zero()));
    }
  for (const uint32_t samples : {1u, sampleCounts().back()}) {
    const RenderedImage image = drawVertices(positions, tangents, samples);
    for (const Float4& p : image.pixels) ASSERT_TRUE(isFinite(p));
    // Thin lines, no triangle across the screen.
    EXPECT_LT(coverage(image), 0.05 * kTargetWidth * kTargetHeight);
  }
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Apis, DrawStrands, testing::ValuesIn(kApis), apiTestName);

}  // namespace pelage::test
