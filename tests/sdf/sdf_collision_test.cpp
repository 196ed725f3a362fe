// collide_vertices against the distance oracle, on fields that the host made node by node.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <vector>

#include "pelage/collision_mesh.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "reference/sdf/sdf_builder.h"
#include "sdf/collision_run.h"
#include "sdf/sdf_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

using reference::DistanceOracle;
using reference::FieldOptions;
using reference::SdfBuffers;
using reference::TriangleMesh;

/// A mesh, its oracle and its field.
struct Body {
  Body(TriangleMesh mesh_, const FieldOptions& options)
      : mesh(std::move(mesh_)), oracle(mesh), cell(options.cell) {
    reference::addSdf(buffers, mesh, oracle, options);
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t)
      areas.push_back((t > 0 ? areas[t - 1] : 0) +
                      (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm());
  }
  /// [cell]
  double distance(const Float4& p) const { return oracle.signedDistance(toVector(p)) / cell; }
  /// Out of the surface, at a point that is not on it.
  Vector3d normal(const Float4& p) const {
    const Vector3d x = toVector(p);
    const Vector3d out = x - oracle.closest(x).point;
    return (oracle.isInside(x) ? -out : out).normalized();
  }
  Vector3d corner(uint32_t triangle, size_t k) const {
    const Float3& v = mesh.positions[mesh.indices[3 * triangle + k]];
    return {v.x, v.y, v.z};
  }
  Vector3d randomPoint(uint32_t triangle, Random& random) const {
    double a = random.unit(), b = random.unit();
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    return corner(triangle, 0) * (1 - a - b) + corner(triangle, 1) * a + corner(triangle, 2) * b;
  }
  /// A triangle, large ones more often.
  uint32_t randomTriangle(Random& random) const {
    const double site = random.unit() * areas.back();
    const auto found = std::upper_bound(areas.begin(), areas.end(), site);
    return static_cast<uint32_t>(std::min(found, areas.end() - 1) - areas.begin());
  }
  /// How many triangles a segment crosses.
  int crossings(const Vector3d& a, const Vector3d& b) const {
    int count = 0;
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      const Vector3d e1 = corner(t, 1) - corner(t, 0), e2 = corner(t, 2) - corner(t, 0);
      const Vector3d p = (b - a).cross(e2);
      const double det = e1.dot(p);
      if (det == 0) continue;
      const Vector3d from = a - corner(t, 0);
      const double u = from.dot(p) / det;
      if (u < 0 || u > 1) continue;
      const Vector3d q = from.cross(e1);
      const double v = (b - a).dot(q) / det, w = e2.dot(q) / det;
      if (v >= 0 && u + v <= 1 && w >= 0 && w <= 1) ++count;
    }
    return count;
  }

  TriangleMesh mesh;
  DistanceOracle oracle;
  SdfBuffers buffers;
  std::vector<double> areas;  ///< of the triangles up to here
  double cell;
};

class CollisionRun {
 public:
  CollisionRun(Gpu& gpu, const SdfBuffers& sdf, const Vertices& vertices)
      : count_(static_cast<uint32_t>(vertices.size())),
        sdfCount_(static_cast<uint32_t>(sdf.sdfs.size())),
        vertices_(gpu, vertices),
        fields_(gpu, "sdfs", sdf.sdfs),
        keys_(gpu, "sdfKeys", sdf.keys),
        surface_(gpu, "sdfSurface", sdf.surface) {
    expectOk(gpu.device()->update(gpu.resources));
  }

  float begin = 0, end = 1;  ///< shares of the frame

  Vertices collide(bool closestFeature = true) {
    return vertices_.collide(fields_.id(), keys_.id(), surface_.id(),
                             {.vertexCount = count_,
                              .contactSdfCount = sdfCount_,
                              .begin = begin,
                              .end = end,
                              .closestFeature = closestFeature});
  }
  void set(const Vertices& vertices) { vertices_.set(vertices); }

 private:
  uint32_t count_, sdfCount_;
  VertexBuffers vertices_;
  GuardedBuffer<Sdf> fields_;
  GuardedBuffer<uint32_t> keys_;
  GuardedBuffer<Uint4> surface_;
};

