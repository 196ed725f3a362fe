#include "reference/shading/fiber_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace pelage::reference {

using Eigen::Vector3d;

namespace {

/// Optical depth per meter along a direction.
double extinctionAlong(const Vector3d& direction) {
  return std::max(direction.cross(kFiberAxis).norm(), 1e-6);
}

}  // namespace

FiberBody fiberSlab(double thickness) {
  return {[thickness](const Vector3d& point, const Vector3d& direction) {
    const double depth = direction.z() > 0 ? -point.z() : thickness + point.z();
    return std::max(depth, 0.0) / std::max(std::abs(direction.z()), 1e-12);
  }};
}

FiberBody fiberBall(double radius) {
  return {[radius](const Vector3d& point, const Vector3d& direction) {
    const double along = point.dot(direction);
    return -along + std::sqrt(std::max(along * along - point.squaredNorm() + radius * radius, 0.0));
  }};
}

FiberPoint firstFiber(const FiberBody& body, const EyeRay& ray, double random) {
  const Vector3d into = -ray.toEye;
  const double distance = -std::log(1 - random) / extinctionAlong(into);
  if (distance >= body.toEnd(ray.from, into)) return {};
  return {true, ray.from + into * distance};
}

double lightOfPaths(const FiberBody& body, const Fiber& fiber, const Vector3d& toLight,
                    std::span<const EyeRay> rays, uint64_t seed) {
  constexpr double kFaint = 0.05;
  const bool isSky = toLight.isZero();
  std::mt19937_64 generator(seed);
  const auto unit = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  double sum = 0;
  for (EyeRay ray : rays) {
    double weight = 1;
    bool scattered = false;
    while (true) {
      const FiberPoint at = firstFiber(body, ray, unit());
      if (!at.hit) {
        if (isSky && scattered) sum += weight;
        break;
      }
      scattered = true;
      const double offset = 2 * unit() - 1;
      if (!isSky) {
        const double depth = extinctionAlong(toLight) * body.toEnd(at.position, toLight);
        sum += weight * std::numbers::pi * std::exp(-depth) *
               nearScattering(fiber, kFiberAxis, ray.toEye, toLight, offset);
      }
      const FiberSample next =
          sampleScattering(fiber, kFiberAxis, ray.toEye, offset, {unit(), unit(), unit(), unit()});
      weight *= next.weight;
      // Russian roulette.
      if (weight < kFaint) {
        if (unit() < 0.5) break;
        weight *= 2;
      }
      ray = {at.position, -next.toLight};
    }
  }
  return sum / static_cast<double>(rays.size());
}

}  // namespace pelage::reference
