#include "surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "points.h"

namespace pelage::detail {
namespace {

constexpr uint64_t kMaxSearches = 10'000'000;

struct Probe {
  Vector position;
  double distance = 0;
  uint32_t nearest = 0;  // triangle of the other surface
};

using Triangle = std::array<Vector, 3>;

double distance(const Vector& point, const Triangle& triangle) {
  return std::sqrt(closestPoint(point, triangle).squaredDistance);
}

// Upper bound over all of the triangle of three probes, from one of the others.
double boundFrom(const std::array<Probe, 3>& corners, const Triangle& triangle) {
  double bound = 0;
  for (const Probe& corner : corners) bound = std::max(bound, distance(corner.position, triangle));
  return bound;
}

// The normal of the plane through the common edge of two triangles that has one on each side, and a
// point of it; false when they have no common edge or lie on each other.
bool planeBetween(const Triangle& a, const Triangle& b, Vector& origin, Vector& normal) {
  const auto isAt = [](const Vector& p, const Vector& q) {
    return p.x == q.x && p.y == q.y && p.z == q.z;
  };
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) {
      const Vector &from = a[i], &to = a[(i + 1) % 3];
      const Vector &p = b[j], &q = b[(j + 1) % 3];
      if (!(isAt(from, p) && isAt(to, q)) && !(isAt(from, q) && isAt(to, p))) continue;
      const Vector edge = to - from;
      const double square = dot(edge, edge);
      if (!(square > 0)) return false;
      const auto across = [&](const Vector& corner) {
        const Vector d = corner - from;
        return unitOrZero(d - edge * (dot(d, edge) / square));
      };
      origin = from;
      normal = across(b[(j + 2) % 3]) - across(a[(i + 2) % 3]);
      return dot(normal, normal) > 1e-12;
    }
  return false;
}

// Upper bound when two of the others are near: the plane between them cuts the triangle of the
// probes, and each side is held against its own.
double boundFromTwo(const std::array<Probe, 3>& corners, const Triangle& a, const Triangle& b) {
  Vector origin, normal;
  double bound = 0;
  if (!planeBetween(a, b, origin, normal)) return std::numeric_limits<double>::infinity();
  std::array<double, 3> side;
  for (size_t k = 0; k < 3; ++k) {
    side[k] = dot(corners[k].position - origin, normal);
    bound = std::max(bound, distance(corners[k].position, side[k] < 0 ? a : b));
  }
  for (size_t k = 0; k < 3; ++k) {
    const size_t next = (k + 1) % 3;
    if ((side[k] < 0) == (side[next] < 0)) continue;
    const double t = side[k] / (side[k] - side[next]);
    const Vector cut = lerp(corners[k].position, corners[next].position, t);
    bound = std::max({bound, distance(cut, a), distance(cut, b)});
  }
  return bound;
}

// Upper bound of the distance over the triangle of three probes; the search ends when it is below
// `enough`.
double boundOf(const std::array<Probe, 3>& corners, const TriangleTree& to, double enough) {
  double farthest = 0, longest = 0;
  for (size_t k = 0; k < 3; ++k) {
    farthest = std::max(farthest, corners[k].distance);
    longest = std::max(longest, length(corners[(k + 1) % 3].position - corners[k].position));
  }
  // No point is farther from the nearest corner than the circumradius of an equilateral triangle.
  double bound = farthest + longest / std::sqrt(3.0);
  std::array<Triangle, 3> nearest;
  for (size_t k = 0; k < 3 && bound > enough; ++k) {
    nearest[k] = to.corners(corners[k].nearest);
    bound = std::min(bound, boundFrom(corners, nearest[k]));
  }
  for (size_t k = 0; k < 3 && bound > enough; ++k)
    if (const size_t next = (k + 1) % 3; corners[k].nearest != corners[next].nearest)
      bound = std::min(bound, boundFromTwo(corners, nearest[k], nearest[next]));
  return bound;
}

}  // namespace

DistanceBounds maxDistance(std::span<const Float3> positions, std::span<const uint32_t> indices,
                           const TriangleTree& to, double tolerance, double stopAbove,
                           double known) {
  DistanceBounds bounds = {known, known};
  uint64_t searches = 0;
  const auto probe = [&](const Vector& at, uint32_t hint) {
    ++searches;
    const SurfacePoint point = to.closest(at, hint);
    const Probe result = {at, std::sqrt(point.squaredDistance), point.triangle};
    bounds.lower = std::max(bounds.lower, result.distance);
    return result;
  };
  std::vector<Probe> probes(positions.size());
  std::vector<bool> probed(positions.size());
  uint32_t hint = to.closest({}).triangle;
  for (const uint32_t v : indices) {
    if (probed[v]) continue;
    probed[v] = true;
    probes[v] = probe({positions[v].x, positions[v].y, positions[v].z}, hint);
    hint = probes[v].nearest;
  }
  const uint64_t limit = searches + kMaxSearches;
  std::vector<std::array<Probe, 3>> stack;
  for (size_t i = 0; i < indices.size(); i += 3) {
    stack.push_back({probes[indices[i]], probes[indices[i + 1]], probes[indices[i + 2]]});
    while (!stack.empty()) {
      if (bounds.lower > stopAbove) {
        bounds.upper = std::max(bounds.upper, bounds.lower);
        return bounds;
      }
      const std::array<Probe, 3> corners = stack.back();
      stack.pop_back();
      const double bound = boundOf(corners, to, bounds.lower + tolerance);
      if (bound <= bounds.lower + tolerance || searches >= limit) {
        bounds.upper = std::max(bounds.upper, bound);
        continue;
      }
      std::array<Probe, 3> middles;  // of the edges that leave the corners
      for (size_t k = 0; k < 3; ++k)
        middles[k] =
            probe((corners[k].position + corners[(k + 1) % 3].position) * 0.5, corners[k].nearest);
      stack.push_back(middles);
      for (size_t k = 0; k < 3; ++k)
        stack.push_back({corners[k], middles[k], middles[(k + 2) % 3]});
    }
  }
  bounds.upper = std::max(bounds.upper, bounds.lower);
  return bounds;
}

}  // namespace pelage::detail
