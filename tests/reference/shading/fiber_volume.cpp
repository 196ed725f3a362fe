#include "reference/shading/fiber_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

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

double fiberShare(const FiberBody& body, const EyeRay& ray) {
  const Vector3d into = -ray.toEye;
  return 1 - std::exp(-extinctionAlong(into) * body.toEnd(ray.from, into));
}

FiberPoint firstFiber(const FiberBody& body, const EyeRay& ray, double random) {
  if (random >= fiberShare(body, ray)) return {};
  const Vector3d into = -ray.toEye;
  return {true, ray.from - into * (std::log(1 - random) / extinctionAlong(into))};
}

std::vector<double> lightOfPaths(const FiberBody& body, const Fiber& fiber,
                                 std::span<const double> absorptions, const Vector3d& toLight,
                                 std::span<const EyeRay> rays, uint64_t seed) {
  constexpr double kFaint = 0.05;
  const bool isSky = toLight.isZero();
  std::mt19937_64 generator(seed);
  const auto unit = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  std::vector<double> sum(absorptions.size()), weights(absorptions.size()),
      light(absorptions.size(), 1.0);
  const auto add = [&](double share) {
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += share * weights[i] * light[i];
  };
  for (EyeRay ray : rays) {
    std::fill(weights.begin(), weights.end(), 1.0);
    bool scattered = false;
    while (true) {
      const FiberPoint at = firstFiber(body, ray, unit());
      if (!at.hit) {
        if (isSky && scattered) add(1);
        break;
      }
      scattered = true;
      const double offset = 2 * unit() - 1;
      if (!isSky) {
        const double depth = extinctionAlong(toLight) * body.toEnd(at.position, toLight);
        nearScattering(fiber, absorptions, kFiberAxis, ray.toEye, toLight, offset, light);
        add(std::numbers::pi * std::exp(-depth));
      }
      const Vector3d next = sampleScattering(fiber, absorptions, kFiberAxis, ray.toEye, offset,
                                             {unit(), unit(), unit(), unit()}, weights);
      // Russian roulette.
      if (*std::max_element(weights.begin(), weights.end()) < kFaint) {
        if (unit() < 0.5) break;
        for (double& weight : weights) weight *= 2;
      }
      ray = {at.position, -next};
    }
  }
  for (double& of : sum) of /= static_cast<double>(rays.size());
  return sum;
}

}  // namespace pelage::reference
