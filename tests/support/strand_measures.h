// Rigid motions of hair, and measures of how it differs from other hair and from its rest lengths.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/skeleton.h"
#include "support/extremes.h"
#include "support/strand_run.h"

namespace pelage::test {

inline Float3 toFloat3(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

inline AffineTransform toTransform(const Eigen::Matrix3d& rotation, const Vector3d& shift) {
  AffineTransform result;
  for (int row = 0; row < 3; ++row)
    result.rows[row] = toFloat4(rotation.row(row).transpose(), shift[row]);
  return result;
}

struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3d shift = {0, 0, 0};

  static RigidMotion about(double angle, const Vector3d& axis, const Vector3d& shift = {0, 0, 0}) {
    return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), shift};
  }
  Vector3d operator()(const Vector3d& p) const { return rotation * p + shift; }
  Vector3d operator()(const Float4& p) const { return rotation * toVector(p) + shift; }
  RigidMotion operator*(const RigidMotion& first) const {
    return {rotation * first.rotation, rotation * first.shift + shift};
  }
  /// As directions see it.
  RigidMotion withoutShift() const { return {rotation, {0, 0, 0}}; }
  AffineTransform transform() const { return toTransform(rotation, shift); }
};

inline double distance(const Float4& a, const Float4& b) {
  return (toVector(a) - toVector(b)).norm();
}

/// Largest distance of two vertices, those of `b` after a motion; NaN where something is not a
/// number, and infinite where there is nothing or not as much.
template <class Point>
double maxDistance(const std::vector<Point>& a, const std::vector<Point>& b,
                   const RigidMotion& ofB = {}) {
  if (a.empty() || a.size() != b.size()) return std::numeric_limits<double>::infinity();
  const RigidMotion still;
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) keepLargest(largest, (still(a[i]) - ofB(b[i])).norm());
  return largest;
}

inline bool allFinite(const std::vector<Float4>& values) {
  return std::all_of(values.begin(), values.end(), [](const Float4& v) { return isFinite(v); });
}

inline bool sameBits(const Float4& a, const Float4& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// False for nothing.
template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return !a.empty() && a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// Largest deviation of an edge from its rest length over that length. \param first  edge of each
/// strand that counts as the first one
inline double maxStretch(const HairAsset& asset, const std::vector<Float4>& positions,
                         uint32_t first = 0) {
  double largest = 0;
  for (size_t i = 0; i + 1 < asset.positions.size(); ++i) {
    const double rest = static_cast<double>(asset.restLengths[i]);
    if (rest > 0 && i % asset.verticesPerStrand >= first)
      keepLargest(largest, std::abs(distance(positions[i], positions[i + 1]) / rest - 1));
  }
  return largest;
}

}  // namespace pelage::test
