// Area that strands cover, seen from a light, in double precision and without a map.
#pragma once

#include <Eigen/Core>
#include <span>

namespace pelage::reference {

/// A straight piece of a strand, thin against whatever it shades.
struct ShadowFiber {
  Eigen::Vector3d from, to;     ///< [m]
  double fromRadius, toRadius;  ///< [m]
  double opacity;               ///< 0..1
};

/// Axes of a light whose rays are parallel: unit vectors at right angles.
struct LightAxes {
  Eigen::Vector3d x, y, toLight;
};

/// Opacity-weighted area that fibers cover, without regard to what covers what [m2].
double coveredArea(std::span<const ShadowFiber> fibers, const LightAxes& light);

/// Optical depth in front of a point, in a square beam around it: the covered area over that of the
/// beam. \param width edge of the square, along the axes [m].
double beamDepth(std::span<const ShadowFiber> fibers, const LightAxes& light,
                 const Eigen::Vector3d& point, double width);

}  // namespace pelage::reference
