// Collision meshes cut out of skinned meshes, and simplified within a bound that is measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "cut_caps.h"
#include "mesh_file.h"
#include "mesh_simplify.h"
#include "pelage/authoring/collision_from_mesh.h"
#include "pelage/demo/groom.h"
#include "pelage/random.h"
#include "points.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/test_folder.h"
#include "surface_distance.h"

namespace pelage {
namespace {

using detail::TriangleTree;
using detail::Vector;
using test::expectError;
using test::required;
using test::TestFolder;
using test::valueOf;

SkinnedMesh skinnedHead(float cellSize) {
  auto head = generateHead(cellSize);
  EXPECT_TRUE(head);
  SkinnedMesh mesh;
  mesh.parts = {{"head", "", "skin", 0, static_cast<uint32_t>(head->positions.size()), 0,
                 static_cast<uint32_t>(head->indices.size() / 3)}};
  mesh.bones = head->bones;
  mesh.positions = head->positions;
  mesh.normals = head->normals;
  mesh.influences = head->influences;
  mesh.indices = head->indices;
  return mesh;
}

TriangleTree treeOf(const std::vector<Float3>& positions, const std::vector<uint32_t>& indices) {
  std::vector<uint32_t> used(indices.size() / 3);
  std::iota(used.begin(), used.end(), 0u);
  return {positions, indices, used};
}

// The largest distance of points on one surface, at random, from the other one.
double sampledDistance(const std::vector<Float3>& positions, const std::vector<uint32_t>& indices,
                       const TriangleTree& to, uint32_t samples) {
  Random random(5);
  double most = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const size_t t = 3 * size_t{random.below(static_cast<uint32_t>(indices.size() / 3))};
    double u = random.uniformDouble(), v = random.uniformDouble();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto corner = [&](size_t k) {
      const Float3& p = positions[indices[t + k]];
      return Vector{p.x, p.y, p.z};
    };
    const Vector at = corner(0) * (1 - u - v) + corner(1) * u + corner(2) * v;
    test::keepLargest(most, to.closest(at).squaredDistance);
  }
  return std::sqrt(most);
}

class CutFromATube : public testing::Test {
 protected:
  void SetUp() override {
    auto mesh = required(loadSkinnedMesh(test::writeTube(folder_.path())));
    mesh_ = *mesh;
  }

  std::vector<NamedCollisionMesh> cut(CollisionSplit by, std::vector<std::string> only = {},
                                      bool capHoles = true) const {
    CollisionMeshDef def;
    def.by = by;
    def.only = std::move(only);
    def.capHoles = capHoles;
    return valueOf(collisionMeshes(mesh_, def));
  }

