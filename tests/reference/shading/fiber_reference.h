// Light scattered by a fiber in double precision, written from the papers: d'Eon et al. 2011 along
// the fiber, Chiang et al. 2016 around it. It has angles where the kernels have sines and cosines.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace pelage::reference {

struct Fiber {
  double betaM = 0.3;  ///< longitudinal roughness
  double betaN = 0.3;  ///< azimuthal roughness
  double tilt = 0;     ///< of the scales [rad]
  double ior = 1.55;
  double absorption = 0;  ///< along one radius
};

/// Chiang et al. 2016, equation 9.
double absorptionOf(double albedo, double betaN);

/// f cos(theta of the light) [1/sr] for a ray to the eye at `offset` of the fiber's radius,
/// positive towards tangent x toEye. Unit vectors.
double nearScattering(const Fiber& fiber, const Eigen::Vector3d& tangent,
                      const Eigen::Vector3d& toEye, const Eigen::Vector3d& toLight, double offset);

/// Mean of nearScattering() over the offsets, by `steps` midpoints of the arc.
double farScattering(const Fiber& fiber, const Eigen::Vector3d& tangent,
                     const Eigen::Vector3d& toEye, const Eigen::Vector3d& toLight, int steps);

/// nearScattering() of fibers that differ in absorption alone. \param light [absorption]
void nearScattering(const Fiber& fiber, std::span<const double> absorptions,
                    const Eigen::Vector3d& tangent, const Eigen::Vector3d& toEye,
                    const Eigen::Vector3d& toLight, double offset, std::span<double> light);

/// A direction towards the light, by chance: the lobe by the light that all of these fibers send
/// together (Chiang et al. 2016), the direction by the lobe (d'Eon et al. 2011). \param random four
/// numbers in 0..1. \param weights [absorption] of the path, multiplied by nearScattering() over
/// the density of the direction
Eigen::Vector3d sampleScattering(const Fiber& fiber, std::span<const double> absorptions,
                                 const Eigen::Vector3d& tangent, const Eigen::Vector3d& toEye,
                                 double offset, const std::array<double, 4>& random,
                                 std::span<double> weights);

}  // namespace pelage::reference
