#include "scenes/collider_depths.h"

#include <algorithm>
#include <cmath>

#include "reference/sdf/distance_oracle.h"

namespace bench {

using Eigen::Vector3d;
using pelage::Float3;

namespace {

Vector3d toEigen(const Float3& p) { return {p.x, p.y, p.z}; }

}  // namespace

double capsuleDistance(const pelage::CapsuleCollider& capsule, const Float3& site) {
  const Vector3d point = toEigen(site), head = toEigen(capsule.head);
  const Vector3d axis = toEigen(capsule.tail) - head;
  const double radius = static_cast<double>(capsule.headRadius);
  const double growth = static_cast<double>(capsule.tailRadius) - radius;
  const double length = axis.norm();
  const auto at = [&](double t) {
    return (point - head - t * axis).norm() - (radius + t * growth);
  };
  // One end holds the other one, or there is no axis.
  if (length <= std::abs(growth)) return std::min(at(0), at(1));
  // The distance from the sphere at t is convex in t; this is where its derivative is 0.
  const double along = (point - head).dot(axis) / (length * length);
  const double aside = (point - head - along * axis).norm();
  const double slope = growth / length;
  return at(std::clamp(along + aside * slope / (length * std::sqrt(1 - slope * slope)), 0.0, 1.0));
}

std::vector<double> depthsInMesh(const pelage::reference::TriangleMesh& mesh,
                                 std::span<const Float3> points) {
  std::vector<Vector3d> sites;
  sites.reserve(points.size());
  for (const Float3& p : points) sites.push_back(toEigen(p));
  const pelage::reference::DistanceOracle oracle(mesh);
  std::vector<double> depths = oracle.signedDistances(sites, kDeepest);
  for (double& depth : depths) depth = std::max(-depth, 0.0);
  return depths;
}

}  // namespace bench
