// Vertices near a surface are listed, and what becomes of them is the same as without a list.
#include "sdf_collision.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <set>

#include "kernel/sdf_run.h"
#include "pelage/random.h"

namespace pelage::test {
namespace {

using Bits = std::vector<uint32_t>;

Bits bitsOf(const std::vector<Float4>& values) {
  Bits bits;
  for (const Float4& v : values)
    for (const float f : {v.x, v.y, v.z, v.w}) bits.push_back(std::bit_cast<uint32_t>(f));
  return bits;
}

struct Vertices {
  std::vector<Float4> now, before;
};

/// Fields of a blob that moves along x, and the buffers of a collision with them.
class NearRun {
 public:
  NearRun(Gpu& gpu, Vertices start, float cell, float margin)
      : gpu_(gpu),
        start_(std::move(start)),
        mesh_(reference::blob(24, 36)),
        run_(gpu, mesh_, {.cellSize = cell, .motion = true}),
        positions_(gpu, "sdfPositions", start_.now),
        before_(gpu, "sdfPositionsBefore", start_.before) {
    run_.build();
    std::vector<Float3> moved = mesh_.positions;
    for (Float3& p : moved) p.x += 0.3f * cell;
    run_.move(moved);
    run_.build();
    const detail::SdfGridPlan& plan = run_.def.plan;
    SdfField field = {};
    field.origin = {plan.origin.x, plan.origin.y, plan.origin.z, plan.cellSize};
    field.nodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2], 0};
    field.triangleCount = run_.def.triangleCount;
    field.triangleBits = plan.triangleBits;
    field.surfaceStride = 7;
    field.band = plan.band;
    field.farRange = plan.farRange;
    field.margin = margin;
    field.friction = 0.4f;
    field.motionScale = 1;
    SdfField second = field;  // beside the first one, and at rest
    second.origin.y += 0.7f;
    second.motionScale = 0;
    fields_ = std::make_unique<GuardedBuffer<SdfField>>(gpu, "sdfFields",
                                                        std::vector<SdfField>{field, second});
    list_ = gpu.resources.add({.name = "nearList",
                               .size = detail::sdfNearBytes(count()),
                               .stride = 4,
                               .usage = BufferUsage::kStorage | BufferUsage::kIndirect |
                                        BufferUsage::kUpload | BufferUsage::kReadback});
    expectOk(gpu.device()->update(gpu.resources));
  }
  ~NearRun() {
    gpu_.hazards.forget(list_);
    gpu_.resources.remove(list_);
  }

  uint32_t count() const { return static_cast<uint32_t>(start_.now.size()); }

  Vertices collide(detail::SdfCollisionDef def) {
    PassList passes;
    positions_.upload(passes, start_.now);
    before_.upload(passes, start_.before);
    def.vertexCount = count();
    def.fieldCount = 2;
    expectOk(detail::addSdfCollision(
        passes, gpu_.resources,
        {positions_.id(), before_.id(), fields_->id(), run_.keys->id(), run_.surface->id(), list_},
        def));
    gpu_.hazards.resolve(passes);
    expectOk(gpu_.device()->execute(passes));
    return {positions_.read(), before_.read()};
  }

  std::vector<uint32_t> listed() const {
    const auto raw = gpu_.device()->read(list_);
    EXPECT_TRUE(raw.ok());
    std::vector<uint32_t> words(raw->size() / 4);
    std::memcpy(words.data(), raw->data(), raw->size());
    EXPECT_EQ(words[0], (words[3] + 63) / 64) << "groups of the dispatch";
    return {words.begin() + 4, words.begin() + 4 + std::min(words[3], count())};
  }

 private:
  Gpu& gpu_;
  Vertices start_;
  TriangleMesh mesh_;
  SdfRun run_;
  GuardedBuffer<Float4> positions_, before_;
  std::unique_ptr<GuardedBuffer<SdfField>> fields_;
  BufferId list_ = BufferId::kInvalid;
};

Vector3d within(Random& random, double size) {
  const auto coordinate = [&] { return size * (2 * random.uniformDouble() - 1); };
  const double x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

/// In and around the blobs; most at rest, some fast, some held, some broken.
Vertices mixed(float cell) {
  Vertices vertices;
  Random random(7);
  for (uint32_t i = 0; i < 5000; ++i) {
    const Vector3d p = within(random, 1.6);
    const Vector3d q = p + within(random, (i % 16 == 0 ? 4 : 0.4) * static_cast<double>(cell));
    const auto float4 = [](const Vector3d& v, float w) {
      return Float4{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
                    w};
    };
    vertices.now.push_back(float4(p, i % 32 == 5 ? 0.0f : 1.0f));
    vertices.before.push_back(float4(q, 0));
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  vertices.now[70].y = nan;
  vertices.before[80].x = std::numeric_limits<float>::infinity();
  vertices.now[90] = {1e30f, 0, 0, 1};
  return vertices;
}

class SdfNear : public GpuTest {};

TEST_P(SdfNear, AListOfThoseThatAreNearChangesNoBit) {
  const float cell = 0.06f;
  const Vertices start = mixed(cell);
  // Friction, walk. Where compiling them takes seconds, one will do.
  std::vector<std::pair<bool, bool>> responses = {{true, true}};
  if (GetParam() == Api::kVulkan) responses.push_back({false, false});
  for (const float margin : {0.0f, 0.02f}) {
    NearRun run(gpu(), start, cell, margin);
    for (const float end : {1.0f, 0.5f}) {
      for (const auto& [friction, walk] : responses) {
        detail::SdfCollisionDef def = {
            .begin = end - 0.5f, .end = end, .friction = friction, .walk = walk};
        const Vertices listed = run.collide(def);
        def.onlyNear = false;
        const Vertices all = run.collide(def);
        EXPECT_NE(bitsOf(all.now), bitsOf(start.now)) << "some are inside";
        EXPECT_EQ(bitsOf(listed.now), bitsOf(all.now)) << end << friction << walk;
        EXPECT_EQ(bitsOf(listed.before), bitsOf(all.before)) << end << friction << walk;
      }
    }
  }
}

TEST_P(SdfNear, AVertexIsListedOnceWhenItMayMoveAndMostOthersAreNot) {
  const float cell = 0.06f;
  const Vertices start = mixed(cell);
  NearRun run(gpu(), start, cell, 0);
  const Vertices after = run.collide({});
  const std::vector<uint32_t> listed = run.listed();
  const std::set<uint32_t> once(listed.begin(), listed.end());
  EXPECT_EQ(once.size(), listed.size());
  size_t moved = 0;
  for (uint32_t i = 0; i < run.count(); ++i) {
    if (bitsOf({after.now[i]}) == bitsOf({start.now[i]})) continue;
    ++moved;
    EXPECT_TRUE(once.contains(i)) << i;
  }
  EXPECT_GT(moved, 200u);
  EXPECT_LT(listed.size(), run.count() * 2 / 3);
}

TEST_P(SdfNear, NothingIsDispatchedWhereNothingIsNear) {
  Vertices far;
  for (uint32_t i = 0; i < 200; ++i)
    far.now.push_back({9 + 0.01f * static_cast<float>(i), 0, 0, 1});
  far.before = far.now;
  NearRun run(gpu(), far, 0.06f, 0.01f);
  const Vertices after = run.collide({});
  EXPECT_TRUE(run.listed().empty());
  EXPECT_EQ(after.now, far.now);
}

INSTANTIATE_TEST_SUITE_P(Apis, SdfNear, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
