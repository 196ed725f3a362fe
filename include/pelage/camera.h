// The camera of a view.
#pragma once

#include <cstdint>

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

/// Right-handed camera matrices for samples and tests.
/// \param verticalFov full angle [radians], \param near distance of the near plane [m], > 0.
/// \param far distance of the far plane [m]; ignored with reversedDepth, which has none.
PELAGE_API Matrix4 lookAt(Float3 eye, Float3 target, Float3 up, float verticalFov, float aspect,
                          float near, float far, bool reversedDepth = false);

}  // namespace pelage
