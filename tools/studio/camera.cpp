#include "camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "float3_math.h"
#include "pelage/assert.h"

namespace sample {

using pelage::Float3;

namespace {

// The eye's place along one axis of the picture, and how far back it must be, so that the two
// tightest rays of that axis touch the points. With t the tangent of the half angle, a point at s
// along the axis and z towards the camera demands |s - c| <= t (d - z) of the eye at (c, d): s + t
// z bounds c + t d from below, s - t z bounds c - t d from above.
struct AxisFit {
  float centre = 0, distance = 0;
};
AxisFit fitAxis(std::span<const Float3> points, const Float3& axis, const Float3& back,
                float tangent) {
  float high = -std::numeric_limits<float>::max(), low = std::numeric_limits<float>::max();
  for (const Float3& point : points) {
    const float s = dot(point, axis), z = tangent * dot(point, back);
    high = std::max(high, s + z);
    low = std::min(low, s - z);
  }
  return {(high + low) / 2, (high - low) / (2 * tangent)};
}

}  // namespace

Camera frameAll(std::span<const Float3> points, const CameraDef& def, float aspect) {
  PELAGE_ASSERT(!points.empty() && aspect > 0, "frameAll: no points, or no picture");
  const Float3 back = unit(def.direction);
  const Float3 right = unit(cross({0, 1, 0}, back));
  const Float3 up = cross(back, right);
  const float tangent = std::tan(def.verticalFov / 2) * (1 - 2 * def.margin);
  const AxisFit x = fitAxis(points, right, back, tangent * aspect);
  const AxisFit y = fitAxis(points, up, back, tangent);
  const float distance = std::max(x.distance, y.distance);

  float front = -std::numeric_limits<float>::max(), rear = std::numeric_limits<float>::max();
  for (const Float3& point : points) {
    front = std::max(front, dot(point, back));
    rear = std::min(rear, dot(point, back));
  }
  const float depth = std::max(front - rear, 1e-3f);

  Camera camera;
  camera.eye = add(add(add({}, right, x.centre), up, y.centre), back, distance);
  camera.target = add(camera.eye, back, (front + rear) / 2 - distance);
  camera.verticalFov = def.verticalFov;
  camera.near = std::max((distance - front) / 2, depth * 1e-2f);
  camera.far = distance - rear + 4 * depth;
  return camera;
}

pelage::View makeView(const Camera& camera, uint32_t width, uint32_t height, uint32_t samples) {
  pelage::View view;
  view.worldToClip = pelage::lookAt(camera.eye, camera.target, {0, 1, 0}, camera.verticalFov,
                                    static_cast<float>(width) / static_cast<float>(height),
                                    camera.near, camera.far);
  view.eye = camera.eye;
  view.width = width;
  view.height = height;
  view.samples = samples;
  return view;
}

}  // namespace sample
