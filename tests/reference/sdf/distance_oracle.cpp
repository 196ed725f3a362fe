#include "reference/sdf/distance_oracle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace pelage::reference {
namespace {

constexpr uint32_t kLeafSize = 4;
// A group is far when it is this many of its radii away.
constexpr double kFarRadii = 2.5;
// Bound of the dipoles' error, with a margin; the test of the oracle measures it.
constexpr double kFastError = 0.2;

double squaredDistanceToBox(const Vector3d& p, const Vector3d& low, const Vector3d& high) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

// Solid angle of a triangle from p over 4 pi [van Oosterom and Strackee 1983].
double solidAngleShare(const Vector3d& p, const Vector3d& v0, const Vector3d& v1,
                       const Vector3d& v2) {
  const Vector3d a = v0 - p, b = v1 - p, c = v2 - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(numerator, denominator) / (2 * std::numbers::pi);
}

// The closest point of a segment; 0 or 1 where it is an end.
double segmentParameter(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d edge = b - a;
  const double square = edge.squaredNorm();
  return square > 0 ? std::clamp((p - a).dot(edge) / square, 0.0, 1.0) : 0;
}

// Every directed edge has its opposite equally often; vertices are those of equal position.
bool edgesBalance(std::span<const Float3> positions, std::span<const uint32_t> indices,
                  const std::vector<uint32_t>& used) {
  using Location = std::tuple<float, float, float>;
  std::map<Location, uint32_t> sites;
  const auto site = [&](uint32_t vertex) {
    const Float3& p = positions[vertex];
    return sites.emplace(Location(p.x, p.y, p.z), static_cast<uint32_t>(sites.size()))
        .first->second;
  };
  std::vector<std::pair<std::pair<uint32_t, uint32_t>, int>> edges;
  for (const uint32_t t : used)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = site(indices[t * 3 + k]), b = site(indices[t * 3 + (k + 1) % 3]);
      edges.push_back({std::minmax(a, b), a < b ? 1 : -1});
    }
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0; i < edges.size();) {
    int sum = 0;
    size_t k = i;
    for (; k < edges.size() && edges[k].first == edges[i].first; ++k) sum += edges[k].second;
    if (sum != 0) return false;
    i = k;
  }
  return true;
}

}  // namespace

ClosestPoint closestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                               const Vector3d& c) {
  // Inside the prism over the triangle the foot on the plane is the closest point, else it is on
  // one of the edges: no case analysis that could take the wrong branch at a sliver.
  const std::array<const Vector3d*, 3> v = {&a, &b, &c};
  const Vector3d normal = (b - a).cross(c - a);
  bool overFace = normal.squaredNorm() > 0;
  for (size_t k = 0; k < 3 && overFace; ++k)
    overFace = (*v[(k + 1) % 3] - *v[k]).cross(p - *v[k]).dot(normal) >= 0;
  if (overFace) {
    const double height = (p - a).dot(normal) / normal.norm();
    return {std::abs(height), p - normal.normalized() * height, 0, TriangleFeature::kFace};
  }
  ClosestPoint best{std::numeric_limits<double>::infinity(), p, 0, TriangleFeature::kFace};
  for (size_t k = 0; k < 3; ++k) {
    const Vector3d &from = *v[k], &to = *v[(k + 1) % 3];
    const double t = segmentParameter(p, from, to);
    const Vector3d point = t == 1 ? to : Vector3d(from + (to - from) * t);
    const double distance = (p - point).norm();
    if (!(distance < best.distance)) continue;
    const auto vertex = static_cast<int>(t == 1 ? (k + 1) % 3 : k);
    const int feature = t == 0 || t == 1
                            ? static_cast<int>(TriangleFeature::kVertex0) + vertex
                            : static_cast<int>(TriangleFeature::kEdge01) + static_cast<int>(k);
    best = {distance, point, 0, static_cast<TriangleFeature>(feature)};
  }
  return best;
}

DistanceOracle::DistanceOracle(std::span<const Float3> positions,
                               std::span<const uint32_t> indices) {
  std::vector<uint32_t> used;
  for (uint32_t t = 0; t < indices.size() / 3; ++t) {
    const Triangle triangle = {toDouble(positions[indices[t * 3]]),
                               toDouble(positions[indices[t * 3 + 1]]),
                               toDouble(positions[indices[t * 3 + 2]]), t};
    const double area = (triangle.b - triangle.a).cross(triangle.c - triangle.a).squaredNorm();
    if (!(area > 0 && std::isfinite(area))) continue;
    used.push_back(t);
    triangles_.push_back(triangle);
  }
  if (triangles_.empty()) return;
  closed_ = edgesBalance(positions, indices, used);
  nodes_.reserve(triangles_.size());
  addNode(0, static_cast<uint32_t>(triangles_.size()));
}

