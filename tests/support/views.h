// Cameras of tests.
#pragma once

#include <cstdint>

#include "pelage/view.h"

namespace pelage::test {

/// A camera whose picture has y up.
struct CameraDef {
  Float3 eye;
  Float3 target = {};
  float fov = 0.5f;                       ///< of the picture's height [rad]
  uint32_t width = 64, height = 0;        ///< [pixels]; as high as wide if 0
  float nearPlane = 0.05f, farPlane = 5;  ///< [m]
  bool reversedDepth = false;
};

inline View cameraView(const CameraDef& def) {
  View view;
  view.eye = def.eye;
  view.width = def.width;
  view.height = def.height > 0 ? def.height : def.width;
  view.worldToClip = lookAt(def.eye, def.target, {0, 1, 0}, def.fov,
                            static_cast<float>(view.width) / static_cast<float>(view.height),
                            def.nearPlane, def.farPlane, def.reversedDepth);
  view.reversedDepth = def.reversedDepth;
  return view;
}

}  // namespace pelage::test
