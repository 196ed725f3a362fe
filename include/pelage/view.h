// Camera, lights and material for drawing strands.
#pragma once

#include <cstdint>

#include "pelage/camera.h"
#include "pelage/light.h"
#include "pelage/types.h"

namespace pelage {

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
  ShadingModel model = ShadingModel::kFiber;
  float ambientStrength = 1.0f;     ///< 0..64
  float diffuseStrength = 1.0f;     ///< Kajiya-Kay, 0..64; 1 / pi keeps the energy
  float primaryStrength = 0.35f;    ///< Kajiya-Kay: highlight of the light's colour, 0..64
  float primaryExponent = 80.0f;    ///< its sharpness, 1..10,000
  float primaryShift = -0.06f;      ///< its shift along the strand; < 0 towards the root
  float secondaryStrength = 0.45f;  ///< Kajiya-Kay: highlight of the hair's colour, 0..64
  float secondaryExponent = 16.0f;  ///< 1..10,000
  float secondaryShift = 0.12f;
  float secondaryTint = 1.0f;           ///< share of the hair's colour in it, 0..1
  float longitudinalRoughness = 0.25f;  ///< fiber model, 0..1
  float azimuthalRoughness = 0.3f;      ///< fiber model, 0..1
  float cuticleTilt = 0.035f;           ///< fiber model: of the scales, towards the root [rad]
  float refractiveIndex = 1.55f;        ///< fiber model, > 1
  float scatteredShare = 0.0f;          ///< fiber model: light scattered in all directions, 0..1
  /// Fiber model: share of the light that passes from fiber to fiber, 0..1 (after Zinke et al.,
  /// "Dual scattering approximation for fast multiple scattering in hair", 2008; docs/shading.md).
  /// A light without a HairShadow shines on the edge of dense hair. 0: hair in front of a strand
  /// dims light in no color.
  float multipleScattering = 1.0f;
};

/// The level of detail of a hair object in draws: drawnStrandsOf().
struct DrawnStrands {
  uint32_t count = 0;  ///< strands that draws take, from the first
  float shown = 0;     ///< likewise, before it was rounded up
  float fading = 0;    ///< of them, the last ones: their width falls linearly to 0
  float widening = 1;  ///< factor on the widths of all, so that their sum stays the same
};
}  // namespace pelage