double median(std::vector<double> values, double share = 0.5) {
  for (const double value : values)
    if (std::isnan(value)) return value;
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(static_cast<double>(values.size() - 1) * share)];
}

/// The rat's body, or nothing when it is not there.
TriangleMesh bodyMesh() {
  const Result<CollisionMesh> loaded =
      loadTfxMesh(std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy" / "Ratboy_body.tfxmesh");
  if (!loaded) return {};
  return {loaded->positions, loaded->indices};
}

const Body& blobBody() {
  static const Body body(reference::blob(48, 96), {.cell = 0.04});
  return body;
}

const Body* ratBody() {
  static const std::unique_ptr<Body> body = [] {
    TriangleMesh mesh = bodyMesh();
    if (mesh.indices.empty()) return std::unique_ptr<Body>();
    float low = 1e9f, high = -1e9f;
    for (const Float3& p : mesh.positions) {
      keepSmallest(low, p.x);
      keepLargest(high, p.x);
    }
    return std::make_unique<Body>(std::move(mesh), FieldOptions{.cell = double{high - low} / 50});
  }();
  return body.get();
}

std::vector<const Body*> smoothBodies() {
  std::vector<const Body*> bodies = {&blobBody()};
  if (ratBody() != nullptr) bodies.push_back(ratBody());
  return bodies;
}

/// Vertices at rest within `range` cells of the surface.
Vertices verticesNear(const Body& body, size_t count, double range, uint64_t seed) {
  Vertices vertices;
  Random random(seed);
  while (vertices.size() < count) {
    const auto t = body.randomTriangle(random);
    const Vector3d p = body.randomPoint(t, random) + random.vector(range * body.cell);
    vertices.add(p, p);
  }
  return vertices;
}

/// How many vertices were deeper than a limit, and how many of these are out afterwards [cell].
struct Resolved {
  size_t deep = 0, out = 0;
  Resolved(const Body& body, const Vertices& before, const Vertices& after, double deeper,
           double left) {
    for (size_t i = 0; i < before.size(); ++i) {
      if (body.distance(before.now[i]) >= -deeper) continue;
      ++deep;
      if (body.distance(after.now[i]) > -left) ++out;
    }
  }
  double share() const { return static_cast<double>(out) / static_cast<double>(deep); }
};

class SdfCollision : public GpuTest {};
/// On the first API: SdfCollisionBits compares the others with it, and these take seconds.
class SdfCollisionOnce : public GpuTest {};

TEST_P(SdfCollisionOnce, PutsVerticesOutsideInOneStep) {
  for (const Body* body : smoothBodies()) {
    // From just below the surface to the middle.
    Vertices vertices = verticesNear(*body, 6000, 3, 1);
    Random random(2);
    for (int i = 0; i < 2000; ++i) {
      const auto t = body->randomTriangle(random);
      const Vector3d p = body->randomPoint(t, random) * random.unit();
      vertices.add(p, p);
    }
    CollisionRun run(gpu(), body->buffers, vertices);
    const Vertices after = run.collide();
    for (size_t i = 0; i < vertices.size(); ++i)
      if (body->distance(vertices.now[i]) >= 0.01) {
        EXPECT_EQ(after.now[i], vertices.now[i]);
      }
    const Resolved resolved(*body, vertices, after, 0.05, 0.02);
    EXPECT_GT(resolved.deep, 3000u);
    EXPECT_GE(resolved.share(), 0.999);
    std::printf("[ FIGURE ] resolved %zu of %zu\n", resolved.out, resolved.deep);
  }
}

/// The field that the kernels build.
/// \param threeAxes  the mesh is open or overlaps
SdfBuffers builtSdf(Gpu& gpu, const Body& body, bool threeAxes) {
  SdfRun run(gpu, body.mesh, {.cellSize = static_cast<float>(body.cell), .threeAxes = threeAxes});
  run.build();
  return {{run.sdf()}, run.keys->read(), run.surface->read()};
}

// Nodes deep inside know no triangle but for the coarse ones: the way out that a vertex finds from
// these leads to the surface, and is hardly longer than the shortest one.
TEST_P(SdfCollisionOnce, DeepVerticesGoOutByNearlyTheShortestWay) {
  for (const Body* body : smoothBodies()) {
    const Sdf& grid = body->buffers.sdfs[0];
    Vertices vertices;
    std::vector<double> depths;
    Random random(12);
    const auto within = [&](float low, uint32_t nodes) {
      return static_cast<double>(low) + random.unit() * (nodes - 1) * body->cell;
    };
    while (vertices.size() < 3000) {
      const double x = within(grid.origin.x, grid.nodes.x), y = within(grid.origin.y, grid.nodes.y);
      const Vector3d p = {x, y, within(grid.origin.z, grid.nodes.z)};
      if (!body->oracle.isInside(p)) continue;
      vertices.add(p, p);
      const double depth = -body->distance(vertices.now.back());
      if (depth > 2) {
        depths.push_back(depth);
      } else {
        vertices.now.pop_back();
        vertices.before.pop_back();
      }
    }
    const Body all(body->mesh, {.cell = body->cell, .allInside = true});
    const std::pair<const char*, SdfBuffers> sdfs[] = {{"built", builtSdf(gpu(), *body, false)},
                                                       {"host's", body->buffers},
                                                       {"an older file's", all.buffers}};
    for (const auto& [name, sdf] : sdfs) {
      CollisionRun run(gpu(), sdf, vertices);
      const Vertices after = run.collide();
      std::vector<double> longer;
      double sum = 0;
      for (size_t i = 0; i < vertices.size(); ++i) {
        EXPECT_NEAR(body->distance(after.now[i]), 0, 0.02) << name << ", " << depths[i];
        const Vector3d displacement = toVector(after.now[i]) - toVector(vertices.now[i]);
        longer.push_back(displacement.norm() / body->cell - depths[i]);
        sum += longer.back();
      }
      const double mean = sum / static_cast<double>(longer.size());
      EXPECT_LE(mean, 0.01) << name << " [cell]";
      EXPECT_LE(median(longer, 0.99), 0.3) << name << " [cell]";
      EXPECT_LE(median(longer, 1), 2) << name << " [cell]";
      std::printf(
          "[ FIGURE ] %s field, deeper than 2 cells, longer than the shortest way: "
          "mean %.4f, 99 %% %.3f, max %.2f cells\n",
          name, mean, median(longer, 0.99), median(longer, 1));
    }
  }
}

// The margin makes the direction in which a vertex goes visible on both sides.
TEST_P(SdfCollision, MovesAlongTheNormalOfTheNearestFeature) {
  for (const Body* body : smoothBodies()) {
    SdfBuffers sdf = body->buffers;
    sdf.sdfs[0].margin = static_cast<float>(1.1 * body->cell);
    const Vertices vertices = verticesNear(*body, 5000, 1, 3);
    CollisionRun run(gpu(), sdf, vertices);
    const Vertices after = run.collide();
    std::vector<double> angles, gaps;
    for (size_t i = 0; i < vertices.size(); ++i) {
      const double before = body->distance(vertices.now[i]);
      if (std::abs(before) > 1 || std::abs(before) < 0.02) continue;
      const Vector3d displacement = toVector(after.now[i]) - toVector(vertices.now[i]);
      angles.push_back(
          std::acos(
              std::clamp(displacement.normalized().dot(body->normal(vertices.now[i])), -1.0, 1.0)) *
          180 / std::numbers::pi);
      gaps.push_back(std::abs(displacement.norm() / body->cell + before - 1.1));
    }
    EXPECT_GT(angles.size(), 3000u);
    EXPECT_LE(median(angles), 0.01);
    EXPECT_LE(median(angles, 0.95), 0.1);
    EXPECT_LE(median(gaps, 0.99), 1e-3) << "[cell] distance to the surface";
    std::printf("[ FIGURE ] normals: median %.5f, 95 %% %.5f, 99 %% %.4f, max %.2f degrees\n",
                median(angles), median(angles, 0.95), median(angles, 0.99), median(angles, 1));
  }
}

TEST_P(SdfCollision, TheTrilinearMethodIsNearTheSurfaceAfterThreeSteps) {
  const Body& body = blobBody();
  const Vertices vertices = verticesNear(body, 3000, 2, 4);
  CollisionRun run(gpu(), body.buffers, vertices);
  Vertices after;
  for (int step = 0; step < 3; ++step) after = run.collide(false);
  const Resolved resolved(body, vertices, after, 0.1, 0.1);
  EXPECT_GT(resolved.deep, 1000u);
  EXPECT_GE(resolved.share(), 0.95);
}

// The two sides of a plate are in the keys of the same nodes.
TEST_P(SdfCollision, VerticesBesideAThinPlateStayOnTheirSide) {
  const double cell = 1.0 / 60, half = 0.15 * cell;
  for (const float angle : {0.0f, 0.1f, 0.7f}) {
    const Body body(reference::rotated(reference::box({-0.35f, static_cast<float>(-half), -0.35f},
                                                      {0.35f, static_cast<float>(half), 0.35f}),
                                       {0, 0, 1}, angle),
                    {.cell = cell, .margin = static_cast<float>(0.25 * cell)});
    const double rotation = static_cast<double>(angle);
    const Vector3d up(-std::sin(rotation), std::cos(rotation), 0), along(up.y(), -up.x(), 0);
    Vertices vertices;
    Random random(13);
    while (vertices.size() < 2000) {
      const double height = random.between(0.16, 0.4) * cell * (vertices.size() % 2 == 0 ? 1 : -1);
      const Vector3d p = up * height + along * random.between(-0.3, 0.3) +
                         Vector3d(0, 0, random.between(-0.3, 0.3));
      vertices.add(p, p);
    }
    CollisionRun run(gpu(), body.buffers, vertices);
    const Vertices after = run.collide();
    for (size_t i = 0; i < vertices.size(); ++i) {
      const double side = toVector(vertices.now[i]).dot(up) > 0 ? 1 : -1;
      EXPECT_GE(side * toVector(after.now[i]).dot(up), half + 0.24 * cell) << angle;
    }
  }
}

/// Share of vertices on the wrong side after a step of `length` cells into the surface.
double wrongSide(Gpu& gpu, const Body& body, double length, uint64_t seed) {
  Vertices vertices;
  Random random(seed);
  while (vertices.size() < 200) {
    const auto t = body.randomTriangle(random);
    const Vector3d x = body.randomPoint(t, random);
    const Vector3d normal = (body.corner(t, 1) - body.corner(t, 0))
                                .cross(body.corner(t, 2) - body.corner(t, 0))
                                .normalized();
    const Vector3d direction = (random.vector(0.4) - normal).normalized();
    const double above = random.between(0.5, 2) * body.cell / std::max(0.3, -direction.dot(normal));
    const Vector3d from = x - direction * above, to = from + direction * (length * body.cell);
    if (body.oracle.isInside(from) || body.crossings(from, x + normal * (1e-3 * body.cell)) > 0 ||
        body.crossings(from, to) == 0)
      continue;
    vertices.add(from, to);
  }
  CollisionRun run(gpu, body.buffers, vertices);
  const Vertices after = run.collide();
  size_t wrong = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    EXPECT_TRUE(isFinite(after.now[i]));
    const Vector3d start = toVector(vertices.before[i]), end = toVector(after.now[i]);
    const bool inside = body.distance(after.now[i]) < -0.1;
    if (inside || (!body.oracle.isInside(end) && body.crossings(start, end) >= 2)) ++wrong;
  }
  return static_cast<double>(wrong) / static_cast<double>(vertices.size());
}

