// Points of the scene in the picture.
#pragma once

#include <optional>

#include "pelage/types.h"
#include "pelage/view.h"

namespace viewer {

/// A point in the picture: pixels from the top left, and its distance along the view [m].
struct PicturePoint {
  float x = 0, y = 0;
  float depth = 0;
};

/// Nothing for points that are not in front of the camera, and for those that are not finite.
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

}  // namespace viewer
