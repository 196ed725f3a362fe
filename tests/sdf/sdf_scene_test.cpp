// Mesh colliders of a scene: what is in the pass lists, without a GPU.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/scene.h"
#include "pelage/skeleton.h"
#include "support/collision_shapes.h"
#include "support/not_numbers.h"
#include "support/scene_list_test.h"
#include "support/scene_run.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;
using test::makeAsset;
using test::required;
using test::setBone;

constexpr float kFrame = 1.0f / 60;

/// Around the origin.
CollisionMesh boxMesh(float half = 0.1f) {
  return test::toMesh(reference::box({-half, -half, -half}, {half, half, half}));
}

AffineTransform shifted(float x) { return rigidTransform({0, 0, 0, 1}, {x, 0, 0}); }

class SdfSceneTest : public test::SceneListTest {
 protected:
  SdfCollider& addCollider(const CollisionMesh& mesh = boxMesh(), const SdfColliderDef& def = {}) {
    const Result<ColliderId> added = scene_.addCollider(mesh, def);
    EXPECT_TRUE(added) << added.error().message;
    return scene_.collider(*added);
  }
  // The fields that were uploaded for a hair object in this list.
  std::vector<Sdf> uploadedSdfs(const HairObject& hair) const {
    return uploaded<Sdf>(hair.buffers().sdfs);
  }
};

TEST_F(SdfSceneTest, AColliderIsBuiltOnceWhileItStays) {
  addHair();
  const SdfCollider& collider = addCollider();
  EXPECT_TRUE(collider.report().closed);
  simulate();
  EXPECT_EQ(count("skin_vertices"), 1u);
  EXPECT_EQ(count("scatter_triangles"), 1u);
  EXPECT_EQ(count("find_moved_triangles"), 0u) << "the first build is a whole one";
  for (int frame = 0; frame < 3; ++frame) {
    simulate();
    EXPECT_EQ(count("skin_vertices") + count("scatter_triangles") + count("compute_points"), 0u);
  }
}

TEST_F(SdfSceneTest, MotionBelowTheToleranceBuildsNothingUntilItAddsUp) {
  addHair();
  SdfCollider& collider = addCollider(boxMesh(), {.motionTolerance = 0.1f});
  const float cell = collider.grid().cellSize;
  EXPECT_NEAR(cell, 0.2f / 50, 1e-6);
  simulate();
  const auto moveTo = [&](float cells) {
    setBone(collider, shifted(cells * cell));
    simulate();
    return count("scatter_triangles");
  };
  EXPECT_EQ(moveTo(0.06f), 0u);
  EXPECT_EQ(moveTo(0.09f), 0u);
  EXPECT_EQ(moveTo(0.15f), 1u);
  EXPECT_EQ(moveTo(0.2f), 0u) << "since the last build";
}

TEST_F(SdfSceneTest, OnlyWhatMovedIsBuiltWhenItIsTheSmallerPart) {
  addHair();
  CollisionMesh mesh = boxMesh();
  const CollisionMesh other = boxMesh(0.02f);
  for (const Float3& p : other.positions) mesh.positions.push_back({p.x, p.y + 0.2f, p.z});
  for (const uint32_t index : other.indices) mesh.indices.push_back(index + 8);
  // A third part follows the first bone, so that the second one moves a third of the vertices.
  for (const Float3& p : other.positions) mesh.positions.push_back({p.x, p.y - 0.2f, p.z});
  for (const uint32_t index : other.indices) mesh.indices.push_back(index + 16);
  mesh.influences.resize(24);
  for (size_t v = 0; v < 24; ++v) {
    mesh.influences[v].bones[0] = v >= 8 && v < 16 ? 1 : 0;
    mesh.influences[v].weights[0] = 1;
  }
  SdfCollider& collider = addCollider(mesh, {.boneCount = 2});
  simulate();
  AffineTransform bones[2] = {shifted(0), shifted(0.01f)};
  collider.setBones(bones);
  simulate();
  EXPECT_EQ(count("find_moved_triangles"), 1u);
  bones[0] = shifted(0.01f);
  collider.setBones(bones);
  simulate();
  EXPECT_EQ(count("find_moved_triangles"), 0u) << "most of it moved";
  EXPECT_EQ(count("scatter_triangles"), 1u);
}

