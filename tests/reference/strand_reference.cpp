#include "reference/strand_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pelage::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double highlight(const Vector3d& tangent, const Vector3d& normal, const Vector3d& toLight,
                 const Vector3d& toEye, double shift, double exponent) {
  const Vector3d tilted = (tangent + shift * normal).normalized();
  const double cosine = tilted.dot((toLight + toEye).normalized());
  const double t = std::clamp(cosine + 1, 0.0, 1.0);
  return t * t * (3 - 2 * t) * std::pow(std::sqrt(1 - cosine * cosine), exponent);
}

Vector2d toPixels(const Eigen::Matrix4d& worldToClip, const Vector2d& viewport,
                  const Vector3d& position) {
  const Eigen::Vector4d clip = worldToClip * position.homogeneous();
  return (clip.head<2>() / clip.w()).cwiseProduct(viewport * 0.5);
}

}  // namespace

Vector3d FiberLight::shade(const Vector3d& tangent, const Vector3d& toEye,
                           const Vector3d& hair) const {
  const Vector3d normal = (toEye - tangent * tangent.dot(toEye)).normalized();
  const double cosine = tangent.dot(toLight);
  const double diffuse = std::sqrt(1 - cosine * cosine);
  const double primary =
      primaryStrength * highlight(tangent, normal, toLight, toEye, primaryShift, primaryExponent);
  const double secondary = secondaryStrength * highlight(tangent, normal, toLight, toEye,
                                                         secondaryShift, secondaryExponent);
  const Vector3d lit = hair * (diffuse + secondary) + Vector3d::Constant(primary);
  return ambient.cwiseProduct(hair) + lightColor.cwiseProduct(lit);
}

double projectedWidth(const Eigen::Matrix4d& worldToClip, const Vector2d& viewport,
                      const Vector3d& eye, const Vector3d& position, const Vector3d& tangent,
                      double radius) {
  // Finite differences: independent of the kernel's derivatives.
  const double d = 1e-6 * (eye - position).norm();
  const Vector3d across = tangent.cross(eye - position).normalized();
  const auto motion = [&](const Vector3d& direction) -> Vector2d {
    return (toPixels(worldToClip, viewport, position + d * direction) -
            toPixels(worldToClip, viewport, position - d * direction)) /
           (2 * d);
  };
  const Vector2d along = motion(tangent).normalized();
  const Vector2d width = motion(across);
  return 2 * radius * std::abs(along.x() * width.y() - along.y() * width.x());
}

}  // namespace pelage::reference