uint32_t DistanceOracle::addNode(uint32_t begin, uint32_t end) {
  const auto self = static_cast<uint32_t>(nodes_.size());
  Node node;
  node.low.setConstant(std::numeric_limits<double>::infinity());
  node.high = -node.low;
  node.dipole.setZero();
  node.centre.setZero();
  node.begin = begin;
  node.end = end;
  node.second = 0;
  Vector3d low = node.low, high = node.high;  // of the middles
  double areaSum = 0;
  for (uint32_t i = begin; i < end; ++i) {
    const Triangle& t = triangles_[i];
    node.low = node.low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    node.high = node.high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    const Vector3d normal = (t.b - t.a).cross(t.c - t.a) / 2, middle = (t.a + t.b + t.c) / 3;
    node.dipole += normal;
    node.centre += middle * normal.norm();
    areaSum += normal.norm();
    low = low.cwiseMin(middle);
    high = high.cwiseMax(middle);
  }
  node.centre /= areaSum;
  node.radius = 0;
  for (uint32_t i = begin; i < end; ++i)
    for (const Vector3d* v : {&triangles_[i].a, &triangles_[i].b, &triangles_[i].c})
      node.radius = std::max(node.radius, (*v - node.centre).norm());
  nodes_.push_back(node);
  if (end - begin <= kLeafSize) return self;

  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](uint32_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](const Triangle& s, const Triangle& t) {
    const double ms = s.a[axis] + s.b[axis] + s.c[axis], mt = t.a[axis] + t.b[axis] + t.c[axis];
    return ms != mt ? ms < mt : s.index < t.index;
  });
  addNode(begin, middle);
  const uint32_t second = addNode(middle, end);
  nodes_[self].second = second;
  return self;
}

ClosestPoint DistanceOracle::closest(const Vector3d& p, double range) const {
  ClosestPoint best{std::numeric_limits<double>::infinity(), p, 0, TriangleFeature::kFace};
  if (nodes_.empty()) return best;
  double limit = range;
  std::array<std::pair<double, uint32_t>, 128> stack;
  size_t depth = 0;
  stack[depth++] = {squaredDistanceToBox(p, nodes_[0].low, nodes_[0].high), 0};
  while (depth > 0) {
    const auto [boxDistance, index] = stack[--depth];
    if (boxDistance > limit * limit) continue;
    const Node& node = nodes_[index];
    if (node.second != 0) {
      std::pair<double, uint32_t> near = {0, index + 1}, far = {0, node.second};
      for (auto* child : {&near, &far})
        child->first =
            squaredDistanceToBox(p, nodes_[child->second].low, nodes_[child->second].high);
      if (far.first < near.first) std::swap(near, far);
      stack[depth++] = far;
      stack[depth++] = near;
      continue;
    }
    for (uint32_t i = node.begin; i < node.end; ++i) {
      const Triangle& t = triangles_[i];
      ClosestPoint found = closestOnTriangle(p, t.a, t.b, t.c);
      found.triangle = t.index;
      if (found.distance > limit ||
          (found.distance == best.distance && found.triangle > best.triangle))
        continue;
      best = found;
      limit = found.distance;
    }
  }
  return best;
}

double DistanceOracle::windingNumber(const Vector3d& p) const {
  double sum = 0;
  for (const Triangle& t : triangles_) sum += solidAngleShare(p, t.a, t.b, t.c);
  return sum;
}

double DistanceOracle::fastWindingNumber(const Vector3d& p) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  std::array<uint32_t, 128> stack;
  size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const Vector3d offset = node.centre - p;
    const double square = offset.squaredNorm(), far = kFarRadii * node.radius;
    if (square > far * far) {
      sum += offset.dot(node.dipole) / (4 * std::numbers::pi * square * std::sqrt(square));
    } else if (node.second != 0) {
      stack[depth++] = node.second;
      stack[depth++] = index + 1;
    } else {
      for (uint32_t i = node.begin; i < node.end; ++i) {
        const Triangle& t = triangles_[i];
        sum += solidAngleShare(p, t.a, t.b, t.c);
      }
    }
  }
  return sum;
}

bool DistanceOracle::isInside(const Vector3d& p) const {
  const double fast = fastWindingNumber(p);
  if (std::abs(fast - 0.5) > kFastError) return fast > 0.5;
  return windingNumber(p) > 0.5;
}

double DistanceOracle::signedDistance(const Vector3d& p) const {
  const double distance = closest(p).distance;
  return isInside(p) ? -distance : distance;
}

// `lastDistance` is signed. Where the surface is closed, the whole ball up to it is on one side.
double DistanceOracle::distanceAndSide(const Vector3d& p, double range, const Vector3d* last,
                                       double lastDistance) const {
  double limit = range;
  bool known = false;
  if (last != nullptr) {
    const double step = (p - *last).norm();
    known = closed_ && step < std::abs(lastDistance);
    // A little more, so that rounding does not lose the triangle that is there.
    if (std::abs(lastDistance) < range)
      limit = std::min(limit, (std::abs(lastDistance) + step) * (1 + 1e-9));
  }
  const double distance = std::min(closest(p, limit).distance, range);
  const bool inside = known ? lastDistance < 0 : isInside(p);
  return inside ? -distance : distance;
}

std::vector<double> DistanceOracle::signedDistances(std::span<const Vector3d> points,
                                                    double range) const {
  std::vector<double> distances(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    distances[i] = distanceAndSide(points[i], range, i > 0 ? &points[i - 1] : nullptr,
                                   i > 0 ? distances[i - 1] : 0);
  return distances;
}

std::vector<double> DistanceOracle::gridDistances(const Vector3d& origin, double cell,
                                                  const uint32_t (&nodes)[3], double range) const {
  std::vector<Vector3d> points;
  points.reserve(size_t{nodes[0]} * nodes[1] * nodes[2]);
  for (uint32_t z = 0; z < nodes[2]; ++z)
    for (uint32_t y = 0; y < nodes[1]; ++y)
      for (uint32_t x = 0; x < nodes[0]; ++x) points.push_back(origin + cell * Vector3d(x, y, z));
  return signedDistances(points, range);
}

}  // namespace pelage::reference
