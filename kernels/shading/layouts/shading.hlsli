// Material and light of strands as buffers store them; no resources, those are in the layouts.
// docs/parameters.md has units, ranges and defaults.
#ifndef PELAGE_SHADING_LAYOUTS_SHADING_HLSLI
#define PELAGE_SHADING_LAYOUTS_SHADING_HLSLI

// Lights of a view, and those of them with a shadow.
static const uint kMaxStrandLights = 8u;
static const uint kMaxStrandShadows = 4u;

static const uint kStrandKajiyaKay = 0u;  // diffuse and two highlights
static const uint kStrandFiber = 1u;      // R, TT, TRT, averaged over the width of the fiber
static const uint kStrandNearFiber = 2u;  // R, TT, TRT at StrandSurface.offset

// StrandLight.shadow.x of a light without a shadow.
static const uint kNoStrandShadow = 0xffffffffu;

struct StrandShading {
  uint4 model;  // x one of the above; yzw 0
  // x Kajiya-Kay's diffuse strength, y strength of ambient light, z share of the light that the
  // fiber models scatter in all directions, as neighboring fibers do; w share of the light between
  // fibers (strand_volume.hlsli)
  float4 body;
  // Kajiya-Kay's highlights: x strength, y exponent, z shift (< 0 towards the root), w share of the
  // base color in theirs
  float4 primary;
  float4 secondary;
  // Fiber models: x longitudinal and y azimuthal roughness 0..1, z tilt of the cuticle's scales
  // [rad], w index of refraction
  float4 fiber;
};

struct StrandLight {
  float4 direction;  // w 0: unit vector towards the light; w 1: its position [m]
  // linear rgb: radiance of a white Lambert surface that faces the light, at 1 m where it has a
  // position; w 0
  float4 color;
  // x index of its shadow, or kNoStrandShadow; y 1 + index of the opaque geometry's shadow, 0 for
  // none; zw 0
  uint4 shadow;
  // A spot light sends saturate(xyz . d + w)^2 of its light along -d.
  // All 0: it shines in all directions.
  float4 cone;
};

#endif
