// The table's rows of materials, lights, transparency and views.
#include <numbers>

#include "parameter_row.h"

namespace pelage::settings {
namespace {

constexpr double kMebibyte = 1 << 20;
constexpr double kRightAngle = std::numbers::pi_v<float> / 2;
constexpr std::string_view kShadingModels[] = {"kKajiyaKay", "kFiber"};
constexpr std::string_view kHairShadows[] = {"kNone", "kDepth", "kDeep"};
constexpr std::string_view kTransparencies[] = {"kAlphaTest", "kStochastic", "kWindowed",
                                                "kHybrid4",   "kHybrid8",    "kHybrid16",
                                                "kShortCut",  "kTiles"};

std::vector<Parameter> colorRows() {
  return {
      PELAGE_PARAMETER(StrandMaterial, rootColor)
          .says("linear RGB", "0..1", "Color at the root.")
          .within(0, 1)
          .color()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, tipColor)
          .says("linear RGB", "0..1", "Color at the tip.")
          .within(0, 1)
          .color()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, tipShare)
          .says("share of the strand", "0..1",
                "Part of the strand, from the tip, over which the root's color becomes the tip's; "
                "0: the root's all along.")
          .within(0, 1),
      PELAGE_PARAMETER(StrandMaterial, colorVariation)
          .says("share", "0..1", "Variation of the color between strands.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, opacity)
          .says("", "0..1", "Opacity of a fiber wider than a pixel.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, fiberRadius)
          .says("m", "> 0", "Radius at the root.")
          .above(0)
          .logSlider(5e-6, 1e-3)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, tipRadiusRatio)
          .says("share", "0..1", "Radius at the tip over that at the root.")
          .within(0, 1)
          .pictured(),
  };
}

std::vector<Parameter> kajiyaRows() {
  return {
      PELAGE_PARAMETER(StrandMaterial, model)
          .says("", "kKajiyaKay, kFiber",
                "Diffuse light and two shifted highlights, or R, TT and TRT lobes that conserve "
                "energy.")
          .names(kShadingModels)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, ambientStrength)
          .says("", "0..64", "Factor on the lights' ambient term.")
          .within(0, 64)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, diffuseStrength)
          .says("", "0..64", "Kajiya-Kay: light in the hair's color; 1 / pi conserves energy.")
          .within(0, 64)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, primaryStrength)
          .says("", "0..64", "Kajiya-Kay: highlight in the light's color.")
          .within(0, 64)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, primaryExponent)
          .says("", "1..10,000", "Kajiya-Kay: sharpness of the primary highlight.")
          .within(1, 10000)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, primaryShift)
          .says("slope", "-1..1",
                "Kajiya-Kay: shift of the primary highlight along the strand; negative is towards "
                "the root.")
          .within(-1, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, secondaryStrength)
          .says("", "0..64", "Kajiya-Kay: highlight in the hair's color.")
          .within(0, 64)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, secondaryExponent)
          .says("", "1..10,000", "Kajiya-Kay: sharpness of the secondary highlight.")
          .within(1, 10000)
          .log()
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, secondaryShift)
          .says("slope", "-1..1", "Kajiya-Kay: shift of the secondary highlight along the strand.")
          .within(-1, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, secondaryTint)
          .says("share", "0..1",
                "Kajiya-Kay: share of the hair's color in the secondary highlight.")
          .within(0, 1)
          .pictured(),
  };
}