TEST_P(SdfCollisionOnce, FastVerticesStayOnTheirSide) {  // K30
  std::vector<const Body*> bodies = smoothBodies();
  const double cell = 1.0 / 60;
  const Body thick(reference::plate(1, static_cast<float>(1.2 * cell), 6, 0.35f), {.cell = cell});
  bodies.push_back(&thick);
  for (const Body* body : bodies) {
    for (const double length : {1.0, 2.0, 4.0, 8.0, 16.0}) {
      const double wrong = wrongSide(gpu(), *body, length, 5);
      EXPECT_LE(wrong, 0.01) << "steps of " << length << " cells";
      std::printf("[ FIGURE ] %u triangles, %g cells: %.2f %% wrong\n", body->mesh.triangleCount(),
                  length, 100 * wrong);
    }
  }
}

/// Lets a vertex slide from rest on a slab that is inclined by `degrees` [m].
double slideOnSlope(Gpu& gpu, double degrees, float friction, int steps) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vector3d down(std::cos(angle), -std::sin(angle), 0),
      up(std::sin(angle), std::cos(angle), 0);
  TriangleMesh slab = reference::rotated(reference::box({-0.7f, -0.1f, -0.1f}, {0.7f, 0, 0.1f}),
                                         {0, 0, 1}, static_cast<float>(-angle));
  const double cell = 0.02, margin = 0.25 * cell;
  const Body body(slab, {.cell = cell, .margin = static_cast<float>(margin), .friction = friction});
  Vertices vertices;
  const Vector3d start = -0.5 * down + margin * up;
  vertices.add(start, start);
  CollisionRun run(gpu, body.buffers, vertices);
  for (int step = 0; step < steps; ++step) {
    const Vector3d now = toVector(vertices.now[0]);
    const Vector3d next = 2 * now - toVector(vertices.before[0]) + Vector3d(0, -9.81 / 3600, 0);
    vertices = {};
    vertices.add(now, next);
    run.set(vertices);
    vertices = run.collide();
  }
  const Vector3d displacement = toVector(vertices.now[0]) - start;
  EXPECT_LT(std::abs(displacement.dot(up)), 1e-4) << "off the slope";
  return displacement.dot(down);
}

