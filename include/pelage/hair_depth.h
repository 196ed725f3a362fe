// Depth and motion of hair, for effects that an engine applies to a picture: temporal
// anti-aliasing, depth of field, fog.
#pragma once

#include <cstdint>

#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// The contents of the color target of Frame::drawDepth(); depth goes into the depth target.
enum class HairDepthColor : uint8_t {
  kNone,   ///< nothing: color stays as it is
  kDepth,  ///< (depth, 0, 0, 1), depth 0..1 as in the depth target: for R32F
  /// (x, y, depth, 1): for RG16F or RG32F, which take x and y. How far the point moved on the
  /// screen since the last frame [pixels of the viewport], x to the right and y down: it was at
  /// pixel - motion. Divide by the size of the viewport for texture coordinates; many upscalers
  /// want it with the other sign.
  kMotion,
};

/// Depth is that of the nearest hair in a pixel whose opacity is at least `opacity`. docs/
/// shading_depth.md says how passes of an engine use it.
struct HairDepthSettings {
  /// Hair counts from this product on: StrandMaterial::opacity (with colors of vertices and
  /// texture) times the share of a pixel's width that the fiber covers, 0..1. Fibers thinner than
  /// this share of a pixel have neither depth nor motion; 0 takes all that covers anything.
  float opacity = 0.1f;
  HairDepthColor color = HairDepthColor::kNone;
  /// kMotion: View::worldToClip of the last frame, in today's coordinates where
  /// Scene::shiftOrigin() came in between. In the first frame after a cut, that of this frame.
  Matrix4 previousWorldToClip = {};
  /// kMotion: by how much the jitter of temporal anti-aliasing moves the picture in
  /// View::worldToClip and in previousWorldToClip [pixels], x to the right and y down; finite.
  /// Motion does not contain it: a vertex at rest has motion 0. Leave one at 0 if its matrix has no
  /// jitter.
  Float2 jitter = {};
  Float2 previousJitter = {};  ///< as `jitter`
  /// Below Tier::kWide: bytes that the vertices on the screen may take, 48 each; as
  /// TransparencySettings::maxBytes and maxBufferBytes, for all objects of the view and for one.
  uint64_t maxBytes = uint64_t{512} << 20;
  uint64_t maxBufferBytes = uint64_t{128} << 20;
};

/// Errors: an opacity that is not 0..1; a matrix or jitter that is not finite.
PELAGE_API Result<void> validate(const HairDepthSettings& settings);

}  // namespace pelage
