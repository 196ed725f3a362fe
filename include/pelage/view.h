// Camera, lights and material for drawing strands.
#pragma once

#include <cstdint>

#include "pelage/binding.h"
#include "pelage/export.h"
#include "pelage/types.h"

namespace pelage {

/// A camera and its target. Clip space as in HLSL: y up, depth 0..1.
struct View {
  Matrix4 worldToClip = {};
  Float3 eye = {};  ///< position of the camera [m]
  /// Where in the target the viewport begins, from the top left corner [pixels]: whole numbers,
  /// 0..65535. The runtime that draws the lists has to be told the same viewport. Buffers a pixel,
  /// TransparencySettings::opaqueDepth too, have the pixels of the viewport alone.
  float x = 0, y = 0;
  uint32_t width = 0;  ///< size of the viewport [pixels], > 0
  uint32_t height = 0;
  uint32_t samples = 1;        ///< samples a pixel of the target: 1, 2, 4 or 8
  bool reversedDepth = false;  ///< depth 1 at the near plane, 0 at infinity
  uint32_t seed = 0;           ///< of the coverage dither; constant: a still image does not flicker
};

/// How hair dims the light that passes it.
enum class HairShadow : uint8_t {
  kNone,
  /// Light falls with the way through hair of mean density behind the nearest strand.
  kDepth,
  /// Light falls with the hair that is there, in layers behind the nearest strand.
  kDeep,
};

/// Opaque geometry as a light sees it: a depth map of the engine's, for the shadow that it casts on
/// hair. What is outside of the map is lit.
struct OpaqueShadow {
  /// [y][x] float, row 0 is the top row: depth 0..1 as worldToClip makes it, filled before the
  /// lists of the view run (RenderTargetDef::depthCopy, or a copy of a depth texture). kInvalid:
  /// opaque geometry casts no shadow on hair.
  BufferId depth = BufferId::kInvalid;
  uint32_t width = 0, height = 0;  ///< of the map [texels], 1..8192
  Matrix4 worldToClip = {};        ///< of the light. Clip space: y up, depth 0..1
  bool reversedDepth = false;      ///< depth 1 at the near plane
  /// Opaque geometry this close in front of hair does not shadow it, >= 0 [m]: roots lie on the
  /// skin, whose depth the map has to a texel.
  float bias = 0.004f;
};

/// A light, and an ambient term that goes with it. Linear RGB; a white surface that faces a light
/// of 1 is as bright as 1.
struct Light {
  Float3 direction = {0.35f, 0.75f, 0.55f};  ///< towards the light, of any length > 0
  Float3 color = {1, 1, 1};
  Float3 ambient = {0.12f, 0.13f, 0.15f};  ///< from all sides; those of all lights add up
  bool hasPosition = false;                ///< a point light, or a spot light
  Float3 position = {};  ///< of a point light [m]; color is that at a distance of 1 m
  /// Makes a point light a spot light, which shines along -direction: half angle of the cone
  /// outside of which it is dark [rad], 0..pi/2; 0: it shines in all directions. It needs
  /// hasPosition.
  float outerConeAngle = 0;
  /// Half angle of the cone inside of which a spot light has all its color [rad],
  /// 0..outerConeAngle.
  float innerConeAngle = 0;
  /// At most kMaxStrandShadows lights of a view have one.
  HairShadow shadow = HairShadow::kNone;
  uint32_t shadowSize = 1024;  ///< texels an edge of its map, 4..8192
  uint32_t shadowLayers = 8;   ///< kDeep: 1..16
  /// Hair up to so far behind the nearest hair is lit [texels], >= 0: as much as keeps a strand
  /// from shadowing itself.
  float shadowBias = 0.5f;
  /// kDeep: distance behind the nearest hair that the layers take up, >= 0 [m]; what lies beyond is
  /// in the last one. 0: 8 free paths of light in hair of mean density, at most what hair takes up.
  float shadowLayerRange = 0;
  /// Volume of all hair [m3], >= 0, for its mean density: kDepth, and a shadowLayerRange of 0. 0:
  /// it is measured when hair is added.
  float shadowVolume = 0;
  OpaqueShadow opaque = {};  ///< its shadow on hair, with any `shadow`; at most kMaxStrandShadows
};

inline constexpr uint32_t kMaxStrandLights = 8;   ///< lights that a view has at most
inline constexpr uint32_t kMaxStrandShadows = 4;  ///< of them with a shadow

/// How light leaves a fiber; docs/shading.md has the equations.
enum class ShadingModel : uint8_t {
  kKajiyaKay,  ///< diffuse light and two shifted highlights
  kFiber,      ///< R, TT and TRT lobes that keep the energy
};

/// The look of a hair object.
struct StrandMaterial {
  Float3 rootColor = {0.10f, 0.045f, 0.02f};  ///< linear RGB, 0..1
  Float3 tipColor = {0.25f, 0.12f, 0.05f};    ///< linear RGB, 0..1
  /// Share of the strand, from the tip, over which the color goes from rootColor to tipColor, 0..1:
  /// 1 all along the strand, 0.25 over its last quarter, 0 not at all.
  float tipShare = 1.0f;
  float colorVariation = 0.15f;  ///< by which strands differ around the mean, as a share, 0..1
  float opacity = 1.0f;          ///< of a fiber wider than a pixel, 0..1
  float fiberRadius = 60e-6f;    ///< at the root [m], > 0
  float tipRadiusRatio = 0.3f;   ///< radius at the tip over that at the root, 0..1
  ShadingModel model = ShadingModel::kKajiyaKay;
  float ambientStrength = 1.0f;     ///< 0..64
  float diffuseStrength = 1.0f;     ///< Kajiya-Kay, 0..64; 1 / pi keeps the energy
  float primaryStrength = 0.35f;    ///< Kajiya-Kay: highlight of the light's colour, 0..64
  float primaryExponent = 80.0f;    ///< its sharpness, 1..10,000
  float primaryShift = -0.06f;      ///< its shift along the strand; < 0 towards the root
  float secondaryStrength = 0.45f;  ///< Kajiya-Kay: highlight of the hair's colour, 0..64
  float secondaryExponent = 16.0f;
  float secondaryShift = 0.12f;
  float secondaryTint = 1.0f;           ///< share of the hair's colour in it, 0..1
  float longitudinalRoughness = 0.25f;  ///< fiber model, 0..1
  float azimuthalRoughness = 0.3f;      ///< fiber model, 0..1
  float cuticleTilt = 0.035f;           ///< fiber model: of the scales, towards the root [rad]
  float refractiveIndex = 1.55f;        ///< fiber model, > 1
  float scatteredShare = 0.0f;          ///< fiber model: light scattered in all directions, 0..1
};

/// Right-handed camera matrices for samples and tests.
/// \param verticalFov full angle [radians], \param near distance of the near plane [m], > 0.
/// \param far distance of the far plane [m]; ignored with reversedDepth, which has none.
PELAGE_API Matrix4 lookAt(Float3 eye, Float3 target, Float3 up, float verticalFov, float aspect,
                          float near, float far, bool reversedDepth = false);

}  // namespace pelage