TEST_P(SdfCollision, HoldsOnASlopeThatFrictionHolds) {
  EXPECT_LT(std::abs(slideOnSlope(gpu(), 10, 0.3f, 300)), 1e-4);
}

TEST_P(SdfCollision, SlidesDownASteeperSlopeAsCoulombSays) {
  for (const float friction : {0.0f, 0.3f}) {
    const double angle = 25 * std::numbers::pi / 180;
    const double acceleration =
        9.81 * (std::sin(angle) - static_cast<double>(friction) * std::cos(angle));
    const int steps = 40;
    const double expected = acceleration / 3600 * steps * (steps + 1) / 2;
    EXPECT_NEAR(slideOnSlope(gpu(), 25, friction, steps), expected, 2e-3 * expected) << friction;
  }
}

/// A slab that went by `way` in the frame, and a vertex that lies on it where the slab is at share
/// `end` of the frame, 2 mm deep after a step of a fourth of the frame in which it did not move.
TEST_P(SdfCollision, IsTakenAlongByASurfaceThatMoves) {
  const double cell = 0.02;
  const TriangleMesh slab = reference::box({-0.3f, -0.1f, -0.3f}, {0.3f, 0, 0.3f});
  for (const Vector3d& displacement : {Vector3d(0.03, 0, 0), Vector3d(0.01, 0.03, 0.02)}) {
    const std::vector<Float3> before = reference::moved(slab, toFloat3(-displacement)).positions;
    const Body body(slab, {.cell = cell, .friction = 1e6f, .before = &before});
    for (const double end : {0.25, 0.5, 1.0}) {
      const double begin = end - 0.25;
      const Vector3d top = displacement * (end - 1);
      const Vector3d site = top + Vector3d(0.02, -0.002, 0.01);
      Vertices vertices;
      vertices.add(site, site);
      CollisionRun run(gpu(), body.buffers, vertices);
      run.begin = static_cast<float>(begin);
      run.end = static_cast<float>(end);
      const Vertices after = run.collide();
      // On the surface as it is then, and along with it.
      const Vector3d expected(site.x() + 0.25 * displacement.x(), top.y(),
                              site.z() + 0.25 * displacement.z());
      EXPECT_LT((toVector(after.now[0]) - expected).norm(), 1e-5) << end;
      const Vector3d velocity = toVector(after.now[0]) - toVector(after.before[0]);
      EXPECT_NEAR(velocity.y(), 0.25 * displacement.y(), 1e-5) << "rises as the surface does";
    }
  }
}

