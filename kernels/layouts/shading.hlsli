// Material and light of strands, as buffers hold them: no resources, those are in the layouts.
// docs/shading.md has units, ranges and defaults.
#ifndef PELAGE_LAYOUTS_SHADING_HLSLI
#define PELAGE_LAYOUTS_SHADING_HLSLI

static const uint kStrandKajiyaKay = 0u;  // diffuse and two highlights
static const uint kStrandFiber = 1u;      // R, TT, TRT, averaged over the width of the fibre
static const uint kStrandNearFiber = 2u;  // R, TT, TRT where StrandSurface.offset says

// StrandLight.shadow.x of a light without one.
static const uint kNoStrandShadow = 0xffffffffu;

struct StrandShading {
  uint4 model;  // x one of the above; yzw 0
  // x Kajiya-Kay's diffuse strength, y strength of ambient light, z share of the light that the
  // fibre models scatter in all directions, as neighbouring fibres do; w 0
  float4 body;
  // Kajiya-Kay's highlights: x strength, y exponent, z shift (< 0 towards the root), w share of the
  // base colour in theirs
  float4 primary;
  float4 secondary;
  // Fibre models: x longitudinal and y azimuthal roughness 0..1, z tilt of the cuticle's scales
  // [rad], w index of refraction
  float4 fiber;
};

struct StrandLight {
  float4 direction;  // w 0: unit vector towards the light; w 1: its position [m]
  // linear rgb: radiance of a white Lambert surface that faces the light, at 1 m where it has a
  // position; w 0
  float4 color;
  uint4 shadow;  // x index of its shadow, or kNoStrandShadow; yzw 0
};

#endif
