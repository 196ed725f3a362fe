// The rows of materials, lights, views and transparency.
#include <string>
#include <utility>

#include "groups.h"

namespace sample {

using pelage::Float3;
using pelage::HairDepthSettings;
using pelage::HairShadow;
using pelage::Light;
using pelage::ShadingModel;
using pelage::StrandMaterial;
using pelage::Transparency;
using pelage::TransparencySettings;
using pelage::View;

namespace {

template <class T>
auto material(T StrandMaterial::*field) {
  return [field](Setup& setup, const T& value) { setup.hair.material.*field = value; };
}
template <class T>
auto light(T Light::*field) {
  return [field](Setup& setup, const T& value) { setup.lights[0].*field = value; };
}
template <class T>
auto transparency(T TransparencySettings::*field) {
  return [field](Setup& setup, const T& value) { setup.transparency.*field = value; };
}

Setup kajiyaSwatch() {
  Setup setup = swatchSetup();
  setup.hair.material.model = ShadingModel::kKajiyaKay;
  return setup;
}

Setup fiberSwatch() {
  Setup setup = swatchSetup();
  setup.hair.material.rootColor = setup.hair.material.tipColor = {0.42f, 0.22f, 0.10f};
  return setup;
}

// Light that comes through the hair from behind.
Setup backLit() {
  Setup setup = fiberSwatch();
  setup.lights[0].direction = {0.8f, -0.3f, -0.8f};
  setup.lights[0].color = {0.22f, 0.21f, 0.2f};
  return setup;
}

// A thick brush of hair, lit from its side.
Setup shadowed() {
  Setup setup = headSetup();
  setup.hair.material.rootColor = setup.hair.material.tipColor = {0.34f, 0.20f, 0.10f};
  setup.groom.strandCount = 3000;
  setup.groom.length = 0.26f;
  setup.groom.clumpStrength = 0.6f;
  setup.groom.curlRadius = 0.008f;
  Light sun;
  sun.direction = {-0.75f, 0.6f, 0.35f};
  sun.color = {1.7f, 1.6f, 1.45f};
  sun.shadow = HairShadow::kDeep;
  setup.lights = {sun};
  return setup;
}

// The same with a point light.
Setup spot() {
  Setup setup = shadowed();
  Light& light = setup.lights[0];
  light.hasPosition = true;
  light.position = {-0.42f, 0.55f, 0.2f};
  light.color = {0.5f, 0.47f, 0.43f};
  return setup;
}

std::vector<Parameter> colorRows() {
  const std::string color = "linear RGB";
  return {
      tuned("StrandMaterial", "rootColor",
            show(lockSetup(),
                 std::vector<Float3>{
                     {0.02f, 0.01f, 0.008f}, {0.10f, 0.045f, 0.02f}, {0.5f, 0.05f, 0.03f}},
                 material(&StrandMaterial::rootColor), "The tip keeps its color.")),
      tuned("StrandMaterial", "tipColor",
            show(lockSetup(),
                 std::vector<Float3>{
                     {0.04f, 0.02f, 0.01f}, {0.25f, 0.12f, 0.05f}, {0.05f, 0.25f, 0.6f}},
                 material(&StrandMaterial::tipColor), "The root keeps its color.")),
      tuned("StrandMaterial", "tipShare"),
      tuned("StrandMaterial", "colorVariation",
            show(swatchSetup(), std::vector{0.0f, 0.15f, 0.8f},
                 material(&StrandMaterial::colorVariation),
                 "All strands equal, and increasingly different.")),
      tuned("StrandMaterial", "opacity",
            show(with(closeSetup(), [](Setup& s) { s.hair.material.fiberRadius = 250e-6f; }),
                 std::vector{0.15f, 0.5f, 1.0f}, material(&StrandMaterial::opacity),
                 "Thick fibers, close up.")),
      tuned("StrandMaterial", "fiberRadius",
            show(with(closeSetup(), [](Setup& s) { s.swatchGuides = 400; }),
                 std::vector{20e-6f, 60e-6f, 200e-6f}, material(&StrandMaterial::fiberRadius),
                 "22 mm of the edge of a swatch.")),
      tuned("StrandMaterial", "tipRadiusRatio",
            show(with(closeSetup(),
                      [](Setup& s) {
                        s.center = {0.045f, -0.033f, 0.052f};
                        s.extent = 0.035f;
                        s.hair.material.fiberRadius = 250e-6f;
                      }),
                 std::vector{0.0f, 0.3f, 1.0f}, material(&StrandMaterial::tipRadiusRatio),
                 "The tips: hair ends in points, or as if it were cut.")),
  };
}

std::vector<Parameter> kajiyaRows() {
  const std::string kajiya = "Kajiya-Kay: ";
  return {
      tuned("StrandMaterial", "model",
            show(
                swatchSetup(), std::vector{ShadingModel::kKajiyaKay, ShadingModel::kFiber},
                [](Setup& s, ShadingModel v) {
                  s.hair.material.model = v;
                  s.hair.material.rootColor = s.hair.material.tipColor = {0.35f, 0.18f, 0.08f};
                },
                "The same color and light.")),
      tuned("StrandMaterial", "ambientStrength",
            show(kajiyaSwatch(), std::vector{0.0f, 1.0f, 8.0f},
                 material(&StrandMaterial::ambientStrength),
                 "Look at the hair below, out of the light.")),
      tuned("StrandMaterial", "diffuseStrength",
            show(kajiyaSwatch(), std::vector{0.0f, 0.5f, 1.0f},
                 material(&StrandMaterial::diffuseStrength),
                 "Without it, only the highlights remain.")),
      tuned("StrandMaterial", "primaryStrength",
            show(kajiyaSwatch(), std::vector{0.0f, 0.35f, 1.5f},
                 material(&StrandMaterial::primaryStrength), "The white band.")),
      tuned("StrandMaterial", "primaryExponent",
            show(kajiyaSwatch(), std::vector{10.0f, 80.0f, 800.0f},
                 material(&StrandMaterial::primaryExponent), "A wide band, and narrow ones.")),
      tuned("StrandMaterial", "primaryShift",
            show(kajiyaSwatch(), std::vector{-0.4f, -0.06f, 0.3f},
                 material(&StrandMaterial::primaryShift), "The white band moves along the hair.")),
      tuned("StrandMaterial", "secondaryStrength",
            show(kajiyaSwatch(), std::vector{0.0f, 0.45f, 3.0f},
                 material(&StrandMaterial::secondaryStrength), "The wide colored band.")),
      tuned("StrandMaterial", "secondaryExponent",
            show(with(kajiyaSwatch(),
                      [](Setup& s) {
                        s.hair.material.secondaryStrength = 2.5f;
                        s.hair.material.primaryStrength = 0;
                      }),
                 std::vector{4.0f, 16.0f, 200.0f}, material(&StrandMaterial::secondaryExponent),
                 "With a strength of 2.5 and no primary highlight.")),
      tuned("StrandMaterial", "secondaryShift",
            show(with(kajiyaSwatch(),
                      [](Setup& s) {
                        s.hair.material.secondaryStrength = 2.5f;
                        s.hair.material.secondaryExponent = 40;
                        s.hair.material.primaryStrength = 0;
                      }),
                 std::vector{-0.3f, 0.12f, 0.5f}, material(&StrandMaterial::secondaryShift),
                 "With a strength of 2.5, an exponent of 40 and no primary highlight.")),
      tuned(
          "StrandMaterial", "secondaryTint",
          show(with(kajiyaSwatch(),
                    [](Setup& s) {
                      s.hair.material.secondaryStrength = 0.45f;
                      s.hair.material.primaryStrength = 0;
                      s.hair.material.rootColor = s.hair.material.tipColor = {0.30f, 0.05f, 0.03f};
                    }),
               std::vector{0.0f, 0.5f, 1.0f}, material(&StrandMaterial::secondaryTint),
               "On red hair without a primary highlight: in the light's color, and in its own.")),
  };
}

std::vector<Parameter> fiberRows() {
  const std::string fiber = "Fiber model: ";
  return {
      tuned("StrandMaterial", "longitudinalRoughness",
            show(fiberSwatch(), std::vector{0.1f, 0.25f, 0.7f},
                 material(&StrandMaterial::longitudinalRoughness), "The highlights get longer.")),
      tuned("StrandMaterial", "azimuthalRoughness",
            show(backLit(), std::vector{0.1f, 0.3f, 0.9f},
                 material(&StrandMaterial::azimuthalRoughness),
                 "Light from behind: smooth fibers send more of it to the eye.")),
      tuned(
          "StrandMaterial", "cuticleTilt",
          show(with(fiberSwatch(), [](Setup& s) { s.hair.material.longitudinalRoughness = 0.12f; }),
               std::vector{-0.15f, 0.035f, 0.2f}, material(&StrandMaterial::cuticleTilt),
               "With a longitudinal roughness of 0.12: the white and the colored band separate.")),
      tuned("StrandMaterial", "refractiveIndex",
            show(fiberSwatch(), std::vector{1.1f, 1.55f, 2.5f},
                 material(&StrandMaterial::refractiveIndex),
                 "The higher, the more light is reflected by the surface.")),
      tuned("StrandMaterial", "scatteredShare",
            show(fiberSwatch(), std::vector{0.0f, 0.4f, 1.0f},
                 material(&StrandMaterial::scatteredShare),
                 "Light that goes off in all directions: softer and fuller.")),
      tuned(
          "StrandMaterial", "multipleScattering",
          show(with(shadowed(),
                    [](Setup& s) {
                      s.hair.material.rootColor = s.hair.material.tipColor = {0.60f, 0.42f, 0.24f};
                    }),
               std::vector{0.0f, 0.5f, 1.0f}, material(&StrandMaterial::multipleScattering),
               "Blond hair: light that passes from fiber to fiber.")),
  };
}

std::vector<Parameter> lightRows() {
  return {
      tuned("Light", "direction",
            show(shadowed(),
                 std::vector<Float3>{
                     {-0.75f, 0.6f, 0.35f}, {0.35f, 0.75f, 0.55f}, {0.6f, 0.5f, -0.8f}},
                 light(&Light::direction), "From the left, from the right above, from behind.")),
      tuned("Light", "color",
            show(shadowed(), std::vector<Float3>{{0.5f, 0.5f, 0.5f}, {1, 1, 1}, {2.4f, 1.3f, 0.6f}},
                 light(&Light::color), "Half as bright, white, and a low sun.")),
      tuned("Light", "ambient",
            show(shadowed(),
                 std::vector<Float3>{{0, 0, 0}, {0.12f, 0.13f, 0.15f}, {0.6f, 0.65f, 0.75f}},
                 light(&Light::ambient), "Look at the side away from the light.")),
      {PELAGE_FIELD(Light, environment),
       "",
       "",
       "Light from all sides that is not the same from each; those of all lights add up.",
       {}},
      tuned("Light", "hasPosition"),
      tuned("Light", "position",
            show(with(shadowed(),
                      [](Setup& s) {
                        s.lights[0].hasPosition = true;
                        s.lights[0].color = {0.06f, 0.056f, 0.05f};
                      }),
                 std::vector<Float3>{{-0.25f, 0.3f, 0.1f}, {0, 0.45f, 0.1f}, {0.2f, 0.1f, 0.15f}},
                 light(&Light::position),
                 "A point light of 0.06 on the left, above, and on the right below.")),
      tuned("Light", "outerConeAngle",
            show(spot(), std::vector{0.0f, 0.2f, 0.35f}, light(&Light::outerConeAngle),
                 "All around, a narrow cone and a wider one.")),
      tuned("Light", "innerConeAngle",
            show(with(spot(), [](Setup& s) { s.lights[0].outerConeAngle = 0.3f; }),
                 std::vector{0.0f, 0.2f, 0.3f}, light(&Light::innerConeAngle),
                 "An outer angle of 0.3: a soft edge, a narrow one, and none.")),
  };
}

std::vector<Parameter> shadowRows() {
  return {
      tuned("Light", "shadow",
            show(shadowed(), std::vector{HairShadow::kNone, HairShadow::kDepth, HairShadow::kDeep},
                 light(&Light::shadow), "The light is on the left.")),
      tuned("Light", "shadowSize",
            show(shadowed(), std::vector{16u, 64u, 1024u}, light(&Light::shadowSize),
                 "Deep shadows: large texels blur them.")),
      tuned("Light", "shadowLayers",
            show(with(shadowed(),
                      [](Setup& s) {
                        s.groom.strandCount = 700;
                        s.follow.countPerGuide = 3;
                        s.lights[0].direction = {-0.2f, 0.3f, -0.9f};
                        s.lights[0].color = {4, 3.8f, 3.4f};
                      }),
                 std::vector{1u, 2u, 8u}, light(&Light::shadowLayers),
                 "Sparse hair, the light behind it: with few layers light penetrates too far.")),
      tuned("Light", "shadowBias",
            show(with(shadowed(), [](Setup& s) { s.lights[0].shadowSize = 64; }),
                 std::vector{0.0f, 0.35f, 4.0f}, light(&Light::shadowBias),
                 "Texels of 13 mm: the shadow begins deeper in the hair.")),
      tuned("Light", "shadowLayerRange"),
      tuned("Light", "shadowVolume",
            show(with(shadowed(), [](Setup& s) { s.lights[0].shadow = HairShadow::kDepth; }),
                 std::vector{0.0f, 0.001f, 0.1f}, light(&Light::shadowVolume),
                 "kDepth: the less volume the hair has, the denser it is.")),
      {PELAGE_FIELD(Light, opaque),
       "",
       "",
       "Depth map of opaque geometry that casts a shadow on hair, with any `shadow`.",
       {}},
  };
}

std::vector<Parameter> environmentRows() {
  std::vector<Parameter> rows;
  for (const char* name : {"l00", "l1m1", "l10", "l11", "l2m2", "l2m1", "l20", "l21", "l22"})
    rows.push_back(tuned("EnvironmentLight", name));
  return rows;
}

std::vector<Parameter> opaqueShadowRows() {
  return {
      {PELAGE_FIELD(OpaqueShadow, depth),
       "",
       "one float per texel",
       "Depth 0..1, row by row from the top; without it opaque geometry casts no shadow on hair.",
       {}},
      {PELAGE_FIELD(OpaqueShadow, width), "texels", "1..8192", "Width of the map.", {}},
      {PELAGE_FIELD(OpaqueShadow, height), "texels", "1..8192", "Height of the map.", {}},
      {PELAGE_FIELD(OpaqueShadow, worldToClip),
       "",
       "finite",
       "Clip space of the light: y up, depth 0..1.",
       {}},
      {PELAGE_FIELD(OpaqueShadow, reversedDepth),
       "",
       "",
       "Depth 1 at the near plane, 0 at infinity.",
       {}},
      tuned("OpaqueShadow", "bias"),
  };
}

std::vector<Parameter> viewRows() {
  return {
      {PELAGE_FIELD(View, worldToClip), "", "has an inverse", "Clip space: y up, depth 0..1.", {}},
      {PELAGE_FIELD(View, eye), "m", "", "Position of the camera.", {}},
      {PELAGE_FIELD(View, x), "pixels", "0..65535, whole", "Left edge of the viewport.", {}},
      {PELAGE_FIELD(View, y), "pixels", "0..65535, whole", "Top edge of the viewport.", {}},
      {PELAGE_FIELD(View, width), "pixels", "> 0", "Width of the viewport.", {}},
      {PELAGE_FIELD(View, height), "pixels", "> 0", "Height of the viewport.", {}},
      tuned("View", "samples",
            show(
                with(closeSetup(),
                     [](Setup& s) {
                       s.transparency.method = Transparency::kStochastic;
                       s.supersample = 1;
                     }),
                std::vector{1u, 4u}, [](Setup& s, uint32_t v) { s.samples = v; },
                "Transparency::kStochastic, unfiltered pixels: the more samples, the less noise.")),
      tuned("View", "reversedDepth"),
      tuned("View", "seed"),
  };
}

std::vector<Parameter> transparencyRows() {
  const Setup thin = with(closeSetup(), [](Setup& s) {
    s.hair.material.fiberRadius = 200e-6f;
    s.hair.material.opacity = 0.4f;
    s.supersample = 1;
  });
  // Many layers of clear fibers.
  const Setup deep = with(swatchSetup(), [](Setup& s) {
    s.hair.material.opacity = 0.3f;
    s.supersample = 1;
  });
  return {
      tuned(
          "TransparencySettings", "method",
          show(
              thin,
              std::vector{Transparency::kAlphaTest, Transparency::kStochastic,
                          Transparency::kWindowed, Transparency::kHybrid4, Transparency::kShortCut},
              [](Setup& s, Transparency v) {
                s.transparency.method = v;
                const bool sampled =
                    v == Transparency::kAlphaTest || v == Transparency::kStochastic;
                s.samples = sampled ? 4 : 1;
              },
              "Fibers with an opacity of 0.4, close up. The first two have four samples per "
              "pixel.")),
      tuned("TransparencySettings", "maxBytes"),
      tuned("TransparencySettings", "maxBufferBytes"),
      tuned("TransparencySettings", "nodeCount",
            show(with(deep, [](Setup& s) { s.transparency.spillTail = false; }),
                 std::vector{60000u, 0u, 3000000u}, transparency(&TransparencySettings::nodeCount),
                 "160 x 160 pixels without spillTail, transparent fibers in many layers: fragments "
                 "without a node are missing.")),
      tuned("TransparencySettings", "spillTail",
            show(with(deep, [](Setup& s) { s.transparency.nodeCount = 60000; }),
                 std::vector{false, true}, transparency(&TransparencySettings::spillTail),
                 "Lists that are too short.")),
      tuned("TransparencySettings", "epsilon",
            show(deep, std::vector{0.5f / 255, 0.3f, 0.8f},
                 transparency(&TransparencySettings::epsilon),
                 "A large value leaves out fragments behind.")),
      {PELAGE_FIELD(TransparencySettings, opaqueDepth),
       "",
       "one float per pixel",
       "Tiles: depth of opaque objects; without it nothing occludes hair.",
       {}},
      {PELAGE_FIELD(TransparencySettings, engineLights),
       "",
       "a table of kernels, and what they read",
       "An engine's own lights in place of those of the draw.",
       {}},
  };
}

std::vector<Parameter> depthRows() {
  return {
      {PELAGE_FIELD(HairDepthSettings, opacity),
       "",
       "0..1",
       "Hair counts from this product of opacity and coverage of a pixel on.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, color),
       "",
       "kNone, kDepth, kMotion",
       "What goes into the color target beside depth: nothing, depth, or motion vectors.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, previousWorldToClip),
       "",
       "finite",
       "kMotion: View::worldToClip of the last frame.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, jitter),
       "pixels",
       "finite",
       "kMotion: offset of the picture in View::worldToClip, y down; motion is without it.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, previousJitter),
       "pixels",
       "finite",
       "The same of previousWorldToClip.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, maxBytes),
       "bytes",
       "",
       "Below Tier::kWide: maximum memory of the vertices on the screen.",
       {}},
      {PELAGE_FIELD(HairDepthSettings, maxBufferBytes),
       "bytes",
       "what the device takes",
       "Below Tier::kWide: maximum size of those of an object.",
       {}},
  };
}

}  // namespace

std::vector<ParameterGroup> materialGroups() {
  return {{"StrandMaterial", "pelage/view.h",
           "HairObject::material; may change at any time. [shading.md](shading.md)",
           joined(colorRows(), kajiyaRows(), fiberRows())}};
}

std::vector<ParameterGroup> viewGroups() {
  return {
      {"Light", "pelage/light.h",
       "Scene::draw(), at most 8; shadows for 4 of them. [shadow.md](shadow.md)",
       joined(lightRows(), shadowRows())},
      {"EnvironmentLight", "pelage/light.h",
       "Light::environment. [shading.md](shading.md#environment-light)", environmentRows()},
      {"OpaqueShadow", "pelage/light.h",
       "Light::opaque. [shadow.md](shadow.md#shadows-of-opaque-geometry-on-hair)",
       opaqueShadowRows()},
      {"View", "pelage/camera.h", "Scene::draw(): a camera and its target.", viewRows()},
      {"TransparencySettings", "pelage/transparency.h", "Scene::draw(). [oit.md](oit.md)",
       transparencyRows()},
      {"HairDepthSettings", "pelage/hair_depth.h",
       "Frame::drawDepth(). [shading_depth.md](shading_depth.md)", depthRows()},
  };
}

}  // namespace sample
