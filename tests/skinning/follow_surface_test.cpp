// Roots on a mesh that an engine deforms on the GPU, against rootTransforms() of the host.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pelage/skeleton.h"
#include "pelage/skin_table.h"
#include "stress/stress_run.h"
#include "support/engine_buffer.h"
#include "support/not_numbers.h"
#include "support/plain_asset.h"

namespace pelage::test {
namespace {

constexpr uint32_t kSide = 9;  // vertices along an edge of a part

/// A part of a skin: a square with bumps.
std::vector<Float3> partAt(float height, double bump) {
  std::vector<Float3> vertices;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const double x = 0.05 * (i % kSide), z = 0.05 * static_cast<double>(i / kSide);
    vertices.push_back({static_cast<float>(x - 0.2),
                        static_cast<float>(height + bump * std::sin(20 * x) * std::cos(17 * z)),
                        static_cast<float>(z - 0.2)});
  }
  return vertices;
}

/// Roots all over two parts, of which a third one has none.
SkinTable tableOf(const std::vector<std::vector<Float3>>& bind, uint32_t roots) {
  SkinTable table;
  table.parts.resize(bind.size() + 1);
  for (SkinPart& part : table.parts) {
    part.vertexCount = kSide * kSide;
    part.triangleCount = 2 * (kSide - 1) * (kSide - 1);
  }
  Random random(7);
  for (uint32_t i = 0; i < roots; ++i) {
    SurfaceRoot root;
    root.part = i % 3 == 0 ? 1 : 0;
    const auto cellX = static_cast<uint32_t>(random.between(0, kSide - 1.001));
    const auto cellZ = static_cast<uint32_t>(random.between(0, kSide - 1.001));
    const uint32_t first = cellX + kSide * cellZ;
    const bool upper = i % 2 == 0;
    const uint32_t corners[3] = {first + (upper ? kSide + 1 : 0), first + (upper ? 1 : kSide),
                                 first + (upper ? kSide : 1)};
    std::copy(corners, corners + 3, root.corners);
    root.triangle = 2 * (cellX + (kSide - 1) * cellZ) + (upper ? 1 : 0);
    const auto y = static_cast<float>(random.between(0.1, 0.4));
    const auto z = static_cast<float>(random.between(0.1, 0.4));
    root.barycentric = {1 - y - z, y, z};
    root.offset = {0.001f * static_cast<float>(random.between(-1, 1)), 0.002f,
                   0.001f * static_cast<float>(random.between(-1, 1))};
    for (size_t k = 0; k < 3; ++k) root.bind[k] = bind[root.part][corners[k]];
    table.roots.push_back(root);
  }
  expectOk(validate(table));
  return table;
}

/// The skin after a deformation that also stretches, shears and turns it.
std::vector<Float3> deformed(const std::vector<Float3>& bind, int frame, const Vector3d& shift) {
  Eigen::Matrix3d map =
      Eigen::AngleAxisd(0.4 * frame, Vector3d(0.3, 1, -0.2).normalized()).toRotationMatrix();
  map *= Eigen::Matrix3d{{1.3, 0.2, 0}, {0, 0.8, 0.1 * std::sin(frame)}, {0.1, 0, 1.1}};
  std::vector<Float3> vertices;
  for (const Float3& p : bind) {
    Vector3d q(p.x, p.y, p.z);
    q.y() += 0.03 * std::sin(9 * q.x() + frame);
    q = map * q + shift;
    vertices.push_back(toFloat3(q));
  }
  return vertices;
}

/// Strands that stand on the roots.
HairAsset strandsOn(const SkinTable& table) {
  return strandsAt(static_cast<uint32_t>(table.roots.size()), 4, [&](uint32_t s, uint32_t v) {
    const Float3 p = bindPosition(table.roots[s]);
    return Float3{p.x, p.y + 0.02f * static_cast<float>(v), p.z};
  });
}

class FollowSurface : public SceneTest {
 protected:
  FollowSurface()
      : bind_{partAt(0, 0.01), partAt(0.3f, 0.02)},
        table_(tableOf(bind_, 150)),
        asset_(strandsOn(table_)),
        influences_(oneBoneAStrand(asset_.strandCount)),
        transforms_(asset_.strandCount) {}

  const HairObject& addHair(const char* name, const SkeletonDef& def, SkinningMethod method) {
    skeletons_.push_back(run_.add(def));
    return run_.add(asset_, {.name = name,
                             .skinning = method,
                             .influences = influences_,
                             .skeleton = skeletons_.back()});
  }
  static std::vector<float> floatsOf(const std::vector<Float3>& vertices, const VertexBuffer& at) {
    std::vector<float> floats(at.offset + at.stride * vertices.size(), kNan);
    for (size_t i = 0; i < vertices.size(); ++i) {
      const size_t first = at.offset + at.stride * i;
      floats[first] = vertices[i].x;
      floats[first + 1] = vertices[i].y;
      floats[first + 2] = vertices[i].z;
    }
    return floats;
  }
  /// The bones of the host, as its skeleton uploads them.
  void setHost(const std::vector<std::vector<Float3>>& parts) {
    const std::span<const Float3> vertices[] = {parts[0], parts[1], {}};
    expectOk(rootTransforms(table_, vertices, transforms_));
    run_.scene.skeleton(skeletons_[0]).setBones(transforms_);
  }

