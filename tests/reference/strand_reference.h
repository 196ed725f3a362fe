// Strand ribbons and their light in double precision.
#pragma once

#include <Eigen/Core>

namespace pelage::reference {

/// Kajiya-Kay with two shifted highlights, linear RGB.
struct FiberLight {
  Eigen::Vector3d toLight, lightColor, ambient;
  double primaryStrength, primaryExponent, primaryShift;
  double secondaryStrength, secondaryExponent, secondaryShift;

  /// \param hair colour of the fiber; unit vectors.
  Eigen::Vector3d shade(const Eigen::Vector3d& tangent, const Eigen::Vector3d& toEye,
                        const Eigen::Vector3d& hair) const;
};

/// Width in pixels that a fiber has on the screen: the distance of the images of its two
/// silhouette lines, measured at right angles to the fiber's image.
/// \param worldToClip rows, clip y up.
double projectedWidth(const Eigen::Matrix4d& worldToClip, const Eigen::Vector2d& viewport,
                      const Eigen::Vector3d& eye, const Eigen::Vector3d& position,
                      const Eigen::Vector3d& tangent, double radius);

}  // namespace pelage::reference
