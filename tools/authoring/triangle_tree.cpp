#include "triangle_tree.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "pelage/assert.h"
#include "points.h"

namespace pelage::detail {
namespace {

constexpr uint32_t kTrianglesPerLeaf = 4;
// More than the depth of a balanced tree over 2^32 triangles.
constexpr size_t kStackSize = 80;
// The distance to a box and that to a point in it are rounded differently; a box is left out only
// when it is farther by more than that.
constexpr double kSlack = 1 + 1e-12;

bool isBefore(const Vector& a, const Vector& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

double component(const Vector& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

double squaredDistanceToBox(const Vector& p, const Vector& low, const Vector& high) {
  const auto outside = [](double x, double a, double b) { return std::max({a - x, 0.0, x - b}); };
  const Vector d = {outside(p.x, low.x, high.x), outside(p.y, low.y, high.y),
                    outside(p.z, low.z, high.z)};
  return dot(d, d);
}

void offer(SurfacePoint& best, const Vector& point, const Vector& candidate,
           const std::array<double, 3>& barycentric) {
  const Vector d = candidate - point;
  const double square = dot(d, d);
  if (square < best.squaredDistance) best = {0, barycentric, candidate, square};
}

}  // namespace

SurfacePoint closestPoint(const Vector& point, const std::array<Vector, 3>& triangle) {
  // In an order that only their places decide, neighbors do the same arithmetic on what they
  // share.
  std::array<size_t, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](size_t i, size_t j) { return isBefore(triangle[i], triangle[j]); });
  const Vector corners[3] = {triangle[order[0]], triangle[order[1]], triangle[order[2]]};

  SurfacePoint best;
  best.squaredDistance = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < 3; ++k) {
    const size_t i = k == 2 ? 1 : 0, j = k == 0 ? 1 : 2;
    const Vector edge = corners[j] - corners[i];
    const double square = dot(edge, edge);
    const double along = square > 0 ? dot(point - corners[i], edge) / square : 0;
    const double t = along > 0 ? std::min(along, 1.0) : 0.0;
    std::array<double, 3> barycentric{};
    barycentric[i] = 1 - t;
    barycentric[j] = t;
    offer(best, point, t == 1 ? corners[j] : corners[i] + edge * t, barycentric);
  }
  // The foot of the perpendicular, where it is inside: barycentric coordinates as ratios of areas.
  const Vector u = corners[1] - corners[0], v = corners[2] - corners[0];
  const Vector normal = cross(u, v), toPoint = point - corners[0];
  const double area = dot(normal, normal);
  if (area > 0) {
    const double b = dot(cross(toPoint, v), normal) / area;
    const double c = dot(cross(u, toPoint), normal) / area;
    if (b >= 0 && c >= 0 && b + c <= 1)
      offer(best, point, corners[0] + u * b + v * c, {1 - b - c, b, c});
  }
  std::array<double, 3> barycentric{};
  for (size_t k = 0; k < 3; ++k) barycentric[order[k]] = best.barycentric[k];
  best.barycentric = barycentric;
  return best;
}

TriangleTree::TriangleTree(std::span<const Float3> positions, std::span<const uint32_t> indices,
                           std::vector<uint32_t> used)
    : positions_(positions), indices_(indices), used_(std::move(used)) {
  PELAGE_ASSERT(!used_.empty(), "a tree of no triangles has no closest point");
  std::vector<Vector> centers(indices_.size() / 3);  // times 3
  for (const uint32_t triangle : used_) {
    const std::array<Vector, 3> c = corners(triangle);
    centers[triangle] = c[0] + c[1] + c[2];
  }
  nodes_.reserve(used_.size());
  build(0, static_cast<uint32_t>(used_.size()), centers);
}

std::array<Vector, 3> TriangleTree::corners(uint32_t triangle) const {
  std::array<Vector, 3> result;
  for (size_t k = 0; k < 3; ++k)
    result[k] = vectorOf(positions_[indices_[size_t{triangle} * 3 + k]]);
  return result;
}

void TriangleTree::build(uint32_t first, uint32_t count, const std::vector<Vector>& centers) {
  const auto begin = used_.begin() + first, end = begin + count;
  const size_t at = nodes_.size();
  Node node;
  node.low = node.high = corners(*begin)[0];
  Vector low = centers[*begin], high = low;
  const auto extend = [](Vector& least, Vector& most, const Vector& p) {
    least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
  };
  for (auto t = begin; t != end; ++t) {
    for (const Vector& corner : corners(*t)) extend(node.low, node.high, corner);
    extend(low, high, centers[*t]);
  }
  nodes_.push_back(node);
  if (count <= kTrianglesPerLeaf) {
    nodes_[at].first = first;
    nodes_[at].count = count;
    return;
  }
  const Vector size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const uint32_t half = count / 2;
  std::nth_element(begin, begin + half, end, [&](uint32_t a, uint32_t b) {
    return std::pair(component(centers[a], axis), a) < std::pair(component(centers[b], axis), b);
  });
  build(first, half, centers);
  nodes_[at].first = static_cast<uint32_t>(nodes_.size());
  build(first + half, count - half, centers);
}

SurfacePoint TriangleTree::closest(const Vector& point, uint32_t hint) const {
  SurfacePoint best = closestPoint(point, corners(hint));
  best.triangle = hint;
  struct Entry {
    uint32_t node;
    double squaredDistance;
  };
  std::array<Entry, kStackSize> stack;
  size_t depth = 0;
  stack[depth++] = {0, squaredDistanceToBox(point, nodes_[0].low, nodes_[0].high)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.squaredDistance > best.squaredDistance * kSlack) continue;
    const Node& node = nodes_[entry.node];
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      SurfacePoint found = closestPoint(point, corners(used_[i]));
      found.triangle = used_[i];
      if (std::pair(found.squaredDistance, found.triangle) <
          std::pair(best.squaredDistance, best.triangle))
        best = found;
    }
    if (node.count > 0) continue;
    const auto child = [&](uint32_t index) {
      return Entry{index, squaredDistanceToBox(point, nodes_[index].low, nodes_[index].high)};
    };
    Entry near = child(entry.node + 1), far = child(node.first);
    if (far.squaredDistance < near.squaredDistance) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return best;
}

}  // namespace pelage::detail
