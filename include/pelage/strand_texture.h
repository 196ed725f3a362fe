// A texture that an engine has on the GPU, for the colors of strands.
#pragma once

#include <cstdint>

#include "pelage/binding.h"

namespace pelage {

/// A texture of two dimensions with its mip levels, which your engine owns: what its sampler gives
/// at the root's UV multiplies the color of a strand, and its alpha the opacity.
struct StrandTexture {
  /// An id from newTextureId(), registered with the runtime with a sampler: its format, filters and
  /// address modes are yours. Sampled values count as linear RGBA and are clamped to 0..1, so give
  /// texels that are encoded as sRGB a format that says so. v = 0 is the first row of the image.
  /// kInvalid: no texture.
  TextureId texture = TextureId::kInvalid;
  uint32_t width = 0, height = 0;  ///< texels of mip level 0, 1..65536
  uint32_t mipLevels = 1;          ///< of which the levels are chosen, 1..17
  float lodBias = 0;  ///< added to the level, -16..16: -1 takes one of twice the texels an edge
  bool operator==(const StrandTexture&) const = default;
};

}  // namespace pelage
