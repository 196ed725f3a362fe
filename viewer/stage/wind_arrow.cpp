#include "stage/wind_arrow.h"

#include <algorithm>
#include <cmath>

#include "float3_math.h"

namespace viewer {

using pelage::Float3;
using sample::dot;

namespace {

constexpr float kScale = 4;      // at interface scale 1: window coordinates per m/s
constexpr float kCorner = 100;   // likewise: of the base from the bottom right corner
constexpr float kTipRadius = 9;  // likewise
constexpr float kCalm = 0.5f;    // [m/s]: less is none

}  // namespace

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

}  // namespace viewer