  const TestFolder folder_;
  SkinnedMesh mesh_;
};

TEST_F(CutFromATube, TheWholeHasAllTriangles) {
  const auto meshes = cut(CollisionSplit::kWhole);
  ASSERT_EQ(meshes.size(), 1u);
  EXPECT_EQ(meshes[0].name, "body");
  EXPECT_EQ(meshes[0].report.triangleCount, 37u);
  EXPECT_EQ(meshes[0].report.openEdges, 3u);     // of the hat
  EXPECT_EQ(meshes[0].report.vertexCount, 23u);  // the seam between the materials is welded
  EXPECT_EQ(meshes[0].mesh.bones.size(), 3u);
  EXPECT_TRUE(saveTfxMesh(meshes[0].mesh));
}

TEST_F(CutFromATube, AWholeOfOneObjectIsThatObject) {
  const auto meshes = cut(CollisionSplit::kWhole, {"body"});
  ASSERT_EQ(meshes.size(), 1u);
  EXPECT_TRUE(meshes[0].report.closed && meshes[0].report.consistentlyOriented);
  EXPECT_NEAR(meshes[0].report.volume, 16, 1e-6);
  EXPECT_EQ(meshes[0].capCount, 0u);
  EXPECT_EQ(meshes[0].mesh.bones.size(), 2u);
}

TEST_F(CutFromATube, ByMaterialTheCutIsCapped) {
  const auto meshes = cut(CollisionSplit::kMaterial);
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].name, "cloth");
  EXPECT_EQ(meshes[1].name, "skin");
  EXPECT_EQ(meshes[1].capCount, 1u);
  EXPECT_EQ(meshes[1].report.triangleCount, 18u + 4u);
  EXPECT_EQ(meshes[1].sourceTriangleCount, 18u + 4u);
  EXPECT_TRUE(meshes[1].report.closed && meshes[1].report.consistentlyOriented);
  EXPECT_NEAR(meshes[1].report.volume, 8, 1e-6);
  // The middle of the cap, in the plane y = 2, is moved by what moves its rim.
  const CollisionMesh& skin = meshes[1].mesh;
  const Float3 middle = {0, 2, 0};
  const auto at = std::find(skin.positions.begin(), skin.positions.end(), middle);
  ASSERT_NE(at, skin.positions.end());
  const BoneInfluences& influences =
      skin.influences[static_cast<size_t>(at - skin.positions.begin())];
  EXPECT_FLOAT_EQ(influences.weights[0], 0.5f);
  EXPECT_FLOAT_EQ(influences.weights[1], 0.5f);
  // The hat's own rim is no cut.
  EXPECT_EQ(meshes[0].capCount, 1u);
  EXPECT_EQ(meshes[0].report.openEdges, 3u);

  const auto open = cut(CollisionSplit::kMaterial, {"skin"}, false);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].report.openEdges, 4u);
  EXPECT_EQ(open[0].capCount, 0u);
}

TEST_F(CutFromATube, ByPartEachObjectIsOne) {
  const auto meshes = cut(CollisionSplit::kPart);
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].name, "body");
  EXPECT_EQ(meshes[0].report.triangleCount, 36u);
  EXPECT_TRUE(meshes[0].report.closed);
  EXPECT_EQ(meshes[1].name, "hat");
  EXPECT_EQ(meshes[1].mesh.bones, (std::vector<BoneName>{{0, "hat"}}));
}

TEST_F(CutFromATube, ByBoneATriangleGoesToItsHeaviest) {
  const auto meshes = cut(CollisionSplit::kBone);
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_EQ(meshes[0].name, "hip");
  EXPECT_EQ(meshes[1].name, "chest");
  EXPECT_EQ(meshes[2].name, "hat");
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(meshes[i].report.closed && meshes[i].report.consistentlyOriented);
    EXPECT_EQ(meshes[i].capCount, 1u);
    // Up to y = 2, where both have the same share.
    EXPECT_NEAR(meshes[i].report.volume, 8, 1e-6);
  }
}

TEST_F(CutFromATube, SeamsBetweenMaterialsDoNotOpenWhenSimplified) {
  CollisionMeshDef def;
  def.by = CollisionSplit::kPart;
  def.only = {"body"};
  def.errorBound = 1e-4f;
  auto meshes = required(collisionMeshes(mesh_, def));
  const NamedCollisionMesh& body = meshes->at(0);
  EXPECT_TRUE(body.report.closed && body.report.consistentlyOriented) << describe(body.report);
  EXPECT_NEAR(body.report.volume, 16, 1e-3);
  // The rings between the ends are needed by nothing.
  EXPECT_LT(body.report.triangleCount, 36u);
  EXPECT_EQ(body.sourceTriangleCount, 36u);
}

TEST_F(CutFromATube, AMeshOfAnotherUnitAndAxesStaysClosedAndItsOutsideOut) {
  ASSERT_TRUE(prepareMesh(mesh_, {.scale = 0.5f, .upAxis = UpAxis::kZ, .invertZ = true}));
  const auto meshes = cut(CollisionSplit::kWhole, {"body"});
  EXPECT_TRUE(meshes[0].report.closed && !meshes[0].report.inverted);
  EXPECT_NEAR(meshes[0].report.volume, 2, 1e-6);
  // The tube was along y, which became -z, and then z.
  for (const Float3& p : meshes[0].mesh.positions) {
    EXPECT_TRUE(std::abs(p.x) == 0.5f && std::abs(p.y) == 0.5f && p.z >= 0 && p.z <= 2)
        << p.x << " " << p.y << " " << p.z;
  }
  expectError(prepareMesh(mesh_, {.scale = 1e7f}), "within +-1e6");
  EXPECT_FALSE(prepareMesh(mesh_, {.scale = -1}));
}

