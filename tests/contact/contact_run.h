// Strands against capsules and meshes in a scene, and what is measured of them.
#pragma once

#include <cmath>
#include <vector>

#include "support/collision_shapes.h"
#include "support/plain_asset.h"
#include "support/strand_measures.h"

namespace pelage::test {

constexpr double kGravity = 9.81;

struct Point {
  double x = 0, y = 0, z = 0;
};
inline Point toPoint(const Float4& p) { return {p.x, p.y, p.z}; }
inline double distance(const Point& a, const Point& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// One strand.
inline HairAsset strandAsset(const std::vector<Point>& points) {
  return strandsAt(1, static_cast<uint32_t>(points.size()), [&](uint32_t, uint32_t v) {
    const Point& p = points[v];
    return Float3{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  });
}

/// Strands of 0.3 m along a direction, beside each other along z.
inline HairAsset combAsset(uint32_t strands, uint32_t vertices,
                           const Vector3d& direction = {1, 0, 0}) {
  return strandsAt(strands, vertices, [&](uint32_t s, uint32_t v) {
    return toFloat3(Vector3d(0, 0, 0.01 * s) + direction * (0.3 * v / (vertices - 1)));
  });
}

/// A vertex at the origin that hangs 500 m to the side: its strand holds it there and nowhere else.
inline HairAsset vertexOnALongStrand() {
  return strandsAt(1, 3, [](uint32_t, uint32_t v) {
    return Float3{0, 0, 1000 - 500 * static_cast<float>(v)};
  });
}

inline std::vector<Point> straight(int count, const Point& from, const Point& to) {
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / (count - 1);
    points.push_back(
        {from.x + (to.x - from.x) * t, from.y + (to.y - from.y) * t, from.z + (to.z - from.z) * t});
  }
  return points;
}

/// A capsule along z.
inline CapsuleCollider cylinder(float radius, float friction) {
  return {.head = {0, 0, -0.3f},
          .headRadius = radius,
          .tail = {0, 0, 0.3f},
          .tailRadius = radius,
          .friction = friction};
}

/// A closed cylinder along z with so many sides.
inline CollisionMesh cylinderMesh(double radius, double half, int sides) {
  CollisionMesh mesh;
  const auto add = [&](double x, double y, double z) {
    mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    mesh.normals.push_back({0, 1, 0});
  };
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * 3.14159265358979 * i / sides;
    for (const double z : {-half, half}) add(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  add(0, 0, -half);
  add(0, 0, half);
  const auto n = static_cast<uint32_t>(2 * sides);
  for (uint32_t i = 0; i < n; i += 2) {
    const uint32_t next = (i + 2) % n;
    for (const uint32_t index : {i, next, i + 1, i + 1, next, next + 1})
      mesh.indices.push_back(index);
    for (const uint32_t index : {n, next, i, n + 1, i + 1, next + 1}) mesh.indices.push_back(index);
  }
  return mesh;
}

/// A closed box around the origin, its top in the plane y = 0.
inline CollisionMesh slabMesh(float halfWidth, float depth) {
  return toMesh(reference::box({-halfWidth, -depth, -halfWidth}, {halfWidth, 0, halfWidth}));
}

/// The motion of a vertex in the last frames. A NaN makes every figure a NaN or infinite.
struct Watch {
  std::vector<Float4> now, before;
  double seconds = 0;

  void take(std::vector<Float4> positions, double frame) {
    before.swap(now);
    now = std::move(positions);
    seconds = frame;
  }
  double fastest() const {
    double worst = 0;
    for (size_t i = 0; i < now.size() && i < before.size(); ++i) {
      const double speed = distance(toPoint(now[i]), toPoint(before[i])) / seconds;
      if (!(speed <= worst)) worst = std::isfinite(speed) ? speed : HUGE_VAL;
    }
    return worst;
  }
  double height() const {
    double sum = 0;
    for (const Float4& p : now) sum += p.y;
    return sum / static_cast<double>(now.size());
  }
};

/// How deep vertices behind the first two are in a capsule along z around the origin [m].
inline double depthInCylinder(const std::vector<Float4>& positions, uint32_t verticesPerStrand,
                              double radius) {
  double worst = -HUGE_VAL;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (i % verticesPerStrand < 2) continue;
    const double depth = radius - std::hypot(double{positions[i].x}, double{positions[i].y});
    if (!(depth <= worst)) worst = std::isfinite(depth) ? depth : HUGE_VAL;
  }
  return worst;
}

}  // namespace pelage::test