  std::vector<std::vector<Float3>> bind_;
  SkinTable table_;
  HairAsset asset_;
  std::vector<BoneInfluences> influences_;
  std::vector<AffineTransform> transforms_;
  std::vector<SkeletonId> skeletons_;
};

TEST_P(FollowSurface, RootsMoveAsOnTheHost) {
  for (const SkinningMethod method :
       {SkinningMethod::kMatrices, SkinningMethod::kDualQuaternions}) {
    const VertexBuffer places[2] = {{}, {.stride = 7, .offset = 2}};
    EngineBuffer first(run_, "first", floatsOf(bind_[0], places[0]).size());
    EngineBuffer second(run_, "second", floatsOf(bind_[1], places[1]).size());
    const HairObject& expected =
        addHair("expected", {.name = "host", .boneCount = asset_.strandCount}, method);
    const HairObject& hair = addHair(
        "hair",
        {.name = "skin", .source = BoneSource::kSurface, .surface = &table_, .deviation = 1},
        method);
    SkeletonPose& skin = run_.scene.skeleton(skeletons_[1]);
    EXPECT_EQ(skin.boneCount(), asset_.strandCount);
    for (int frame = 0; frame < 6; ++frame) {
      const Vector3d shift(0.4 * frame, 0.1, frame < 3 ? 0 : 6.25);
      const std::vector<std::vector<Float3>> parts = {deformed(bind_[0], frame, shift),
                                                      deformed(bind_[1], frame, shift)};
      setHost(parts);
      first.write(floatsOf(parts[0], places[0]));
      second.write(floatsOf(parts[1], places[1]));
      const VertexBuffer buffers[3] = {
          {.buffer = first.id()},
          {.buffer = second.id(), .stride = places[1].stride, .offset = places[1].offset},
          {}};
      AffineTransform placement;
      for (int row = 0; row < 3; ++row) placement.rows[row].w = static_cast<float>(shift[row]);
      skin.setVertices(buffers, placement);
      run_.step();
      EXPECT_EQ(countPasses(run_.list(), "follow_surface"), 2u) << "the parts with roots";
      const auto a = run_.positions(expected), b = run_.positions(hair);
      double off = 0;
      for (uint32_t s = 0; s < asset_.strandCount; ++s)
        for (uint32_t v = 0; v < 2; ++v)  // the others swing
          keepLargest(off, distance(a[size_t{s} * 4 + v], b[size_t{s} * 4 + v]));
      // Vertices are rounded by up to 5e-7 m that far away, and edges of 5 cm turn by that.
      EXPECT_LT(off, 3e-6) << "frame " << frame;
    }
    run_.step();
    EXPECT_EQ(countPasses(run_.list(), "follow_surface"), 0u) << "nothing has changed";
    run_.clear();
    skeletons_.clear();
  }
}

TEST_P(FollowSurface, RootsOnBrokenTrianglesStay) {
  EngineBuffer first(run_, "first", 3 * bind_[0].size()),
      second(run_, "second", 3 * bind_[1].size());
  const HairObject& expected = addHair(
      "expected", {.name = "host", .boneCount = asset_.strandCount}, SkinningMethod::kMatrices);
  const HairObject& hair =
      addHair("hair", {.name = "skin", .source = BoneSource::kSurface, .surface = &table_},
              SkinningMethod::kMatrices);
  const VertexBuffer buffers[3] = {{.buffer = first.id()}, {.buffer = second.id()}, {}};
  std::vector<Float4> before;
  for (int frame = 0; frame < 4; ++frame) {
    std::vector<std::vector<Float3>> parts = {deformed(bind_[0], frame, {0, 0, 0}),
                                              deformed(bind_[1], frame, {0, 0, 0})};
    if (frame >= 2) {
      // Triangles that are a point, a line, and none; and one side that is as it was.
      for (uint32_t i = 0; i < 2 * kSide; ++i) parts[0][i] = {1, 2, 3};
      for (uint32_t i = 3 * kSide; i < 5 * kSide; ++i)
        parts[0][i] = {0.25f * static_cast<float>(i), 0, 0};
      parts[0][6 * kSide + 4].y = kNan;
      parts[0][7 * kSide + 2].x = kInf;
    }
    setHost(parts);
    first.write(floatsOf(parts[0], {}));
    second.write(floatsOf(parts[1], {}));
    run_.scene.skeleton(skeletons_[1]).setVertices(buffers, {});
    run_.step();
    const auto a = run_.positions(expected), b = run_.positions(hair);
    ASSERT_TRUE(allFinite(b)) << "frame " << frame;
    double off = 0;
    size_t stayed = 0;
    for (uint32_t s = 0; s < asset_.strandCount; ++s) {
      const size_t root = size_t{s} * 4;
      keepLargest(off, distance(a[root], b[root]));
      keepLargest(off, distance(a[root + 1], b[root + 1]));
      if (frame == 2 && b[root] == before[root]) ++stayed;
    }
    EXPECT_LT(off, 1e-6) << "frame " << frame;
    if (frame == 2) {
      EXPECT_GT(stayed, 20u);
      EXPECT_LT(stayed, 100u);
    }
    before = b;
  }
}

// Twice the area of a triangle below 1e-6 of its longest edge's square is none.
TEST_P(FollowSurface, TrianglesThatAreTooThinMoveNoRoot) {
  EngineBuffer first(run_, "first", 3 * bind_[0].size()),
      second(run_, "second", 3 * bind_[1].size());
  addHair("host", {.name = "host", .boneCount = asset_.strandCount}, SkinningMethod::kMatrices);
  const HairObject& hair =
      addHair("hair", {.name = "skin", .source = BoneSource::kSurface, .surface = &table_},
              SkinningMethod::kMatrices);
  const VertexBuffer buffers[3] = {{.buffer = first.id()}, {.buffer = second.id()}, {}};
  setHost(bind_);
  std::vector<Float4> before;
  // The first part as thin as this, flat and turned.
  for (const float thin : {1.0f, 2e-8f, 4e-7f, 1e-4f}) {
    std::vector<Float3> part = bind_[0];
    for (Float3& p : part) p = thin < 1 ? Float3{-p.z, 0, thin * p.x} : p;
    first.write(floatsOf(part, {}));
    second.write(floatsOf(bind_[1], {}));
    run_.scene.skeleton(skeletons_[1]).setVertices(buffers, {});
    run_.step();
    const auto now = run_.positions(hair);
    ASSERT_TRUE(allFinite(now));
    for (size_t s = 0; thin < 1 && s < table_.roots.size(); ++s) {
      const bool stays = table_.roots[s].part == 1 || thin < 1e-6f;
      EXPECT_EQ(now[4 * s] == before[4 * s], stays) << "root " << s << ", " << thin;
    }
    before = now;
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, FollowSurface, testing::ValuesIn(kApis), apiTestName);

// ---- without a device

TEST(FollowSurfaceList, WhatIsWrongIsNamed) {
  const std::vector<std::vector<Float3>> bind = {partAt(0, 0.01), partAt(0.3f, 0.02)};
  const SkinTable table = tableOf(bind, 20);
  Scene scene;
  const auto expectNoSkeleton = [&](const SkeletonDef& def, const char* what) {
    expectError(scene.addSkeleton(def), what);
  };
  expectNoSkeleton({.surface = &table}, "SkeletonDef::surface is for BoneSource::kSurface");
  expectNoSkeleton({.boneCount = 19, .source = BoneSource::kSurface, .surface = &table},
                   "boneCount is 19, but the skin table has 20 roots");
  SkinTable broken = table;
  broken.roots[3].bind[1] = broken.roots[3].bind[0];
  expectNoSkeleton({.source = BoneSource::kSurface, .surface = &broken}, "root 3");
  EXPECT_EQ(scene.resources().count(), 0u);
  const Result<SkeletonId> id = required(
      scene.addSkeleton({.name = "skin", .source = BoneSource::kSurface, .surface = &table}));
  ASSERT_TRUE(scene.addHair(makeAsset(), {.skeleton = *id}));
  PassList list;
  const auto expectRefused = [&](const char* what) {
    expectError(scene.simulate(1.0f / 60, list), {"skeleton 'skin'", what});
  };
  expectRefused("has no vertices yet");
  const BufferId buffer =
      scene.resources().add({.name = "skin", .size = 3 * kSide * kSide * 4, .stride = 4});
  std::vector<VertexBuffer> parts = {{.buffer = buffer}, {}, {}};
  scene.skeleton(*id).setVertices(parts, {});
  expectRefused("vertices of part 1 does not exist");
  parts[1] = {.buffer = buffer, .stride = 2};
  scene.skeleton(*id).setVertices(parts, {});
  expectRefused("stride of its vertices of part 1 is 2");
  parts[1] = {.buffer = buffer, .stride = 8};
  scene.skeleton(*id).setVertices(parts, {});
  expectRefused("vertices of part 1 has 972 bytes");
  parts[1] = {.buffer = buffer};
  scene.skeleton(*id).setVertices(parts, {});
  EXPECT_TRUE(scene.simulate(1.0f / 60, list));
}

}  // namespace
}  // namespace pelage::test