TEST_P(SdfCollision, AStepIsLongOrShortAgainstTheSurfaceAndNotAgainstTheWorld) {
  // A plate of 0.8 cells goes by 6 cells in the frame. One vertex goes along, just above it; one
  // stays where it was and is overtaken.
  const double cell = 0.02;
  const TriangleMesh slab =
      reference::box({-0.3f, static_cast<float>(-0.8 * cell), -0.3f}, {0.3f, 0, 0.3f});
  const Vector3d displacement(0, 6 * cell, 0);
  const std::vector<Float3> before = reference::moved(slab, toFloat3(-displacement)).positions;
  const Body body(slab, {.cell = cell, .before = &before});
  Vertices vertices;
  const Vector3d above(0.01, 0.3 * cell, 0.02);
  vertices.add(above - displacement, above);
  vertices.add(Vector3d(0, -5 * cell, 0), Vector3d(0, -1.5 * cell, 0));
  CollisionRun run(gpu(), body.buffers, vertices);
  const Vertices after = run.collide();
  EXPECT_EQ(after.now[0], vertices.now[0]);
  EXPECT_EQ(after.before[0], vertices.before[0]);
  EXPECT_GT(after.now[1].y, -1e-3 * cell) << "it was above the plate before";
}

TEST_P(SdfCollision, VerticesThatAreHeldOrNotFiniteKeepTheirBits) {
  const Body& body = blobBody();
  Vertices vertices;
  vertices.add(Vector3d(0.01, 0.02, 0.03), Vector3d(0.01, 0.02, 0.03), 0);  // a root
  vertices.add(Vector3d(0.01, 0.02, 0.03), Vector3d(0.01, 0.02, 0.03), -1);
  for (const float bad : {kNan, kInf, 1e30f}) {
    vertices.add(Vector3d(0.01, 0.02, 0.03), Vector3d(0.01, 0.02, 0.03));
    vertices.now.back().y = bad;
    vertices.add(Vector3d(0.01, 0.02, 0.03), Vector3d(0.01, 0.02, 0.03));
    vertices.now.back().w = bad == kInf ? kNan : bad;
  }
  vertices.add(Vector3d(50, 0, 0), Vector3d(50, 1, 0));  // beyond the grid
  // The end of this one is sound.
  vertices.add(Vector3d(0.1, 0, 0), Vector3d(0.1, 0, 0));
  vertices.before.back().x = kNan;
  CollisionRun run(gpu(), body.buffers, vertices);
  const Vertices after = run.collide();
  const auto bits = [](const Float4& v) {
    std::array<uint32_t, 4> b;
    std::memcpy(b.data(), &v, sizeof(v));
    return b;
  };
  for (size_t i = 0; i + 1 < vertices.size(); ++i) {
    EXPECT_EQ(bits(after.now[i]), bits(vertices.now[i])) << i;
    EXPECT_EQ(bits(after.before[i]), bits(vertices.before[i])) << i;
  }
  EXPECT_TRUE(isFinite(after.now.back()) && isFinite(after.before.back()));
  EXPECT_GT(body.distance(after.now.back()), -0.02);
}