TEST_F(CutFromATube, PiecesDoNotDependOnThoseBeforeThem) {
  const auto all = cut(CollisionSplit::kBone);
  ASSERT_GT(all.size(), 1u);
  for (const NamedCollisionMesh& piece : all) {
    const auto alone = cut(CollisionSplit::kBone, {piece.name});
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_EQ(*saveTfxMesh(alone[0].mesh), *saveTfxMesh(piece.mesh)) << piece.name;
  }
}

TEST(CutRims, RingsThatMeetInAVertexAreTwoRims) {
  // Two tetrahedra with vertex 0 in common; the piece lacks a face of each, at that vertex.
  const std::vector<uint32_t> closed = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3,
                                        0, 5, 4, 0, 6, 5, 0, 4, 6, 4, 5, 6};
  std::vector<uint32_t> piece(closed.begin() + 3, closed.end());
  piece.erase(piece.begin() + 9, piece.begin() + 12);
  const auto rims = detail::cutRims(piece, detail::EdgeBalance(closed));
  ASSERT_EQ(rims.size(), 2u);
  std::vector<uint32_t> together = piece;
  for (const auto& rim : rims) {
    ASSERT_EQ(rim.size(), 3u);
    together.insert(together.end(), rim.begin(), rim.end());
  }
  EXPECT_TRUE(detail::EdgeBalance(together).isClosed());
}

TEST(CutRims, ALongRimIsFollowedToItsEnd) {
  // A strip of 2 x 300,000 triangles around a ring; the piece is its lower half. To search the path
  // at each vertex would take hours, far beyond the limit of the test program.
  constexpr uint32_t kCount = 300000;
  std::vector<uint32_t> lower, whole;
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint32_t next = (i + 1) % kCount;
    for (const uint32_t v : {i, next, kCount + next, i, kCount + next, kCount + i})
      lower.push_back(v);
  }
  whole = lower;
  for (const uint32_t v : lower) whole.push_back(v + kCount);
  const auto rims = detail::cutRims(lower, detail::EdgeBalance(whole));
  ASSERT_EQ(rims.size(), 1u);
  EXPECT_EQ(rims[0].size(), kCount);
}

TEST_F(CutFromATube, BadInputIsAnErrorThatSaysWhich) {
  CollisionMeshDef def;
  def.by = CollisionSplit::kMaterial;
  def.only = {"cloth", "fur"};
  expectError(collisionMeshes(mesh_, def), "'fur'; there are 'cloth', 'skin'");
  for (const float bound :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    def = {};
    def.errorBound = bound;
    EXPECT_FALSE(collisionMeshes(mesh_, def)) << bound;
  }
  EXPECT_FALSE(collisionMeshes({}, {}));
  mesh_.indices[3] = 1000;
  EXPECT_FALSE(collisionMeshes(mesh_, {}));
}

TEST(LargestDistance, IsWhatItIsForPlates) {
  // A square over one that is tilted: farthest at one side, 0.5 above.
  const std::vector<Float3> flat = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
  const std::vector<Float3> tilted = {{0, 0, 0}, {1, 0.5f, 0}, {1, 0.5f, 1}, {0, 0, 1}};
  const std::vector<uint32_t> square = {0, 1, 2, 0, 2, 3};
  const auto there = detail::maxDistance(tilted, square, treeOf(flat, square), 1e-4, 1e9);
  EXPECT_NEAR(there.lower, 0.5, 1e-12);
  EXPECT_GE(there.upper, there.lower);
  EXPECT_LT(there.upper, 0.5 + 1e-4);
  // A roof over its ground: farthest in the middle of an edge, where no corner is.
  const std::vector<Float3> roof = {{0, 0, 0}, {1, 0, 0},        {1, 0, 1},
                                    {0, 0, 1}, {0.5f, 0.25f, 0}, {0.5f, 0.25f, 1}};
  const std::vector<uint32_t> faces = {0, 4, 5, 0, 5, 3, 4, 1, 2, 4, 2, 5};
  const auto under = detail::maxDistance(flat, square, treeOf(roof, faces), 1e-4, 1e9);
  const double expected = 0.5 * 0.25 / std::hypot(0.5, 0.25);
  EXPECT_GE(under.upper, expected);
  EXPECT_LT(under.upper, expected + 1e-4);
  EXPECT_LE(under.lower, expected + 1e-12);
  // It gives up early when told to.
  EXPECT_GT(detail::maxDistance(tilted, square, treeOf(flat, square), 1e-4, 0.1).upper, 0.1);
}