TEST_F(SdfSceneTest, WhatNoHairReachesIsNeitherBuiltNorApplied) {  // K34
  HairObject& hair = addHair();
  SdfCollider& collider = addCollider();
  AffineTransform bone = shifted(5);
  setBone(collider, bone);
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  EXPECT_EQ(hair.buffers().sdfs, BufferId::kInvalid);
  bone = shifted(0);
  setBone(collider, bone);
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 1u);
  EXPECT_EQ(uploadedSdfs(hair).size(), 1u);
  collider.enabled = false;
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  collider.enabled = true;
  hair.usesMeshColliders = false;
  bone = shifted(0.05f);
  setBone(collider, bone);
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
}

TEST_F(SdfSceneTest, FieldsAreRelativeToTheOriginOfTheHair) {  // K32
  HairObject& hair = addHair();
  SdfCollider& collider = addCollider();
  const AffineTransform bone = shifted(1024.25f);
  setBone(hair, bone);
  setBone(collider, bone);
  collider.margin = 0.002f;
  collider.friction = 0.7f;
  simulate();
  const std::vector<Sdf> sdfs = uploadedSdfs(hair);
  ASSERT_EQ(sdfs.size(), 1u);
  const SdfGrid& grid = collider.grid();
  EXPECT_NEAR(sdfs[0].origin.x, grid.origin.x - 1024, 1e-3);
  EXPECT_LT(std::abs(sdfs[0].origin.x), 1);
  EXPECT_EQ(sdfs[0].origin.w, grid.cellSize);
  EXPECT_EQ(sdfs[0].margin, 0.002f);
  EXPECT_EQ(sdfs[0].friction, 0.7f);
  EXPECT_EQ(sdfs[0].motionScale, 0.0f) << "there is no frame before";
}

TEST_F(SdfSceneTest, MotionIsThatOfConsecutiveFrames) {
  HairObject& hair = addHair();
  SdfCollider& collider = addCollider();
  simulate();
  const auto moveTo = [&](float x) {
    setBone(collider, shifted(x));
    simulate();
    const std::vector<Sdf> sdfs = uploadedSdfs(hair);
    return sdfs.empty() ? -1.0f : sdfs[0].motionScale;
  };
  EXPECT_EQ(moveTo(0.01f), 1.0f);
  EXPECT_EQ(moveTo(0.01f), 0.0f) << "it stopped";
  EXPECT_EQ(moveTo(0.01f), -1.0f) << "nothing new to upload";
  collider.reset();
  EXPECT_EQ(moveTo(0.05f), 0.0f) << "a teleport is no motion";
  EXPECT_EQ(count("scatter_triangles"), 1u);
}

TEST_F(SdfSceneTest, ColliderThatMovesKeepsHairAwake) {
  addHair();
  SdfCollider& collider = addCollider();
  simulate();
  const auto wakes = [&] {
    const auto all = constantsOf<ExactConstants>("select_awake_tiles");
    return !all.empty() && (all[0].flags & 16u) != 0;
  };
  simulate();
  simulate();
  EXPECT_FALSE(wakes());
  setBone(collider, shifted(0.01f));
  simulate();
  EXPECT_TRUE(wakes());
  simulate();
  simulate();
  EXPECT_FALSE(wakes());
  collider.friction = 0.9f;
  simulate();
  EXPECT_TRUE(wakes());
}

