// A strand at rest, in bind space: what the references and the kernel's buffers are made from.
#pragma once

#include <vector>

#include "vector_math.h"

namespace pelage::reference {

/// Rest data of one strand of n vertices (n >= 2) with n - 1 edges.
struct RestStrand {
  std::vector<Vector3d> positions;  ///< [n] in metres
  std::vector<double> lengths;      ///< [n - 1] of edges [m]; 0 for coincident vertices
  std::vector<double> share;        ///< [n] arc length from the root over the strand's, 0..1
  /// [n] Length that a vertex stands for (its Voronoi region) [m]; also its mass for unit linear
  /// density. That of vertex 1 (which has no mass, as it follows the root) is rootRegion(). Floored
  /// at a thousandth of the mean edge and at 1e-7 m, so that coincident vertices keep a mass and a
  /// finite stiffness.
  std::vector<double> regions;
  std::vector<Quaterniond> frames;  ///< [n - 1] of edges: x axis = tangent, parallel transport
  /// [n - 1] rotation from edge i - 1 to edge i in the frame of edge i - 1; entry 0 is the frame of
  /// edge 0 in bind space.
  std::vector<Quaterniond> relative;
  double regionFloor = 0;
  std::vector<double> stiffness;  ///< [n] factor of bend and twist at a vertex, > 0; 1

  explicit RestStrand(std::vector<Vector3d> points);
  int size() const { return static_cast<int>(positions.size()); }
  double length() const;
};

/// Length whose bending is in the joint at vertex 1: edge 0, which follows the root, and half of
/// edge 1. It is longer than these, because the moment and the lever are larger towards the clamp:
/// a straight strand of length T under its own weight bends by (T - s)^2, and moves its tip by (T -
/// s)^3, so that it is the integral of that from 0 to b = first + second / 2, over its value at
/// vertex 1. At most three times b, for strands that all but end there.
double rootRegion(double first, double second, double total);

/// Rigid motion of a strand's root from bind space: p -> rotate(rotation, p) + translation.
struct RootPose {
  Quaterniond rotation;
  Vector3d translation;

  Vector3d apply(const Vector3d& p) const { return rotate(rotation, p) + translation; }
};

/// Pose between two others: nlerp of rotations, lerp of the image of `pivot`.
RootPose interpolatePoses(const RootPose& a, const RootPose& b, double t, const Vector3d& pivot);

/// n points on a line of length `size` along the unit vector `direction`.
std::vector<Vector3d> straightPoints(int n, double size, const Vector3d& direction);
/// n points on a helix about the -y axis that starts in the origin.
std::vector<Vector3d> helixPoints(int n, double radius, double pitch, double turns);

}  // namespace pelage::reference
