#include "reference/shadow/strand_shadow_reference.h"

#include <algorithm>

namespace pelage::reference {
namespace {

using Eigen::Vector3d;

// Share [from, to] of a line's way on which it is below the bound.
void clip(double begin, double end, double bound, double& from, double& to) {
  if (begin > bound && end > bound) {
    to = from;
  } else if (begin > bound) {
    from = std::max(from, (begin - bound) / (begin - end));
  } else if (end > bound) {
    to = std::min(to, (bound - begin) / (end - begin));
  }
}

double areaOf(const ShadowFiber& fiber, const LightAxes& light, double from, double to) {
  const Vector3d offset = fiber.to - fiber.from;
  const double seen = Eigen::Vector2d(light.x.dot(offset), light.y.dot(offset)).norm();
  const double middle = (from + to) / 2;
  const double radius = fiber.fromRadius + (fiber.toRadius - fiber.fromRadius) * middle;
  return 2 * radius * seen * (to - from) * fiber.opacity;
}

}  // namespace

double coveredArea(std::span<const ShadowFiber> fibers, const LightAxes& light) {
  double area = 0;
  for (const ShadowFiber& fiber : fibers) area += areaOf(fiber, light, 0, 1);
  return area;
}

double beamDepth(std::span<const ShadowFiber> fibers, const LightAxes& light, const Vector3d& point,
                 double width) {
  double area = 0;
  for (const ShadowFiber& fiber : fibers) {
    const Vector3d a = fiber.from - point, b = fiber.to - point;
    double from = 0, to = 1;
    clip(-light.toLight.dot(a), -light.toLight.dot(b), 0, from, to);
    for (const Vector3d& axis : {light.x, light.y}) {
      clip(axis.dot(a), axis.dot(b), width / 2, from, to);
      clip(-axis.dot(a), -axis.dot(b), width / 2, from, to);
    }
    if (from < to) area += areaOf(fiber, light, from, to);
  }
  return area / (width * width);
}

}  // namespace pelage::reference