TEST_F(SdfSceneTest, TheGridFollowsAMeshThatWalksAndGrows) {  // K31
  HairObject& hair = addHair();
  SdfCollider& collider = addCollider();
  simulate();
  const SdfGrid first = collider.grid();
  for (int frame = 1; frame <= 40; ++frame) {
    const AffineTransform bone = shifted(0.25f * static_cast<float>(frame));
    setBone(hair, bone);
    setBone(collider, bone);
    simulate();
    const SdfGrid& grid = collider.grid();
    const float low = bone.rows[0].w - 0.1f, high = bone.rows[0].w + 0.1f;
    EXPECT_LT(grid.origin.x, low - 3 * grid.cellSize + 1e-4f);
    EXPECT_GT(grid.origin.x + grid.cellSize * static_cast<float>(grid.nodes[0] - 1),
              high + 3 * grid.cellSize - 1e-4f);
    // Nodes stay on one lattice, so that the field does not crawl over the mesh.
    const double cells = static_cast<double>(grid.origin.x) / static_cast<double>(grid.cellSize);
    EXPECT_NEAR(cells, std::round(cells), 0.01);
  }
  AffineTransform large = shifted(10);
  for (int i = 0; i < 3; ++i) (&large.rows[i].x)[i] = 3;
  setBone(collider, large);
  simulate();
  EXPECT_GT(collider.grid().nodes[0], 2 * first.nodes[0]);
  EXPECT_EQ(count("scatter_triangles"), 1u);
  // Small again: what is far too large is not kept.
  collider.setBones({&(large = shifted(10)), 1});
  simulate();
  EXPECT_LT(collider.grid().nodes[0], 2 * first.nodes[0]);
}

TEST_F(SdfSceneTest, AFieldOverTheCapIsRefusedAndNothingIsLost) {
  addHair();
  SdfCollider& collider = addCollider(boxMesh(), {.memoryCap = 1000000});
  simulate();
  const SdfGrid grid = collider.grid();
  AffineTransform large;
  for (int i = 0; i < 3; ++i) (&large.rows[i].x)[i] = 10;
  setBone(collider, large);
  expectError(scene_.simulate(kFrame, list_), {"collider 'collider'", "a cell size of"});
  EXPECT_EQ(collider.grid(), grid);
  setBone(collider, shifted(0));
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  // At once, when it is added.
  expectError(scene_.addCollider(boxMesh(), {.memoryCap = 10000}), "a cell size of");
}

TEST_F(SdfSceneTest, WhatIsWrongWithAColliderIsNamed) {
  const auto expectRefused = [&](const CollisionMesh& mesh, const SdfColliderDef& def,
                                 const char* what) {
    const uint32_t buffers = scene_.resources().count();
    expectError(scene_.addCollider(mesh, def), what);
    EXPECT_EQ(scene_.resources().count(), buffers) << "what is refused leaves nothing";
  };
  expectRefused(boxMesh(), {.cellSize = kNan}, "cellSize is nan");
  expectRefused(boxMesh(), {.band = 0.5f}, "band is 0.5");
  expectRefused(boxMesh(), {.boneCount = 0}, "boneCount must be at least 1");
  expectRefused(boxMesh(), {.motionTolerance = -1}, "motionTolerance is -1");
  CollisionMesh mesh = boxMesh();
  mesh.indices.back() = 99;
  expectRefused(mesh, {}, "99");
  mesh = boxMesh();
  mesh.influences.resize(8);
  mesh.influences[3].bones[2] = 4;
  expectRefused(mesh, {.boneCount = 4}, "vertex 3 refers to bone 4");
  mesh = boxMesh();
  mesh.positions[5].y = kNan;
  expectRefused(mesh, {}, "vertex 5 is not finite");
  mesh.indices.clear();
  expectRefused(mesh, {}, "has no triangles");
  expectRefused(CollisionMesh{}, {}, "has no triangles");
  const BufferId small = scene_.resources().add({.name = "small", .size = 64, .stride = 4});
  expectRefused(boxMesh(), {.vertices = small, .vertexStride = 4}, "has 64 bytes; 8 vertices take");
  SdfCollider& collider = addCollider();
  addHair();
  collider.friction = kNan;
  EXPECT_FALSE(scene_.simulate(kFrame, list_));
}

