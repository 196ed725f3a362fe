// Fixtures of the stress tests of mesh colliders: a block, the hair that lies on it, and what is
// always true of both.
#pragma once

#include <Eigen/Geometry>

#include "pelage/sdf_collider.h"
#include "pelage/skeleton.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "stress/stress_run.h"
#include "support/collision_shapes.h"
#include "support/plain_asset.h"
#include "support/sdf_error.h"

namespace pelage::test {

using reference::DistanceOracle;
using reference::TriangleMesh;

inline constexpr int kGoodFrames = 9, kBadFrames = 5, kRecoveryFrames = 60;
inline constexpr float kCell = 0.01f;  // [m]
// From one collider with its hair to the next: whole metres, so that all have the same bits.
inline constexpr float kSpacing = 3;

/// Horizontal strands that lie across the top of a block at the origin, held beside it. Where they
/// are drawn to is 3 mm deep in it, so that there is one place alone where they come to rest.
inline HairAsset comb(float scale = 1) {
  return strandsAt(4, 16, [&](uint32_t s, uint32_t v) {
    return Float3{scale * (-0.12f + 0.018f * static_cast<float>(v)), scale * 0.08f,
                  scale * 0.016f * (static_cast<float>(s) - 1.5f)};
  });
}

inline TriangleMesh block() {
  return reference::box({-0.093f, -0.08f, -0.083f}, {0.093f, 0.0717f, 0.083f});
}

inline AffineTransform boneAt(const Float3& point, const Float3& scale = {1, 1, 1}) {
  AffineTransform bone;
  bone.rows[0] = {scale.x, 0, 0, point.x};
  bone.rows[1] = {0, scale.y, 0, point.y};
  bone.rows[2] = {0, 0, scale.z, point.z};
  return bone;
}

inline Float3 plus(const Float3& a, const Float3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

/// Up to 0.7 cells a frame, within the room that a grid has; then it stands still. In steps of
/// 2^-12 m, which every place has exactly.
inline Float3 displacementAt(int frame) {
  const float t = 0.448799f * static_cast<float>(std::min(frame, kGoodFrames + kBadFrames));
  const auto exact = [](float x) { return std::round(x * 4096) / 4096; };
  return {0, exact(-1.4f * kCell * std::sin(t)), exact(0.8f * kCell * std::sin(2 * t))};
}

inline TriangleMesh posed(TriangleMesh mesh, const AffineTransform& bone) {
  for (Float3& p : mesh.positions) p = transformPoint(bone, p);
  return mesh;
}

/// A collider, the hair over it, and where both are.
struct Location {
  std::string name;
  TriangleMesh mesh;
  Float3 at = {};
  HairId hair = HairId::kInvalid;
  ColliderId collider = ColliderId::kInvalid;
};

class SdfStress : public StressTest {
 protected:
  SdfStress() { makeHairReturnSoon(); }
  using StressTest::add;
  using StressTest::remove;
  ColliderId add(const TriangleMesh& mesh, const SdfColliderDef& def) {
    return run_.add(toMesh(mesh), def);
  }
  void remove(ColliderId id) { run_.remove(id); }
  HairObject& hairOf(const Location& point) { return run_.scene.hair(point.hair); }
  SdfCollider& colliderOf(const Location& point) { return run_.scene.collider(point.collider); }
  void setBones(const Location& point, const Float3& displacement,
                const Float3& scale = {1, 1, 1}) {
    setBone(colliderOf(point), boneAt(plus(point.at, displacement), scale));
  }
  /// Hair with a comb's shape, at the place.
  void addHair(Location& point, const HairAsset& asset, const SimulationSettings& settings) {
    point.hair = add(asset, {.name = point.name, .settings = settings});
    setBone(hairOf(point), boneAt(point.at));
  }

  /// Finite, with its lengths but for the rounding of world space, and counters that can be.
  void expectSane(const HairAsset& asset, const Location& point, const std::string& when) {
    const std::vector<Float4> positions = run_.positions(hairOf(point));
    ASSERT_TRUE(allFinite(positions)) << point.name << ", " << when;
    ASSERT_TRUE(allFinite(run_.read(hairOf(point).buffers().tangents))) << point.name;
    double size = 0;
    for (const Float4& p : positions)
      keepLargest(size, toVector(p).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    for (size_t i = 0; i + 1 < positions.size(); ++i) {
      const double rest = static_cast<double>(asset.restLengths[i]);
      if (!(rest > 0) || (i + 1) % asset.verticesPerStrand == 0) continue;
      const double off = std::abs(distance(positions[i], positions[i + 1]) - rest);
      const double stretch = std::max(off - 2.4e-7 * size, 0.0) / rest;
      keepLargest(worstStretch_, stretch);
      ASSERT_LT(stretch, 1e-3) << point.name << ", " << when << ", vertex " << i;
    }
    if (point.collider == ColliderId::kInvalid) return;
    const SdfCollider& collider = colliderOf(point);
    const SdfGrid& grid = collider.grid();
    const uint64_t nodes = uint64_t{grid.nodes[0]} * grid.nodes[1] * grid.nodes[2];
    uint64_t bricks = 1;
    for (const uint32_t n : grid.nodes) bricks *= (n + 3) / 4;
    const std::vector<uint32_t> work = run_.read<uint32_t>(collider.buffers().work);
    const SdfCounters counters = readSdfCounters(std::as_bytes(std::span(work)));
    ASSERT_LE(counters.bigTriangles, point.mesh.triangleCount()) << point.name << ", " << when;
    ASSERT_LE(counters.interiorNodes, nodes) << point.name << ", " << when;
    ASSERT_LE(counters.movedVertices, point.mesh.positions.size()) << point.name << ", " << when;
    ASSERT_LE(counters.movedTriangles, point.mesh.triangleCount()) << point.name << ", " << when;
    ASSERT_LE(counters.clearedBricks, bricks) << point.name << ", " << when;
  }
  /// How deep the deepest free vertex is in a mesh [m].
  double depth(const Location& point, const TriangleMesh& mesh) {
    const DistanceOracle oracle(mesh);
    double deepest = 0;
    for (const Float4& p : run_.positions(hairOf(point)))
      if (p.w > 0) keepLargest(deepest, -oracle.signedDistance(toVector(p)));
    return deepest;
  }
  std::vector<SdfData> copySdfs(const std::vector<Location>& points) {
    std::vector<SdfData> all;
    for (const Location& point : points) all.push_back(run_.copySdf(point.collider));
    return all;
  }

  double worstStretch_ = 0;
};

}  // namespace pelage::test
