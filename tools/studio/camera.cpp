#include "camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "float3_math.h"
#include "names.h"
#include "pelage/assert.h"

namespace sample {

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

Camera placeCamera(std::span<const Float3> points, const CameraPlace& place, const CameraDef& def,
                   float aspect) {
  CameraDef framed = def;
  framed.verticalFov = place.verticalFov.value_or(def.verticalFov);
  if (!place.eye) return frameAll(points, framed, aspect);
  Camera camera;
  camera.verticalFov = framed.verticalFov;
  camera.eye = *place.eye;
  Float3 low = points[0], high = points[0];
  for (const Float3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  camera.target = place.target.value_or(
      Float3{(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2});
  const Float3 view = add(camera.target, camera.eye, -1);
  const Float3 forward = dot(view, view) > 0 ? unit(view) : Float3{0, 0, -1};
  if (!(dot(view, view) > 0)) camera.target = add(camera.eye, forward);
  float nearest = std::numeric_limits<float>::max(), farthest = 0;
  for (const Float3& p : points) {
    const float distance = dot(add(p, camera.eye, -1), forward);
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  // The margins are those of frameAll(): hair moves out of its bind shape.
  const float depth = std::max(farthest - nearest, 1e-3f);
  camera.near = std::max(nearest / 2, depth * 1e-2f);
  camera.far = std::max(farthest, camera.near) + 4 * depth;
  return camera;
}

pelage::View makeView(const Camera& camera, uint32_t width, uint32_t height, uint32_t samples) {
  pelage::View view;
  // Seen from straight above or below, -z is up.
  const Float3 forward = unit(add(camera.target, camera.eye, -1));
  const bool vertical = std::hypot(forward.x, forward.z) < 1e-4f;
  const Float3 up = vertical ? Float3{0, 0, -1} : Float3{0, 1, 0};
  view.worldToClip = pelage::lookAt(camera.eye, camera.target, up, camera.verticalFov,
                                    static_cast<float>(width) / static_cast<float>(height),
                                    camera.near, camera.far);
  view.eye = camera.eye;
  view.width = width;
  view.height = height;
  view.samples = samples;
  return view;
}

Float3 pointAt(const Camera& camera, float x, float y, float aspect, const Float3& plane) {
  const Float3 back = unit(add(camera.eye, camera.target, -1));
  const Float3 right = unit(cross({0, 1, 0}, back));
  const float tangent = std::tan(camera.verticalFov / 2);
  const float depth = dot(add(camera.eye, plane, -1), back);
  const Float3 middle = add(camera.eye, back, -depth);
  return add(add(middle, right, (2 * x - 1) * tangent * aspect * depth), cross(back, right),
             (1 - 2 * y) * tangent * depth);
}

}  // namespace sample
