// Mouse and keys on the stage, with the arrow that sets the wind.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "input/event.h"
#include "pelage/types.h"
#include "stage/orbit_camera.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// An arrow that shows the wind as it looks in the picture: short if it blows away from the camera.
/// In window coordinates.
struct WindArrow {
  pelage::Float2 base, tip;
  float tipRadius = 0;  ///< of the circle that the mouse drags
  bool isOnTip(double x, double y) const;
};

WindArrow windArrowOf(const OrbitCamera& camera, const pelage::Float3& wind,
                      const WindowSize& size);

/// Returns the wind whose arrow has its tip at x, y; its part along the view stays. The part in the
/// picture is at most kMaxArrowWind, and 0 near the base.
pelage::Float3 windOfTip(const OrbitCamera& camera, const pelage::Float3& before,
                         const WindowSize& size, double x, double y);

inline constexpr float kMaxArrowWind = 20;  ///< [m/s]
/// Returns the height at the bottom of the window in which the arrow is.
float windArrowHeight(const WindowSize& size);

/// Returns the wind with another speed [m/s] and another horizontal direction, an angle about y
/// that is 0 along +z [radians]; it rises or falls as before.
pelage::Float3 turnedWind(const pelage::Float3& before, float speed, float angle);

/// Moves camera, ball, hair and wind by mouse and keys.
class StageControls {
 public:
  /// Applies an event that the interface has not taken.
  void take(const Event& event, const WindowSize& size, Stage& stage);
  bool hasArrow = true;  ///< the arrow of the wind is shown and can be dragged

 private:
  enum class Drag : uint8_t { kNone, kOrbit, kPan, kBall, kPull, kWind };
  void press(const MousePressed& event, const WindowSize& size, Stage& stage);
  void move(const MouseMoved& event, const WindowSize& size, Stage& stage);
  void scroll(const Scrolled& event, Stage& stage) const;
  void key(const KeyPressed& event, const WindowSize& size, Stage& stage);
  void keepOrTakeCamera(size_t index, Stage& stage);
  MouseMoved mouse_;
  Drag drag_ = Drag::kNone;
  MouseButton button_ = MouseButton::kLeft;  // the one that began the drag
  bool shift_ = false, control_ = false, pulls_ = false;
  std::array<std::optional<OrbitCamera>, 9> cameras_;  // of the keys 1 to 9
};

}  // namespace viewer
