// A picture by an engine that has its own hair shader: pelage brings the strands, the shadow map of
// the hair and the functions that the shaders include.
#pragma once

#include <cstdint>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace engine_shader {

struct PictureDef {
  uint32_t size = 720;     ///< width and height [pixels], >= 1
  uint32_t guides = 1500;  ///< strands that are simulated; each has 8 follow hairs
  uint32_t samples = 4;    ///< samples a pixel; see DeviceInfo::sampleCounts
  bool hair = true;        ///< false: the head alone
  bool keyShadow = true;   ///< the key light casts a shadow of the hair
};

/// Draws a head with hair. Linear colour, alpha 0 where there is neither.
/// Errors: those of the scene and the device.
pelage::Result<pelage::RenderedImage> drawPicture(pelage::HeadlessDevice& device,
                                                  const PictureDef& def);

}  // namespace engine_shader
