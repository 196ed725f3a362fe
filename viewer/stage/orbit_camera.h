// A camera that orbits a point.
#pragma once

#include <cstdint>

#include "camera.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace viewer {

class OrbitCamera {
 public:
  /// Takes position, target and field of view of a camera.
  void frame(const sample::Camera& camera);
  /// Orbits the target by angles [radians]: > 0 to the right and up. It never looks straight down
  /// or up.
  void orbit(float right, float up);
  /// Moves sideways, by shares of the picture's height at the target: > 0 to the right and up.
  void pan(float right, float up);
  /// Divides the distance to the target by a factor: > 1 comes nearer.
  void zoom(float factor);

  /// Returns the unit vector from the target to the camera.
  pelage::Float3 direction() const;
  pelage::Float3 eye() const;
  pelage::Float3 target() const { return target_; }
  /// Return unit vectors to the right and up in the picture.
  pelage::Float3 right() const;
  pelage::Float3 up() const;
  float distance() const { return distance_; }
  pelage::View view(uint32_t width, uint32_t height, bool reversedDepth = false) const;
  /// Returns the intersection of a pixel's ray with a plane that faces the camera. \param x, y
  /// shares of the picture from the top left, 0..1. \param aspect width over height. \param plane a
  /// point of the plane.
  pelage::Float3 pointAt(float x, float y, float aspect, const pelage::Float3& plane) const;

 private:
  pelage::Float3 target_;
  float yaw_ = 0;       // [radians] about +y, 0 looks from +z
  float pitch_ = 0;     // [radians] above the horizon
  float distance_ = 1;  // [m]
  float verticalFov_ = 0.42f;
  float range_ = 1;  // [m] from the target to the far plane
};

}  // namespace viewer
