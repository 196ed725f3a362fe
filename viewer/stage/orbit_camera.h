// A camera that turns about a point.
#pragma once

#include <cstdint>

#include "camera.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace viewer {

class OrbitCamera {
 public:
  /// Looks from where a camera stands, at its target.
  void frame(const sample::Camera& camera);
  /// Turns about the target [radians]: > 0 to the right and up. It never looks straight down or up.
  void orbit(float right, float up);
  /// Moves sideways, by shares of the picture's height at the target: > 0 to the right and up.
  void pan(float right, float up);
  /// Comes nearer by a factor: > 1 nearer.
  void zoom(float factor);

  /// From the target towards the camera, a unit vector.
  pelage::Float3 direction() const;
  pelage::Float3 eye() const;
  pelage::Float3 target() const { return target_; }
  /// Unit vectors to the right and up in the picture.
  pelage::Float3 right() const;
  pelage::Float3 up() const;
  float distance() const { return distance_; }
  pelage::View view(uint32_t width, uint32_t height, bool reversedDepth = false) const;
  /// Where a pixel's ray meets the plane through a point that faces the camera. \param x, y shares
  /// of the picture from the top left, 0..1.
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
