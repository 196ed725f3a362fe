// A vertex near a surface that moves does not depend on the vertices beside it.
#include <gtest/gtest.h>

#include <bit>
#include <numeric>
#include <utility>

#include "pelage/random.h"
#include "sdf/collision_run.h"
#include "sdf/sdf_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

using Bits = std::vector<uint32_t>;

Bits bitsOf(const std::vector<Float4>& values) {
  Bits bits;
  for (const Float4& v : values)
    for (const float f : {v.x, v.y, v.z, v.w}) bits.push_back(std::bit_cast<uint32_t>(f));
  return bits;
}

/// Fields of a blob that moves along x, and the buffers of a collision with them.
class VerticesRun {
 public:
  VerticesRun(Gpu& gpu, Vertices start, float cell, float margin)
      : start_(std::move(start)),
        mesh_(reference::blob(24, 36)),
        run_(gpu, mesh_, {.cellSize = cell, .motion = true}),
        oracle_(shifted(mesh_, 0.3f * cell)),
        vertices_(gpu, start_) {
    run_.build();
    run_.move(shifted(mesh_, 0.3f * cell).positions);
    run_.build();
    Sdf sdf = run_.sdf();
    sdf.margin = margin;
    sdf.friction = 0.4f;
    sdf.motionScale = 1;
    Sdf second = sdf;  // beside the first one, and at rest
    second.origin.y += 0.7f;
    second.motionScale = 0;
    fields_ = std::make_unique<GuardedBuffer<Sdf>>(gpu, "sdfs", std::vector<Sdf>{sdf, second});
    expectOk(gpu.device()->update(gpu.resources));
  }

  uint32_t count() const { return static_cast<uint32_t>(start_.now.size()); }

  /// Moves the vertices, in the order in which `order` names them.
  Vertices collide(const std::vector<uint32_t>& order, float begin, float end) {
    Vertices given = start_;
    for (uint32_t i = 0; i < count(); ++i) {
      given.now[i] = start_.now[order[i]];
      given.before[i] = start_.before[order[i]];
    }
    vertices_.set(given);
    const Vertices moved = vertices_.collide(
        fields_->id(), run_.keys->id(), run_.surface->id(),
        {.vertexCount = count(), .contactSdfCount = 2, .begin = begin, .end = end});
    Vertices after = start_;
    for (uint32_t i = 0; i < count(); ++i) {
      after.now[order[i]] = moved.now[i];
      after.before[order[i]] = moved.before[i];
    }
    return after;
  }

  /// To the surface of the field that moves, as it is at the frame's end [m], negative inside.
  double distance(const Float4& p) const { return oracle_.signedDistance({p.x, p.y, p.z}); }

 private:
  static TriangleMesh shifted(TriangleMesh mesh, float x) {
    for (Float3& p : mesh.positions) p.x += x;
    return mesh;
  }

  Vertices start_;
  TriangleMesh mesh_;
  SdfRun run_;
  DistanceOracle oracle_;
  VertexBuffers vertices_;
  std::unique_ptr<GuardedBuffer<Sdf>> fields_;
};

Vector3d within(pelage::Random& random, double size) {
  const auto coordinate = [&] { return size * (2 * random.uniformDouble() - 1); };
  const double x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

/// In and around the blobs; most at rest, some fast, some held, some broken.
Vertices mixed(float cell) {
  Vertices vertices;
  pelage::Random random(7);
  for (uint32_t i = 0; i < 5000; ++i) {
    const Vector3d p = within(random, 1.6);
    const Vector3d q = p + within(random, (i % 16 == 0 ? 4 : 0.4) * static_cast<double>(cell));
    vertices.add(q, p, i % 32 == 5 ? 0 : 1);
  }
  vertices.now[70].y = kNan;
  vertices.before[80].x = kInf;
  vertices.now[90] = {1e30f, 0, 0, 1};
  return vertices;
}

std::vector<uint32_t> inOrder(size_t count) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

class SdfVertices : public GpuTest {};

TEST_P(SdfVertices, DoNotDependOnThoseBesideThem) {
  const float cell = 0.06f;
  const Vertices start = mixed(cell);
  const std::vector<uint32_t> order = inOrder(start.now.size());
  std::vector<uint32_t> other = order;
  pelage::Random random(11);
  for (size_t i = other.size(); i > 1; --i)
    std::swap(other[i - 1], other[random.below(static_cast<uint32_t>(i))]);
  for (const float margin : {0.0f, 0.02f}) {
    VerticesRun run(gpu(), start, cell, margin);
    for (const float end : {1.0f, 0.5f}) {
      const Vertices first = run.collide(order, end - 0.5f, end);
      const Vertices second = run.collide(other, end - 0.5f, end);
      EXPECT_NE(bitsOf(first.now), bitsOf(start.now)) << "some are inside";
      EXPECT_EQ(bitsOf(first.now), bitsOf(second.now)) << end;
      EXPECT_EQ(bitsOf(first.before), bitsOf(second.before)) << end;
    }
  }
}

TEST_P(SdfVertices, MoveWhenASurfaceIsNearerThanTheMargin) {
  const float cell = 0.06f, margin = 0.02f;
  const Vertices start = mixed(cell);
  VerticesRun run(gpu(), start, cell, margin);
  for (const float end : {1.0f, 0.5f}) {
    const Vertices after = run.collide(inOrder(start.now.size()), end - 0.5f, end);
    size_t moved = 0, touched = 0;
    for (uint32_t i = 0; i < run.count(); ++i) {
      const bool stays = bitsOf({after.now[i]}) == bitsOf({start.now[i]});
      if (!stays) ++moved;
      const Float4& p = start.now[i];
      if (!(p.w > 0) || !std::isfinite(p.y) || std::abs(p.x) > 10) continue;
      // At half of the frame the surface has half of its way before it.
      const Float4 there = {p.x + (1 - end) * 0.3f * cell, p.y, p.z, p.w};
      if (run.distance(there) > static_cast<double>(margin) - 1e-3) continue;
      ++touched;
      EXPECT_FALSE(stays) << i << ", " << run.distance(there);
    }
    EXPECT_GT(touched, 150u);
    EXPECT_LT(moved, start.now.size() * 2 / 3) << "most others keep their bits";
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, SdfVertices, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