TEST_P(SdfCollision, AFieldOfNothingTouchesNothing) {
  const Body& body = blobBody();
  SdfBuffers unset = body.buffers;
  std::fill(unset.keys.begin(), unset.keys.end(), 0x7fffffffu);
  SdfBuffers broken = body.buffers;
  broken.sdfs[0].origin.w = 0;
  SdfBuffers flat = body.buffers;
  flat.sdfs[0].nodes.y = 1;
  SdfBuffers nowhere = body.buffers;
  nowhere.sdfs[0].origin.x = kNan;
  // Keys name triangles that the field does not have.
  SdfBuffers strange = body.buffers;
  strange.sdfs[0].triangleCount = 0;
  Vertices vertices = verticesNear(body, 300, 2, 6);
  vertices.add(Vector3d(-2, 0, 0), Vector3d(2, 0.1, 0));
  for (const SdfBuffers& sdf : {unset, broken, flat, nowhere, strange}) {
    CollisionRun run(gpu(), sdf, vertices);
    const Vertices after = run.collide();
    EXPECT_EQ(after.now, vertices.now);
    EXPECT_EQ(after.before, vertices.before);
  }
}

TEST_P(SdfCollision, EveryFieldIsMetWhereverItLiesInTheBuffers) {
  SdfBuffers buffers;
  const double cell = 0.02;
  std::vector<TriangleMesh> meshes;
  for (const float x : {-0.5f, 0.0f, 0.5f})
    meshes.push_back(reference::sphere(0.15f, 12, 24, {x, 0, 0}));
  for (const TriangleMesh& mesh : meshes)
    reference::addSdf(buffers, mesh, DistanceOracle(mesh), {.cell = cell});
  Vertices vertices;
  for (const double x : {-0.5, 0.0, 0.5})
    vertices.add(Vector3d(x + 0.01, 0.1, 0), Vector3d(x + 0.01, 0.1, 0));
  CollisionRun run(gpu(), buffers, vertices);
  const Vertices after = run.collide();
  for (size_t i = 0; i < 3; ++i) {
    const double distance = DistanceOracle(meshes[i]).signedDistance(toVector(after.now[i]));
    EXPECT_NEAR(distance / cell, 0, 1e-3);
  }
}

