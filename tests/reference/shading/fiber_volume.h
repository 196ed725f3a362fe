// Light in a volume of parallel fibers at random places, by paths from the eye: what a renderer
// with fibers of fiber_reference.h would draw.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "reference/shading/fiber_reference.h"

namespace pelage::reference {

/// A body of fibers along x. A meter across the fibers has an optical depth of 1.
struct FiberBody {
  /// Distance from a point in the body to its end [m].
  std::function<double(const Eigen::Vector3d& point, const Eigen::Vector3d& direction)> toEnd;
};
FiberBody fiberSlab(double thickness);  ///< between z = 0 and -thickness
FiberBody fiberBall(double radius);

/// Where a ray to the eye leaves a body.
struct EyeRay {
  Eigen::Vector3d from;
  Eigen::Vector3d toEye;
};

/// Where light leaves a fiber towards the eye, without what other fibers take of it.
struct FiberPoint {
  bool hit = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};
/// Chance that a ray from the eye meets a fiber.
double fiberShare(const FiberBody& body, const EyeRay& ray);
/// The first fiber that a ray from the eye meets, by chance. \param random 0..1: from fiberShare()
/// on, it meets none
FiberPoint firstFiber(const FiberBody& body, const EyeRay& ray, double random);

inline const Eigen::Vector3d kFiberAxis(1, 0, 0);

/// Mean light to the eye along the rays [absorption], for fibers that differ in absorption alone,
/// from a light of 1 (irradiance pi) in direction `toLight`, which has not passed the body without
/// being scattered; for `toLight` of length 0 from light of radiance 1 on all sides.
std::vector<double> lightOfPaths(const FiberBody& body, const Fiber& fiber,
                                 std::span<const double> absorptions,
                                 const Eigen::Vector3d& toLight, std::span<const EyeRay> rays,
                                 uint64_t seed);

}  // namespace pelage::reference