TEST(SimplifiedHead, StaysWithinItsBoundAndClosed) {
  const SkinnedMesh mesh = skinnedHead(0.007f);
  const TriangleTree original = treeOf(mesh.positions, mesh.indices);
  size_t triangles = mesh.triangleCount();
  for (const float bound : {0.0005f, 0.004f}) {
    CollisionMeshDef def;
    def.errorBound = bound;
    auto meshes = required(collisionMeshes(mesh, def));
    const NamedCollisionMesh& head = meshes->at(0);
    EXPECT_TRUE(head.report.closed && head.report.consistentlyOriented) << describe(head.report);
    EXPECT_GT(head.report.volume, 0);
    EXPECT_EQ(head.sourceTriangleCount, mesh.triangleCount());
    EXPECT_LT(head.report.triangleCount, triangles) << bound;
    triangles = head.report.triangleCount;
    EXPECT_LE(head.error, bound);
    EXPECT_GT(head.error, 0);
    // The report says the error that samples find, and no less.
    const double found =
        std::max(sampledDistance(head.mesh.positions, head.mesh.indices, original, 20000),
                 sampledDistance(mesh.positions, mesh.indices,
                                 treeOf(head.mesh.positions, head.mesh.indices), 20000));
    EXPECT_LE(found, head.error);
    EXPECT_GT(found, 0.5 * head.error);
    EXPECT_TRUE(saveTfxMesh(head.mesh));
  }
  EXPECT_LT(triangles, mesh.triangleCount() / 8);
}

TEST(SimplifiedHead, PiecesOfItAreClosedToo) {
  CollisionMeshDef def;
  def.by = CollisionSplit::kBone;
  def.errorBound = 0.001f;
  auto meshes = required(collisionMeshes(skinnedHead(0.007f), def));
  ASSERT_EQ(meshes->size(), 2u);
  for (const NamedCollisionMesh& piece : *meshes) {
    EXPECT_TRUE(piece.report.closed && piece.report.consistentlyOriented)
        << piece.name << describe(piece.report);
    EXPECT_GE(piece.capCount, 1u);
    EXPECT_LT(piece.report.triangleCount, piece.sourceTriangleCount);
    EXPECT_LE(piece.error, def.errorBound);
  }
}

TEST(SimplifyMesh, AHoleOfTheFileStaysWithinTheBound) {
  SkinnedMesh mesh = skinnedHead(0.007f);
  std::vector<uint32_t> open;
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    if (mesh.positions[mesh.indices[i]].y > 0.02f)
      open.insert(open.end(), {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
  const auto result = detail::simplifyMesh(mesh.positions, open, 0.002, false);
  EXPECT_LT(result.indices.size(), open.size());
  EXPECT_LE(result.error, 0.002);
  EXPECT_LE(sampledDistance(mesh.positions, open, treeOf(mesh.positions, result.indices), 20000),
            result.error);
}

TEST(SimplifyMesh, NothingIsLostOfWhatCannotBeSimplified) {
  const std::vector<Float3> triangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(detail::simplifyMesh(triangle, std::vector<uint32_t>{0, 1, 2}, 0.01, false).indices,
            (std::vector<uint32_t>{0, 1, 2}));
  const std::vector<uint32_t> collapsed = {0, 0, 0};
  EXPECT_EQ(detail::simplifyMesh(triangle, collapsed, 0.01, false).indices, collapsed);
}

}  // namespace
}  // namespace pelage
