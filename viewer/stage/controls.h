// What mouse and keys do on the stage.
#pragma once

#include "input/event.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

class StageControls {
 public:
  /// Applies an event that the interface has not taken.
  void take(const Event& event, const WindowSize& size, Stage& stage);
  bool hasArrow = true;  ///< the arrow of the wind is there to be dragged

 private:
  enum class Drag : uint8_t { kNone, kOrbit, kPan, kBall, kPull, kWind };
  void press(const MousePressed& event, const WindowSize& size, Stage& stage);
  void move(const MouseMoved& event, const WindowSize& size, Stage& stage);
  void scroll(const Scrolled& event, Stage& stage) const;
  void key(const KeyPressed& event, const WindowSize& size, Stage& stage);
  MouseMoved mouseInSide(const WindowSize& size, const Stage& stage) const;
  pelage::Float3 pointOn(const pelage::Float3& plane, const WindowSize& size,
                         const Stage& stage) const;
  void moveBall(const WindowSize& size, Stage& stage) const;
  void askForHair(const WindowSize& size, Stage& stage) const;
  MouseMoved mouse_;
  Drag drag_ = Drag::kNone;
  MouseButton button_ = MouseButton::kLeft;  // that began the drag
  bool shift_ = false, control_ = false, pulls_ = false;
};

}  // namespace viewer
