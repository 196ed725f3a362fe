// Lights, and the shadows that they cast on hair.
#pragma once

#include <cstdint>

#include "pelage/binding.h"
#include "pelage/types.h"

namespace pelage {

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

/// Light from all sides by spherical harmonics of order 2: its radiance, linear RGB, projected on
/// the nine real functions Y_lm of Ramamoorthi and Hanrahan, "An efficient representation for
/// irradiance environment maps", SIGGRAPH 2001, equation 3, with the axes x, y, z of the world. In
/// place of their irradiance it is weighted as fibers take it (docs/shading.md, Environment light).
/// Any finite values; where the sum is negative, no light arrives. All 0, the default: none.
struct EnvironmentLight {
  Float3 l00 = {};   ///< times 0.282095: mean radiance, which adds to Light::ambient
  Float3 l1m1 = {};  ///< y: light from above; 0.488603 y
  Float3 l10 = {};   ///< z
  Float3 l11 = {};   ///< x
  Float3 l2m2 = {};  ///< 1.092548 x y
  Float3 l2m1 = {};  ///< y z
  Float3 l20 = {};   ///< 0.315392 (3 z^2 - 1)
  Float3 l21 = {};   ///< x z
  Float3 l22 = {};   ///< 0.546274 (x^2 - y^2)
};

/// A light, and an ambient term that goes with it. Linear RGB; a white surface that faces a light
/// of 1 is as bright as 1.
struct Light {
  Float3 direction = {0.35f, 0.75f, 0.55f};  ///< towards the light, of any length > 0
  Float3 color = {1, 1, 1};
  Float3 ambient = {0.12f, 0.13f, 0.15f};  ///< from all sides; those of all lights add up
  /// From all sides, too, but not the same from each; those of all lights add up.
  EnvironmentLight environment = {};
  bool hasPosition = false;  ///< a point light, or a spot light
  Float3 position = {};      ///< of a point light [m]; color is that at a distance of 1 m
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
  float shadowBias = 0.35f;
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

}  // namespace pelage
