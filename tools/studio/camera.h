// A camera that sees all of something.
#pragma once

#include <optional>
#include <span>

#include "pelage/types.h"
#include "pelage/view.h"

namespace sample {

struct CameraDef {
  /// From the subject towards the camera; any length > 0.
  pelage::Float3 direction = {0.55f, 0.22f, 1.0f};
  float verticalFov = 0.42f;  ///< full angle [radians]: a portrait lens
  float margin = 0.06f;       ///< share of the picture that stays free at each edge, 0..0.4
};

struct Camera {
  pelage::Float3 eye, target;
  float verticalFov = 0;
  float near = 0;  ///< distance of the near plane [m]
  float far = 0;   ///< of the far plane [m]
};

/// The nearest camera in a direction for which every point is in the picture.
/// \param points at least one [m].
/// \param aspect width over height of the picture.
Camera frameAll(std::span<const pelage::Float3> points, const CameraDef& def, float aspect);

/// A camera where somebody wants it; members that are not given are found from the points.
struct CameraPlace {
  std::optional<pelage::Float3> eye = {};  ///< [m]; without it all points are in the picture
  std::optional<pelage::Float3> target =
      {};                                 ///< with an eye: what it looks at [m]; else their middle
  std::optional<float> verticalFov = {};  ///< full angle [radians]; else CameraDef::verticalFov
};

/// \param points, def, aspect as those of frameAll(). Its depth range holds the points before the
/// eye.
Camera placeCamera(std::span<const pelage::Float3> points, const CameraPlace& place,
                   const CameraDef& def, float aspect);

/// The view of a camera on a target of this size.
pelage::View makeView(const Camera& camera, uint32_t width, uint32_t height, uint32_t samples);

}  // namespace sample
