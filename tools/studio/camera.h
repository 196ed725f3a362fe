// A camera that sees all of something, and points in its picture.
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

/// The intersection of a pixel's ray with a plane that faces the camera. \param x, y shares of the
/// picture from the top left, 0..1. \param aspect width over height. \param plane a point of the
/// plane.
pelage::Float3 pointAt(const Camera& camera, float x, float y, float aspect,
                       const pelage::Float3& plane);

/// A point in the picture: pixels from the top left, and its distance along the view [m].
struct PicturePoint {
  float x = 0, y = 0;
  float depth = 0;
};

/// Projects a point; nothing if it is not in front of the camera, or not finite.
inline std::optional<PicturePoint> project(const pelage::View& view, const pelage::Float3& point) {
  const auto row = [&](int i) {
    const pelage::Float4& of = view.worldToClip.rows[i];
    return of.x * point.x + of.y * point.y + of.z * point.z + of.w;
  };
  const float w = row(3);
  if (!(w > 0)) return std::nullopt;
  const float x = row(0) / w, y = row(1) / w;
  if (!(x * x + y * y < 1e12f)) return std::nullopt;
  return PicturePoint{(0.5f + 0.5f * x) * static_cast<float>(view.width),
                      (0.5f - 0.5f * y) * static_cast<float>(view.height), w};
}

}  // namespace sample
