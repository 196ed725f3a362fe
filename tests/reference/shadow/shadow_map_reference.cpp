#include "reference/shadow/shadow_map_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pelage::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A point on the map: what is linear there, whatever the projection.
struct MapPoint {
  Vector2d texel;
  double inverse, depth, radius;  // 1, distance and radius over w
};

MapPoint lerp(const MapPoint& a, const MapPoint& b, double t) {
  return {a.texel + (b.texel - a.texel) * t, a.inverse + (b.inverse - a.inverse) * t,
          a.depth + (b.depth - a.depth) * t, a.radius + (b.radius - a.radius) * t};
}

// Sorted fractions at which a line leaves a row of texels, with both ends.
std::vector<double> cutsOf(double from, double to) {
  std::vector<double> cuts = {0, 1};
  const double low = std::min(from, to), high = std::max(from, to);
  for (double edge = std::ceil(low + 0.5) - 0.5; edge <= high; ++edge)
    if (high > low) cuts.push_back(std::clamp((edge - from) / (to - from), 0.0, 1.0));
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

// The weight of a texel at a point between the middles of four.
double weightOf(const Vector2d& texel, int x, int y) {
  return std::max(0.0, 1 - std::abs(texel.x() - x)) * std::max(0.0, 1 - std::abs(texel.y() - y));
}

// \return false where all of it is in front of the near plane, z = 0.
bool cutAtNearPlane(const ShadowProjection& projection, ShadowFiber& fiber) {
  const double from = projection.z.dot(fiber.from.homogeneous());
  const double to = projection.z.dot(fiber.to.homogeneous());
  if (from < 0 && to < 0) return false;
  const double cut = from / (from - to);
  const Vector3d at = fiber.from + (fiber.to - fiber.from) * cut;
  const double radius = fiber.fromRadius + (fiber.toRadius - fiber.fromRadius) * cut;
  if (from < 0) {
    fiber.from = at;
    fiber.fromRadius = radius;
  } else if (to < 0) {
    fiber.to = at;
    fiber.toRadius = radius;
  }
  return true;
}

// The image of a thin fiber over 2 radius / w: by the plane through the light and the fiber.
double wideningOf(const ShadowProjection& projection, const ShadowFiber& fiber) {
  if (!projection.light) return 1;
  const Vector3d normal =
      (fiber.from - *projection.light).cross(fiber.to - *projection.light).normalized();
  const Vector3d axis = projection.w.head<3>().normalized();
  return 1 / std::sqrt(1 - std::pow(normal.dot(axis), 2));
}

}  // namespace

ShadowMapReference::ShadowMapReference(const ShadowProjection& projection,
                                       std::span<const ShadowFiber> fibers)
    : projection_(projection),
      texels_(size_t{projection.width} * projection.height, Texel{kInfinity, {}}) {
  for (const ShadowFiber& fiber : fibers) add(fiber);
}

void ShadowMapReference::add(const ShadowFiber& whole) {
  ShadowFiber fiber = whole;
  if (projection_.light && !cutAtNearPlane(projection_, fiber)) return;
  const double wider = wideningOf(projection_, fiber);
  const auto onMap = [&](const Vector3d& p, double radius) -> MapPoint {
    const Vector4d h(p.x(), p.y(), p.z(), 1);
    const double w = projection_.w.dot(h);
    return {Vector2d(projection_.x.dot(h), projection_.y.dot(h)) / w - Vector2d(0.5, 0.5), 1 / w,
            projection_.z.dot(h) / w, wider * radius / w / projection_.texelSize};
  };
  const MapPoint from = onMap(fiber.from, fiber.fromRadius);
  const MapPoint to = onMap(fiber.to, fiber.toRadius);
  const Vector2d offset = to.texel - from.texel;
  const int along = std::abs(offset.x()) > std::abs(offset.y()) ? 0 : 1, across = 1 - along;
  const std::vector<double> cuts = cutsOf(from.texel[along], to.texel[along]);
  for (size_t i = 1; i < cuts.size(); ++i) {
    const MapPoint a = lerp(from, to, cuts[i - 1]), b = lerp(from, to, cuts[i]);
    const MapPoint middle = lerp(from, to, (cuts[i - 1] + cuts[i]) / 2);
    const double area = 2 * offset.norm() * (cuts[i] - cuts[i - 1]) * fiber.opacity * middle.radius;
    int at[2];
    at[along] = static_cast<int>(std::floor(middle.texel[along] + 0.5));
    const double low = std::floor(middle.texel[across]);
    for (const double other : {low, low + 1}) {
      at[across] = static_cast<int>(other);
      if (std::min(at[0], at[1]) < 0 || at[0] >= static_cast<int>(projection_.width) ||
          at[1] >= static_cast<int>(projection_.height))
        continue;
      Texel& texel =
          texels_[static_cast<size_t>(at[1]) * projection_.width + static_cast<size_t>(at[0])];
      texel.nearest = std::min({texel.nearest, a.depth / a.inverse, b.depth / b.inverse});
      texel.parts.emplace_back(middle.depth / middle.inverse,
                               area * (1 - std::abs(middle.texel[across] - other)));
    }
  }
}

double ShadowMapReference::depthAt(int x, int y, double depth, const ShadowReading& reading) const {
  if (x < 0 || y < 0 || x >= static_cast<int>(projection_.width) ||
      y >= static_cast<int>(projection_.height))
    return 0;
  const Texel& texel = texels_[static_cast<size_t>(y) * projection_.width + static_cast<size_t>(x)];
  const double behind = depth - texel.nearest;
  if (!(behind > 0)) return 0;
  if (reading.layers == 0) return behind * reading.extinction;
  const auto layerOf = [&](double distance) {
    const double layer =
        std::floor(std::sqrt(std::max(distance, 0.0) / reading.layerRange) * reading.layers);
    return std::min(layer, reading.layers - 1.0);
  };
  const auto endOf = [&](double layer) {
    return reading.layerRange * std::pow(layer / reading.layers, 2);
  };
  const double layer = layerOf(behind);
  double before = 0, inside = 0;
  for (const auto& [partDepth, tau] : texel.parts) {
    const double own = layerOf(partDepth - texel.nearest);
    before += own < layer ? tau : 0;
    inside += own == layer ? tau : 0;
  }
  const double share = (behind - endOf(layer)) / (endOf(layer + 1) - endOf(layer));
  return before + inside * std::min(share, 1.0);
}

double ShadowMapReference::light(const Vector3d& point, const ShadowReading& reading) const {
  const Vector4d h(point.x(), point.y(), point.z(), 1);
  const double w = projection_.w.dot(h);
  const Vector2d texel =
      Vector2d(projection_.x.dot(h), projection_.y.dot(h)) / w - Vector2d(0.5, 0.5);
  const int left = static_cast<int>(std::floor(texel.x()));
  const int top = static_cast<int>(std::floor(texel.y()));
  ShadowReading here = reading;
  if (projection_.light) {
    const Vector3d ray = point - *projection_.light;
    here.extinction *= ray.norm() / w;
  }
  double sum = 0;
  for (int y = top; y <= top + 1; ++y)
    for (int x = left; x <= left + 1; ++x)
      sum += weightOf(texel, x, y) *
             std::exp(-depthAt(x, y, projection_.z.dot(h) - reading.bias * w, here));
  return sum;
}

}  // namespace pelage::reference
