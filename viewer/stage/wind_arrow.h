// An arrow in a corner of the picture that shows the wind, and sets it when its tip is dragged.
#pragma once

#include "pelage/types.h"
#include "stage/orbit_camera.h"
#include "window/window.h"

namespace viewer {

/// In window coordinates. The arrow shows what the wind does in the picture: one that blows away
/// from the camera is short.
struct WindArrow {
  pelage::Float2 base, tip;
  float tipRadius = 0;  ///< of the circle that the mouse takes
  bool isOnTip(double x, double y) const;
};

WindArrow windArrowOf(const OrbitCamera& camera, const pelage::Float3& wind,
                      const WindowSize& size);

/// The wind whose arrow has its tip at a place; what blows along the view stays. At most
/// kMaxArrowWind in the picture; near the base there is none.
pelage::Float3 windOfTip(const OrbitCamera& camera, const pelage::Float3& before,
                         const WindowSize& size, double x, double y);

inline constexpr float kMaxArrowWind = 20;  ///< [m/s]

}  // namespace viewer
