#include "stage/controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "input/keys.h"
#include "stage/wind_arrow.h"

namespace viewer {

namespace {

constexpr double kZoomStep = 1.1;      // factor of a step of the wheel
constexpr float kBallStep = 0.25f;     // radii that a step of the wheel moves the ball
constexpr float kLockRadius = 0.15f;   // of half the picture's height: hair that is pulled
constexpr double kSlowest = 1.0 / 16;  // PlayClock::speed
constexpr double kFastest = 4;

// Of a side.
float aspectOf(const WindowSize& size, const Stage& stage) {
  return static_cast<float>(size.width) /
         static_cast<float>(std::max(size.height, 1u) * stage.sides());
}

}  // namespace

void StageControls::take(const Event& event, const WindowSize& size, Stage& stage) {
  if (const auto* moved = std::get_if<MouseMoved>(&event)) move(*moved, size, stage);
  if (const auto* pressed = std::get_if<MousePressed>(&event)) press(*pressed, size, stage);
  if (const auto* scrolled = std::get_if<Scrolled>(&event)) scroll(*scrolled, stage);
  if (const auto* pressed = std::get_if<KeyPressed>(&event)) key(*pressed, size, stage);
}

void StageControls::press(const MousePressed& event, const WindowSize& size, Stage& stage) {
  if (!event.down) {
    if (event.button != button_) return;
    if (drag_ == Drag::kPull) stage.pull.release(stage.scene());
    drag_ = Drag::kNone;
    return;
  }
  if (drag_ != Drag::kNone) return;
  button_ = event.button;
  if (event.button != MouseButton::kLeft || shift_) {
    drag_ = Drag::kPan;
  } else if (hasArrow &&
             windArrowOf(stage.camera, stage.look.wind, size).isOnTip(mouse_.x, mouse_.y)) {
    drag_ = Drag::kWind;
  } else if (pulls_) {
    drag_ = Drag::kPull;
    askForHair(size, stage);
  } else if (control_) {
    drag_ = Drag::kBall;
    moveBall(size, stage);
  } else {
    drag_ = Drag::kOrbit;
  }
}

void StageControls::move(const MouseMoved& event, const WindowSize& size, Stage& stage) {
  const double height = std::max(size.height, 1u);
  const auto right = static_cast<float>((event.x - mouse_.x) / height);
  const auto down = static_cast<float>((event.y - mouse_.y) / height);
  mouse_ = event;
  constexpr float kHalfTurn = std::numbers::pi_v<float>;
  if (drag_ == Drag::kOrbit) stage.camera.orbit(right * kHalfTurn, down * kHalfTurn);
  if (drag_ == Drag::kPan) stage.camera.pan(-right, down);
  if (drag_ == Drag::kBall) moveBall(size, stage);
  if (drag_ == Drag::kPull && stage.pull.holds())
    stage.pull.dragTo(pointOn(stage.pull.point(), size, stage));
  if (drag_ == Drag::kWind)
    stage.look.wind = windOfTip(stage.camera, stage.look.wind, size, event.x, event.y);
}

// The wheel moves what is dragged.
void StageControls::scroll(const Scrolled& event, Stage& stage) const {
  if (drag_ != Drag::kBall) {
    stage.camera.zoom(static_cast<float>(std::pow(kZoomStep, event.steps)));
    return;
  }
  const pelage::Float3 back = stage.camera.direction();
  const float away = -kBallStep * stage.ball.radius * static_cast<float>(event.steps);
  pelage::Float3& center = stage.ball.center;
  center = {center.x + away * back.x, center.y + away * back.y, center.z + away * back.z};
}

// Pixels of the mouse in the side that it is over.
MouseMoved StageControls::mouseInSide(const WindowSize& size, const Stage& stage) const {
  const double width = static_cast<double>(std::max(size.width, 1u)) / stage.sides();
  const double side = std::clamp(std::floor(mouse_.x / width), 0.0, stage.sides() - 1.0);
  return {mouse_.x - side * width, mouse_.y};
}

// Under the mouse, in a plane that faces the camera.
pelage::Float3 StageControls::pointOn(const pelage::Float3& plane, const WindowSize& size,
                                      const Stage& stage) const {
  const auto share = [](double at, double of) {
    return static_cast<float>(at / std::max(of, 1.0));
  };
  const MouseMoved mouse = mouseInSide(size, stage);
  return stage.camera.pointAt(share(mouse.x * stage.sides(), size.width),
                              share(mouse.y, size.height), aspectOf(size, stage), plane);
}

// At the depth where it is, at first that of what the camera looks at.
void StageControls::moveBall(const WindowSize& size, Stage& stage) const {
  stage.ball.center =
      pointOn(stage.ball.present ? stage.ball.center : stage.camera.target(), size, stage);
  stage.ball.present = true;
}

void StageControls::askForHair(const WindowSize& size, Stage& stage) const {
  const pelage::Float3 top = stage.camera.pointAt(0.5f, 0, 1, stage.camera.target());
  const pelage::Float3 middle = stage.camera.target();
  const float half =
      std::sqrt((top.x - middle.x) * (top.x - middle.x) + (top.y - middle.y) * (top.y - middle.y) +
                (top.z - middle.z) * (top.z - middle.z));
  const MouseMoved mouse = mouseInSide(size, stage);
  stage.pull.ask(stage.camera.view(std::max(size.width / stage.sides(), 1u), size.height),
                 static_cast<float>(mouse.x), static_cast<float>(mouse.y), kLockRadius * half);
}

void StageControls::key(const KeyPressed& event, const WindowSize& size, Stage& stage) {
  if (event.key == kKeyLeftShift || event.key == kKeyRightShift) shift_ = event.down;
  if (event.key == kKeyLeftControl || event.key == kKeyRightControl) control_ = event.down;
  if (event.key == kKeyLeftAlt || event.key == kKeyRightAlt || event.key == 'G')
    pulls_ = event.down;
  if (!event.down || control_) return;
  PlayClock& clock = stage.clock;
  switch (event.key) {
    case 'F':
      stage.frameAll(aspectOf(size, stage));
      break;
    case kKeySpace:
      clock.playing = !clock.playing;
      break;
    case '.':
      clock.steps = true;
      break;
    case 'R':
      stage.reset();
      break;
    case 'L':
      clock.loops = !clock.loops;
      break;
    case '-':
      clock.speed = std::max(clock.speed / 2, kSlowest);
      break;
    case '=':
      clock.speed = std::min(clock.speed * 2, kFastest);
      break;
    case 'B':
      stage.ball.present = false;
      break;
    case 'V':
      stage.inspection.show(shift_);
      break;
    case 'E':
      stage.chooseSide(1 - std::min(stage.side(), 1u));
      break;
    case 'C':
      stage.look.showsContacts = !stage.look.showsContacts;
      break;
    default:
      break;
  }
}

}  // namespace viewer
