#include "rest_strand.h"

#include <cmath>
#include <numbers>
#include <numeric>

namespace pelage::reference {

RestStrand::RestStrand(std::vector<Vector3d> points) : positions(std::move(points)) {
  const int n = size();
  lengths.resize(n - 1);
  for (int j = 0; j + 1 < n; ++j) {
    lengths[j] = reference::length(positions[j + 1] - positions[j]);
  }
  const double total = length();
  const auto hasDirection = [&](int j) { return lengths[j] > 1e-12 * total && lengths[j] > 0; };
  Vector3d tangent(0, -1, 0);
  for (int j = 0; j + 1 < n; ++j) {
    if (hasDirection(j)) {
      tangent = (positions[j + 1] - positions[j]) * (1 / lengths[j]);
      break;
    }
  }
  Quaterniond frame = rotationBetween(Vector3d(1, 0, 0), tangent);
  for (int j = 0; j + 1 < n; ++j) {
    // An edge without a direction continues the one before.
    const Vector3d next =
        hasDirection(j) ? (positions[j + 1] - positions[j]) * (1 / lengths[j]) : tangent;
    frame = normalized(rotationBetween(tangent, next) * frame);
    frames.push_back(frame);
    tangent = next;
  }
  regionFloor = std::max(1e-3 * total / (n - 1), 1e-7);
  double arc = 0;
  for (int i = 0; i < n; ++i) {
    const double before = i > 0 ? lengths[i - 1] : 0;
    const double after = i + 1 < n ? lengths[i] : 0;
    const double region = i == 1 ? rootRegion(before, after, total) : 0.5 * (before + after);
    regions.push_back(std::max(region, regionFloor));
    arc += before;
    share.push_back(total > 0 ? arc / total : 0);
  }
  stiffness.assign(n, 1);
  relative.push_back(frames[0]);
  for (int i = 1; i + 1 < n; ++i) {
    relative.push_back(normalized(conjugate(frames[i - 1]) * frames[i]));
  }
}

double rootRegion(double first, double second, double total) {
  const double end = first + 0.5 * second, left = total - first;
  const double whole = std::pow(total, 4) - std::pow(total - end, 4), at = 4 * std::pow(left, 3);
  return whole < 3 * end * at ? whole / at : 3 * end;
}

double RestStrand::length() const { return std::accumulate(lengths.begin(), lengths.end(), 0.0); }

RootPose interpolatePoses(const RootPose& a, const RootPose& b, double t, const Vector3d& pivot) {
  RootPose pose;
  pose.rotation = interpolate(a.rotation, b.rotation, t);
  const Vector3d from = a.apply(pivot), to = b.apply(pivot);
  pose.translation = from + (to - from) * t - rotate(pose.rotation, pivot);
  return pose;
}

std::vector<Vector3d> straightPoints(int n, double size, const Vector3d& direction) {
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(direction * (size * i / (n - 1)));
  return points;
}

std::vector<Vector3d> helixPoints(int n, double radius, double pitch, double turns) {
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / (n - 1);
    const double angle = 2 * std::numbers::pi * turns * share;
    points.emplace_back(radius * std::cos(angle) - radius, -pitch * turns * share,
                        radius * std::sin(angle));
  }
  return points;
}

}  // namespace pelage::reference