TEST_F(SdfSceneTest, CollidersShareTwoBuffersAndLeaveNothingBehind) {
  HairObject& hair = addHair();
  simulate();
  const uint32_t before = scene_.resources().count();
  EXPECT_EQ(scene_.sdfKeys(), BufferId::kInvalid);
  const Result<ColliderId> a = scene_.addCollider(boxMesh(), {.name = "a"});
  const Result<ColliderId> b = scene_.addCollider(boxMesh(0.05f), {.name = "b"});
  ASSERT_TRUE(a && b);
  simulate();
  const std::vector<Sdf> sdfs = uploadedSdfs(hair);
  ASSERT_EQ(sdfs.size(), 2u);
  EXPECT_EQ(sdfs[0].nodes.w, 0u);
  // The second one begins at the next 256 bytes, so that a build can bind its range alone.
  const uint32_t nodes = sdfs[0].nodes.x * sdfs[0].nodes.y * sdfs[0].nodes.z;
  EXPECT_EQ(sdfs[1].nodes.w, (nodes + 63) / 64 * 64);
  EXPECT_EQ(sdfs[1].surface, (12u * 7 + 15) / 16 * 16);
  EXPECT_TRUE(scene_.removeCollider(*a));
  simulate();
  EXPECT_EQ(uploadedSdfs(hair).at(0).nodes.w, 0u);
  EXPECT_EQ(count("scatter_triangles"), 1u) << "the other one has moved in the buffers";
  EXPECT_TRUE(scene_.removeCollider(*b));
  simulate();
  EXPECT_EQ(scene_.sdfKeys(), BufferId::kInvalid);
  EXPECT_EQ(scene_.resources().count(), before + 2 + 2)
      << "the hair keeps its buffers of fields and capsules, and of contacts";
}

TEST_F(SdfSceneTest, AnEnginesVerticesAreBuiltWhenItSaysSo) {
  addHair();
  const BufferId vertices =
      scene_.resources().add({.name = "engine", .size = 8 * 32, .stride = 32});
  SdfCollider& collider =
      addCollider(boxMesh(), {.vertices = vertices, .vertexStride = 8, .vertexOffset = 4});
  simulate();
  EXPECT_EQ(count("skin_vertices"), 0u);
  EXPECT_EQ(count("scatter_triangles"), 1u);
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  collider.setVertexBounds({-0.1f, -0.1f, -0.1f}, {0.1f, 0.1f, 0.1f});
  simulate();
  EXPECT_EQ(count("find_moved_triangles"), 1u) << "the GPU finds out what moved";
}

TEST_F(SdfSceneTest, AFieldOfAFileIsNeverBuilt) {
  HairObject& hair = addHair();
  SdfData data;
  data.grid = {.origin = {-0.1f, -0.1f, -0.1f}, .cellSize = 0.05f, .nodes = {4, 4, 4}};
  data.triangleBits = 1;
  data.triangleCount = 1;
  data.keys.assign(64, 0x7fffffffu);
  data.surface.assign(16, 0xffffffffu);
  const Result<ColliderId> added = required(scene_.addCollider(data, {.name = "baked"}));
  simulate();
  EXPECT_EQ(count("scatter_triangles") + count("skin_vertices"), 0u);
  const std::vector<Sdf> sdfs = uploadedSdfs(hair);
  ASSERT_EQ(sdfs.size(), 1u);
  EXPECT_EQ(sdfs[0].surfaceStride, 4u);
  const BufferDesc* keys = scene_.resources().find(scene_.sdfKeys());
  ASSERT_NE(keys, nullptr);
  EXPECT_EQ(std::memcmp(keys->initial.data(), data.keys.data(), 256), 0);
  const Result<SdfData> copy = required(scene_.copySdf(*added, {}, {}));
  EXPECT_EQ(*copy, data);
}

}  // namespace
}  // namespace pelage