std::vector<Parameter> fiberRows() {
  return {
      PELAGE_PARAMETER(StrandMaterial, longitudinalRoughness)
          .says("", "0..1 (at least 0.05 is used)", "Fiber model: roughness along the fiber.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, azimuthalRoughness)
          .says("", "0..1 (at least 0.05 is used)", "Fiber model: roughness around the fiber.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, cuticleTilt)
          .says("rad", "-0.5..0.5",
                "Fiber model: tilt of the scales, towards the root; 0.03..0.07 for hair, 0 without "
                "scales.")
          .within(-0.5, 0.5)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, refractiveIndex)
          .says("", "1..3", "Fiber model: index of refraction of the fiber.")
          .within(1, 3)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, scatteredShare)
          .says("share", "0..1",
                "Fiber model: share of the light that is scattered in all directions.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(StrandMaterial, multipleScattering)
          .says("share", "0..1", "Fiber model: share of the light that passes from fiber to fiber.")
          .within(0, 1)
          .pictured(),
  };
}

std::vector<Parameter> lightRows() {
  return {
      PELAGE_PARAMETER(Light, direction)
          .says("", "any length > 0", "Direction towards the light.")
          .nonZero()
          .slider(-1, 1)
          .pictured(),
      PELAGE_PARAMETER(Light, color)
          .says("linear RGB", ">= 0", "A white surface that faces a light of 1 is as bright as 1.")
          .atLeast(0)
          .color()
          .pictured(),
      PELAGE_PARAMETER(Light, ambient)
          .says("linear RGB", ">= 0",
                "Light from all sides; the ambient terms of all lights add up.")
          .atLeast(0)
          .color()
          .pictured(),
      PELAGE_PARAMETER(Light, hasPosition)
          .says("", "", "Makes it a point light, or with outerConeAngle a spot light."),
      PELAGE_PARAMETER(Light, position)
          .says("m", "", "Position of a point light; the color is that at a distance of 1 m.")
          .slider(-5, 5)
          .pictured(),
      PELAGE_PARAMETER(Light, outerConeAngle)
          .says("rad", "0..pi/2",
                "Half angle of a spot light's cone around `-direction`; 0 shines in all "
                "directions. Needs hasPosition.")
          .within(0, kRightAngle)
          .pictured(),
      PELAGE_PARAMETER(Light, innerConeAngle)
          .says("rad", "0..outerConeAngle",
                "Half angle inside of which a spot light has all its color.")
          .within(0, kRightAngle)
          .pictured(),
  };
}

std::vector<Parameter> shadowRows() {
  return {
      PELAGE_PARAMETER(Light, shadow)
          .says("", "kNone, kDepth, kDeep",
                "Shadow by hair: none, by the distance behind the nearest strand, or by the hair "
                "in between.")
          .names(kHairShadows)
          .pictured(),
      PELAGE_PARAMETER(Light, shadowSize)
          .says("texels", "4..8192", "Width and height of the shadow map.")
          .within(4, 8192)
          .log()
          .pictured(),
      PELAGE_PARAMETER(Light, shadowLayers)
          .says("", "1..16", "Layers of deep shadows.")
          .within(1, 16)
          .pictured(),
      PELAGE_PARAMETER(Light, shadowBias)
          .says("texels", ">= 0",
                "Hair up to so far behind the nearest hair is lit; it keeps a strand from "
                "shadowing itself.")
          .atLeast(0)
          .slider(0, 8)
          .pictured(),
      PELAGE_PARAMETER(Light, shadowLayerRange)
          .says("m", ">= 0",
                "kDeep: distance behind the nearest hair that the layers take up; 0 finds it from "
                "the hair.")
          .atLeast(0)
          .logSlider(0, 1),
      PELAGE_PARAMETER(Light, shadowVolume)
          .says("m³", ">= 0",
                "Volume of all hair, for its mean density: kDepth, and shadowLayerRange 0. 0 "
                "measures it.")
          .atLeast(0)
          .logSlider(0, 0.1)
          .pictured(),
      PELAGE_INNER_PARAMETER(Light, opaque, OpaqueShadow, bias)
          .says("m", ">= 0", "Opaque geometry this close in front of hair does not shadow it.")
          .atLeast(0)
          .logSlider(0, 0.1),
  };
}

// Texts of rows live as long as the program.
#define RADIANCE_BAND(band, factor)                                                    \
  PELAGE_INNER_PARAMETER(Light, environment, EnvironmentLight, band)                   \
      .says("linear RGB", "finite", "Radiance from direction (x, y, z) times " factor) \
      .slider(-1, 1)

std::vector<Parameter> environmentRows() {
  return {
      RADIANCE_BAND(l00, "0.282095: mean radiance, which adds to ambient."),
      RADIANCE_BAND(l1m1, "0.488603 y: from above."),
      RADIANCE_BAND(l10, "0.488603 z."),
      RADIANCE_BAND(l11, "0.488603 x."),
      RADIANCE_BAND(l2m2, "1.092548 x y."),
      RADIANCE_BAND(l2m1, "1.092548 y z."),
      RADIANCE_BAND(l20, "0.315392 (3 z^2 - 1)."),
      RADIANCE_BAND(l21, "1.092548 x z."),
      RADIANCE_BAND(l22, "0.546274 (x^2 - y^2)."),
  };
}

#undef RADIANCE_BAND

}  // namespace

std::vector<Parameter> materialParameters() {
  std::vector<Parameter> rows = colorRows();
  for (auto* more : {&kajiyaRows, &fiberRows}) append(rows, (*more)());
  return rows;
}

std::vector<Parameter> lightParameters() {
  std::vector<Parameter> rows = lightRows();
  for (auto* more : {&environmentRows, &shadowRows}) append(rows, (*more)());
  return rows;
}

std::vector<Parameter> transparencyParameters() {
  return {
      PELAGE_PARAMETER(TransparencySettings, method)
          .says("", "kAlphaTest, kStochastic, kWindowed, kHybrid4/8/16, kShortCut, kTiles",
                "Method that draws hair. [oit.md](oit.md) compares them.")
          .names(kTransparencies)
          .pictured(),
      PELAGE_PARAMETER(TransparencySettings, maxBytes)
          .says("bytes", "",
                "Maximum memory of a method's buffers; lists get fewer nodes if it is too small.")
          .logSlider(kMebibyte, 16384 * kMebibyte),
      PELAGE_PARAMETER(TransparencySettings, maxBufferBytes)
          .says("bytes", "what the device takes",
                "Maximum size of a buffer that a kernel can bind.")
          .logSlider(kMebibyte, 4096 * kMebibyte),
      PELAGE_PARAMETER(TransparencySettings, nodeCount)
          .says("fragments", "0..67,108,863",
                "Capacity for fragments. 0 means, for lists, 8 per pixel of the view; for tiles, 8 "
                "per "
                "vertex or 2 per pixel, whichever is more.")
          .within(0, kMaxListNodes)
          .log()
          .pictured(),
      PELAGE_PARAMETER(TransparencySettings, spillTail)
          .says("", "",
                "Lists: averages fragments without a node behind the others; costs 16 bytes per "
                "pixel.")
          .pictured(),
      PELAGE_PARAMETER(TransparencySettings, epsilon)
          .says("share", "0..1",
                "Lists and tiles: if less light than this comes through, fragments behind are "
                "ignored.")
          .within(0, 1)
          .log()
          .pictured(),
  };
}

std::vector<Parameter> viewParameters() {
  return {
      PELAGE_PARAMETER_AS("View", ViewSettings, samples)
          .says("", "1, 2, 4 or 8", "Samples per pixel of the target.")
          .within(1, 8)
          .powerOfTwo()
          .pictured(),
      PELAGE_PARAMETER_AS("View", ViewSettings, reversedDepth)
          .says("", "", "Depth 1 at the near plane, 0 at infinity."),
      PELAGE_PARAMETER_AS("View", ViewSettings, seed)
          .says("", "",
                "Seed of the coverage dither; if it is constant, a still image does not flicker.")
          .slider(0, 100),
  };
}

}  // namespace pelage::settings
