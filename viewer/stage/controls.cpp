#include "stage/controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "float3_math.h"
#include "input/event.h"

namespace viewer {

using pelage::Float3;
using sample::dot;

namespace {

constexpr float kScale = 4;      // at interface scale 1: window coordinates per m/s
constexpr float kCorner = 100;   // likewise: distance of the base from the bottom right corner
constexpr float kTipRadius = 9;  // likewise
constexpr float kCalm = 0.5f;    // [m/s]: a weaker wind is none

}  // namespace

float windArrowHeight(const WindowSize& size) {
  return (kCorner + kScale * kMaxArrowWind + kTipRadius) * size.interfaceScale;
}

Float3 turnedWind(const Float3& before, float speed, float angle) {
  const float now = std::sqrt(dot(before, before));
  const float rise = now > 0 ? before.y / now : 0;
  const float level = speed * std::sqrt(std::max(1 - rise * rise, 0.0f));
  return {level * std::sin(angle), speed * rise, level * std::cos(angle)};
}

bool WindArrow::isOnTip(double x, double y) const {
  return std::hypot(x - double{tip.x}, y - double{tip.y}) <= double{tipRadius};
}

WindArrow windArrowOf(const OrbitCamera& camera, const Float3& wind, const WindowSize& size) {
  WindArrow arrow;
  const float scale = kScale * size.interfaceScale;
  arrow.base = {static_cast<float>(size.width) - kCorner * size.interfaceScale,
                static_cast<float>(size.height) - kCorner * size.interfaceScale};
  arrow.tip = {arrow.base.x + scale * dot(wind, camera.right()),
               arrow.base.y - scale * dot(wind, camera.up())};
  arrow.tipRadius = kTipRadius * size.interfaceScale;
  return arrow;
}

Float3 windOfTip(const OrbitCamera& camera, const Float3& before, const WindowSize& size, double x,
                 double y) {
  const WindArrow arrow = windArrowOf(camera, {}, size);
  const float scale = kScale * size.interfaceScale;
  float right = (static_cast<float>(x) - arrow.base.x) / scale;
  float up = (arrow.base.y - static_cast<float>(y)) / scale;
  const float speed = std::hypot(right, up);
  const float factor = speed < kCalm ? 0 : std::min(1.0f, kMaxArrowWind / speed);
  right *= factor;
  up *= factor;
  const Float3 along = camera.direction(), r = camera.right(), u = camera.up();
  const float depth = dot(before, along);
  return {right * r.x + up * u.x + depth * along.x, right * r.y + up * u.y + depth * along.y,
          right * r.z + up * u.z + depth * along.z};
}

namespace {

constexpr double kZoomStep = 1.1;      // factor of a step of the wheel
constexpr float kBallStep = 0.25f;     // radii that a step of the wheel moves the ball
constexpr double kSlowest = 1.0 / 16;  // PlayClock::speed
constexpr double kFastest = 4;

// Width over height of a side.
float aspectOf(const WindowSize& size, const Stage& stage) {
  return static_cast<float>(size.width) /
         static_cast<float>(std::max(size.height, 1u) * stage.sides());
}

// Returns the position of the mouse within its side.
MouseMoved inSide(const MouseMoved& mouse, const WindowSize& size, const Stage& stage) {
  const double width = static_cast<double>(std::max(size.width, 1u)) / stage.sides();
  const double side = std::clamp(std::floor(mouse.x / width), 0.0, stage.sides() - 1.0);
  return {mouse.x - side * width, mouse.y};
}

// Returns the point under the mouse in a plane that faces the camera.
pelage::Float3 pointOn(const pelage::Float3& plane, const MouseMoved& mouse, const WindowSize& size,
                       const Stage& stage) {
  const auto share = [](double at, double of) {
    return static_cast<float>(at / std::max(of, 1.0));
  };
  const MouseMoved within = inSide(mouse, size, stage);
  return stage.camera.pointAt(share(within.x * stage.sides(), size.width),
                              share(within.y, size.height), aspectOf(size, stage), plane);
}

// Moves the ball under the mouse at its depth, at first at the depth of the camera's target.
void moveBall(const MouseMoved& mouse, const WindowSize& size, Stage& stage) {
  stage.ball.center =
      pointOn(stage.ball.present ? stage.ball.center : stage.camera.target(), mouse, size, stage);
  stage.ball.present = true;
}

void askForHair(const MouseMoved& mouse, const WindowSize& size, Stage& stage) {
  const pelage::Float3 top = stage.camera.pointAt(0.5f, 0, 1, stage.camera.target());
  const pelage::Float3 middle = stage.camera.target();
  const float half =
      std::sqrt((top.x - middle.x) * (top.x - middle.x) + (top.y - middle.y) * (top.y - middle.y) +
                (top.z - middle.z) * (top.z - middle.z));
  const MouseMoved within = inSide(mouse, size, stage);
  stage.pull.ask(stage.camera.view(std::max(size.width / stage.sides(), 1u), size.height),
                 static_cast<float>(within.x), static_cast<float>(within.y),
                 sample::kLockRadius * half);
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
    askForHair(mouse_, size, stage);
  } else if (control_) {
    drag_ = Drag::kBall;
    moveBall(mouse_, size, stage);
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
  if (drag_ == Drag::kBall) moveBall(mouse_, size, stage);
  if (drag_ == Drag::kPull && stage.pull.holds())
    stage.pull.dragTo(pointOn(stage.pull.point(), mouse_, size, stage));
  if (drag_ == Drag::kWind)
    stage.look.wind = windOfTip(stage.camera, stage.look.wind, size, event.x, event.y);
}

// Moves the ball that is dragged, or the camera.
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

void StageControls::keepOrTakeCamera(size_t index, Stage& stage) {
  std::optional<OrbitCamera>& kept = cameras_[index];
  if (control_)
    kept = stage.camera;
  else if (kept)
    stage.camera = *kept;
}

void StageControls::key(const KeyPressed& event, const WindowSize& size, Stage& stage) {
  if (event.key == kKeyLeftShift || event.key == kKeyRightShift) shift_ = event.down;
  if (event.key == kKeyLeftControl || event.key == kKeyRightControl) control_ = event.down;
  if (event.key == kKeyLeftAlt || event.key == kKeyRightAlt || event.key == 'G')
    pulls_ = event.down;
  if (event.down && event.key >= '1' && event.key <= '9')
    keepOrTakeCamera(static_cast<size_t>(event.key - '1'), stage);
  if (!event.down || control_) return;
  PlayClock& clock = stage.clock;
  if (event.key == 'F') stage.frameAll(aspectOf(size, stage));
  if (event.key == kKeySpace) clock.playing = !clock.playing;
  if (event.key == '.') clock.steps = true;
  if (event.key == 'R') stage.reset();
  if (event.key == 'L') clock.loops = !clock.loops;
  if (event.key == '-') clock.speed = std::max(clock.speed / 2, kSlowest);
  if (event.key == '=') clock.speed = std::min(clock.speed * 2, kFastest);
  if (event.key == 'B') stage.ball.present = false;
  if (event.key == 'V') stage.inspection.show(shift_);
  if (event.key == 'E') stage.chooseSide(1 - std::min(stage.side(), 1u));
  if (event.key == 'C') stage.look.showsContacts = !stage.look.showsContacts;
}

}  // namespace viewer
