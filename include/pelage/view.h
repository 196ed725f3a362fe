// What drawing strands needs to know of camera, light and material.
#pragma once

#include <cstdint>

#include "pelage/types.h"

namespace pelage {

/// A camera and its target. Clip space as in HLSL: y up, depth 0..1.
struct View {
  Matrix4 worldToClip = {};
  Float3 eye = {};     ///< position of the camera [m]
  float x = 0, y = 0;  ///< offset of the viewport [pixels]
  uint32_t width = 0;  ///< size of the viewport [pixels], > 0
  uint32_t height = 0;
  uint32_t samples = 1;        ///< samples a pixel of the target: 1, 2, 4 or 8
  bool reversedDepth = false;  ///< depth 1 at the near plane, 0 at infinity
  uint32_t seed = 0;           ///< of the coverage dither; constant: a still image does not flicker
};

/// One directional light and an ambient term, linear RGB.
struct Light {
  Float3 direction = {0.35f, 0.75f, 0.55f};  ///< towards the light; normalised on use
  Float3 color = {1, 1, 1};
  Float3 ambient = {0.12f, 0.13f, 0.15f};
};

/// The look of a hair object.
struct StrandMaterial {
  Float3 rootColor = {0.10f, 0.045f, 0.02f};  ///< linear RGB, 0..1
  Float3 tipColor = {0.25f, 0.12f, 0.05f};    ///< linear RGB, 0..1
  float opacity = 1.0f;                       ///< of a fibre wider than a pixel, 0..1
  float fiberRadius = 60e-6f;                 ///< at the root [m], > 0
  float tipRadiusRatio = 0.3f;                ///< radius at the tip over that at the root, 0..1
  float primaryStrength = 0.35f;              ///< highlight of the light's colour, >= 0
  float primaryExponent = 80.0f;              ///< its sharpness, >= 1
  float primaryShift = -0.06f;                ///< its shift along the strand; < 0 towards the root
  float secondaryStrength = 0.45f;            ///< highlight of the hair's colour, >= 0
  float secondaryExponent = 16.0f;
  float secondaryShift = 0.12f;
};

/// Right-handed camera matrices for samples and tests.
/// \param verticalFov full angle [radians], \param near distance of the near plane [m], > 0.
/// \param far distance of the far plane [m]; ignored with reversedDepth, which has none.
Matrix4 lookAt(Float3 eye, Float3 target, Float3 up, float verticalFov, float aspect, float near,
               float far, bool reversedDepth = false);

}  // namespace pelage
