#include "stage/orbit_camera.h"

#include <algorithm>
#include <cmath>

#include "float3_math.h"

namespace viewer {

using pelage::Float3;
using sample::add;
using sample::dot;

namespace {

constexpr float kMaxPitch = 1.5f;                            // [radians]
constexpr float kMinDistance = 0.005f, kMaxDistance = 1e5f;  // [m]

}  // namespace

void OrbitCamera::frame(const sample::Camera& camera) {
  const Float3 back = add(camera.eye, camera.target, -1);
  distance_ = std::max(std::sqrt(dot(back, back)), kMinDistance);
  yaw_ = std::atan2(back.x, back.z);
  pitch_ = std::asin(std::clamp(back.y / distance_, -1.0f, 1.0f));
  target_ = camera.target;
  verticalFov_ = camera.verticalFov;
  range_ = std::max(camera.far - distance_, distance_);
}

void OrbitCamera::orbit(float right, float up) {
  yaw_ = std::remainder(yaw_ - right, 6.2831853f);
  pitch_ = std::clamp(pitch_ + up, -kMaxPitch, kMaxPitch);
}

void OrbitCamera::pan(float right, float up) {
  const float height = 2 * distance_ * std::tan(verticalFov_ / 2);
  target_ = add(add(target_, this->right(), right * height), this->up(), up * height);
}

void OrbitCamera::zoom(float factor) {
  if (factor > 0) distance_ = std::clamp(distance_ / factor, kMinDistance, kMaxDistance);
}

Float3 OrbitCamera::direction() const {
  return {std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_), std::cos(yaw_) * std::cos(pitch_)};
}

Float3 OrbitCamera::right() const { return {std::cos(yaw_), 0, -std::sin(yaw_)}; }

Float3 OrbitCamera::up() const {
  return {-std::sin(yaw_) * std::sin(pitch_), std::cos(pitch_), -std::cos(yaw_) * std::sin(pitch_)};
}

Float3 OrbitCamera::eye() const { return add(target_, direction(), distance_); }

pelage::View OrbitCamera::view(uint32_t width, uint32_t height, bool reversedDepth) const {
  sample::Camera camera;
  camera.eye = eye();
  camera.target = target_;
  camera.verticalFov = verticalFov_;
  camera.near = distance_ * 0.02f;
  camera.far = distance_ + range_;
  pelage::View view = sample::makeView(camera, width, height, 1);
  if (!reversedDepth) return view;
  view.reversedDepth = true;
  view.worldToClip = pelage::lookAt(camera.eye, camera.target, {0, 1, 0}, camera.verticalFov,
                                    static_cast<float>(width) / static_cast<float>(height),
                                    camera.near, camera.far, true);
  return view;
}

Float3 OrbitCamera::pointAt(float x, float y, float aspect, const Float3& plane) const {
  return sample::pointAt({.eye = eye(), .target = target_, .verticalFov = verticalFov_}, x, y,
                         aspect, plane);
}

}  // namespace viewer