// Overlaps have sheets inside, holes have borders: what is inside by winding number goes out. Keys
// of the kernels know which sheets are a way out; those of the host are of the nearest triangle.
TEST_P(SdfCollisionOnce, OpenAndOverlappingMeshesPutOutWhatIsInside) {
  struct Case {
    Body body;
    double leastOfHost, least;
  };
  const Case cases[] = {
      {Body(reference::overlappingSpheres(0.3f, 0.3f, 24, 48), {.cell = 0.02}), 0.93, 0.99},
      {Body(reference::sphereWithHoles(0.3f, 24, 48, 40), {.cell = 0.02}), 0.97, 0.995}};
  for (const Case& c : cases) {
    const Vertices vertices = verticesNear(c.body, 4000, 2, 8);
    for (const bool built : {false, true}) {
      CollisionRun run(gpu(), built ? builtSdf(gpu(), c.body, true) : c.body.buffers, vertices);
      Vertices after;
      for (int step = 0; step < 3; ++step) {
        after = run.collide();
        EXPECT_TRUE(allFinite(after.now));
        const Resolved resolved(c.body, vertices, after, 0.05, 0.02);
        const double share = resolved.share();
        std::printf("[ FIGURE ] %s field, step %d: resolved %.2f %% of %zu\n",
                    built ? "built" : "host's", step + 1, 100 * share, resolved.deep);
        if (step == 2) {
          EXPECT_GE(share, built ? c.least : c.leastOfHost);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, SdfCollision, testing::ValuesIn(kApis), apiTestName);
INSTANTIATE_TEST_SUITE_P(Apis, SdfCollisionOnce, testing::Values(kFirstApi), apiTestName);

TEST(SdfCollisionBits, AreTheSameOnEveryApi) {
  const Body& body = blobBody();
  SdfBuffers sdf = body.buffers;
  sdf.sdfs[0].friction = 0.4f;
  sdf.sdfs[0].margin = static_cast<float>(0.3 * body.cell);
  Vertices vertices = verticesNear(body, 3000, 3, 9);
  Random random(10);
  for (size_t i = 0; i < vertices.size(); i += 2) {
    const Vector3d p = toVector(vertices.now[i]) + random.vector(6 * body.cell);
    vertices.before[i] = toFloat4(p);
  }
  for (const bool closestFeature : {false, true}) {
    Vertices first;
    for (Gpu* gpu : startedGpus()) {
      CollisionRun run(*gpu, sdf, vertices);
      const Vertices after = run.collide(closestFeature);
      if (first.size() == 0) {
        first = after;
        EXPECT_NE(after.now, vertices.now);
      }
      EXPECT_TRUE(after.now == first.now) << apiName(gpu->api());
      EXPECT_TRUE(after.before == first.before) << apiName(gpu->api());
    }
    if (first.size() == 0) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  }
}

}  // namespace
}  // namespace pelage::test
