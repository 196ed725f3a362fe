// Roots bound to skinned meshes: the closest point, the weights there, and what is reported.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "mesh_file.h"
#include "pelage/authoring/skin_binding.h"
#include "pelage/mesh_import.h"
#include "pelage/random.h"
#include "points.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/test_folder.h"
#include "triangle_tree.h"

namespace pelage {
namespace {

using detail::SurfacePoint;
using detail::TriangleTree;
using detail::Vector;
using test::expectError;
using test::kNan;
using test::required;
using test::TestFolder;

Float3 randomPoint(Random& random, float size) {
  const float x = random.uniform(), y = random.uniform(), z = random.uniform();
  return {size * (x - 0.5f), size * (y - 0.5f), size * (z - 0.5f)};
}

Vector toVector(const Float3& p) { return {p.x, p.y, p.z}; }

// One part of loose triangles, all on one bone.
SkinnedMesh meshOf(std::vector<Float3> positions) {
  SkinnedMesh mesh;
  const auto count = static_cast<uint32_t>(positions.size());
  mesh.parts = {{"loose", "", "", 0, count, 0, count / 3}};
  mesh.bones = {{0, "root"}};
  mesh.positions = std::move(positions);
  mesh.normals.resize(count);
  mesh.influences.assign(count, {{0, 0, 0, 0}, {1, 0, 0, 0}});
  mesh.indices.resize(count);
  std::iota(mesh.indices.begin(), mesh.indices.end(), 0u);
  return mesh;
}

std::map<std::string, double> weightsOf(const BoneWeights& weights, size_t strand) {
  std::map<std::string, double> result;
  const BoneInfluences& influences = weights.strands.at(strand);
  for (size_t k = 0; k < 4; ++k)
    if (influences.weights[k] > 0)
      result[weights.bones.at(influences.bones[k]).name] += influences.weights[k];
  return result;
}

TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    std::array<Vector, 3> triangle;
    for (Vector& corner : triangle) corner = toVector(randomPoint(random, 2));
    if (i % 10 == 0) triangle[2] = triangle[0] + (triangle[1] - triangle[0]) * 0.25;  // no area
    if (i % 30 == 0) triangle[1] = triangle[0];
    const Vector point = toVector(randomPoint(random, 4));
    const SurfacePoint found = detail::closestPoint(point, triangle);
    Vector site;
    double sum = 0;
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_GE(found.barycentric[k], 0);
      sum += found.barycentric[k];
      site += triangle[k] * found.barycentric[k];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_LT(length(site - found.position), 1e-12);
    EXPECT_NEAR(dot(point - site, point - site), found.squaredDistance, 1e-12);
    for (int a = 0; a <= 20; ++a)
      for (int b = 0; a + b <= 20; ++b) {
        const Vector at = triangle[0] * (a / 20.0) + triangle[1] * (b / 20.0) +
                          triangle[2] * ((20 - a - b) / 20.0);
        EXPECT_GE(dot(point - at, point - at), found.squaredDistance - 1e-12);
      }
  }
}

TEST(ClosestPoint, TheTreeFindsWhatASearchOfAllTrianglesFinds) {
  Random random(2);
  std::vector<Float3> positions;
  for (int i = 0; i < 700; ++i) {
    const Float3 center = randomPoint(random, 10);
    for (int k = 0; k < 3; ++k) {
      const Float3 offset = randomPoint(random, i % 50 == 0 ? 8.0f : 0.5f);
      positions.push_back({center.x + offset.x, center.y + offset.y, center.z + offset.z});
    }
    // Some are there twice, with their corners in another order.
    if (i % 7 == 0) {
      const size_t at = positions.size() - 3;
      positions.insert(positions.end(), {positions[at + 1], positions[at + 2], positions[at]});
    }
  }
  const SkinnedMesh mesh = meshOf(positions);
  std::vector<uint32_t> used(mesh.triangleCount());
  std::iota(used.begin(), used.end(), 0u);
  const TriangleTree tree(mesh.positions, mesh.indices, used);
  for (int i = 0; i < 500; ++i) {
    const Vector point = toVector(randomPoint(random, i % 5 == 0 ? 40.0f : 12.0f));
    SurfacePoint expected;
    expected.squaredDistance = std::numeric_limits<double>::infinity();
    for (const uint32_t t : used) {
      SurfacePoint candidate = detail::closestPoint(point, tree.corners(t));
      candidate.triangle = t;
      if (candidate.squaredDistance < expected.squaredDistance) expected = candidate;
    }
    const SurfacePoint found = tree.closest(point, random.below(mesh.triangleCount()));
    EXPECT_EQ(found.triangle, expected.triangle);
    EXPECT_EQ(found.squaredDistance, expected.squaredDistance);
  }
}

TEST(ClosestPoint, AmongTrianglesThatShareIt_TheLowestIsTaken) {
  // A fan around the y axis; what is above its middle is as close to all of it.
  std::vector<Float3> positions;
  for (int i = 0; i < 7; ++i) {
    const double a = 0.9 * i, b = 0.9 * (i + 1);
    positions.insert(positions.end(),
                     {{static_cast<float>(std::cos(b)), -1, static_cast<float>(std::sin(b))},
                      {0.1f, 0.3f, 0.2f},
                      {static_cast<float>(std::cos(a)), -1, static_cast<float>(std::sin(a))}});
  }
  const SkinnedMesh mesh = meshOf(positions);
  for (const std::vector<uint32_t>& used :
       {std::vector<uint32_t>{0, 1, 2, 3, 4, 5, 6}, std::vector<uint32_t>{6, 3, 5, 4}}) {
    const TriangleTree tree(mesh.positions, mesh.indices, used);
    const uint32_t lowest = *std::min_element(used.begin(), used.end());
    for (const uint32_t hint : used)
      EXPECT_EQ(tree.closest({0.1, 2, 0.2}, hint).triangle, lowest) << hint;
    // Outwards of the edge between 4 and 5.
    const Vector rim = toVector(mesh.positions[4 * 3]), top = {0.1f, 0.3f, 0.2f};
    const Vector side = {rim.x, 1.5, rim.z};
    EXPECT_EQ(tree.closest((rim + top) * 0.5 + side, 5).triangle, 4u);
  }
}

class BoundToATube : public testing::Test {
 protected:
  void SetUp() override {
    auto mesh = required(loadSkinnedMesh(test::writeTube(folder_.path())));
    mesh_ = *mesh;
  }

  const TestFolder folder_;
  SkinnedMesh mesh_;
};

TEST_F(BoundToATube, ThePartsOfAFileAreItsObjectsByMaterialInTheFilesOrder) {
  ASSERT_EQ(mesh_.parts.size(), 3u);
  EXPECT_TRUE(validate(mesh_));
  const std::array<std::array<std::string, 2>, 3> expected = {
      {{"body", "cloth"}, {"body", "skin"}, {"hat", "cloth"}}};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(mesh_.parts[i].name, expected[i][0]);
    EXPECT_EQ(mesh_.parts[i].material, expected[i][1]);
    EXPECT_EQ(mesh_.parts[i].vertexCount, i < 2 ? 12u : 3u);
    EXPECT_EQ(mesh_.parts[i].triangleCount, i < 2 ? 18u : 1u);
  }
  EXPECT_EQ(mesh_.parts[2].mesh, "hatMesh");
  // The third vertex of the second ring of the upper half.
  const Float3 expectedPosition = {1, 3, -1};
  EXPECT_EQ(mesh_.positions[mesh_.parts[1].firstVertex + 6], expectedPosition);
  // The mesh has shared vertices: it is welded only for collision.
  auto welded = required(loadMesh(folder_ / "tube.gltf"));
  EXPECT_EQ(welded->positions.size(), 20u + 3u);
}

TEST_F(BoundToATube, WeightsAreThoseOfTheSurfaceAndSumToOne) {
  Random random(3);
  std::vector<Float3> roots;
  for (int i = 0; i < 500; ++i)
    roots.push_back({1.001f, 4 * random.uniform(), 2 * random.uniform() - 1});
  auto binding = required(bindRoots(roots, mesh_));
  for (size_t i = 0; i < roots.size(); ++i) {
    auto weights = weightsOf(binding->weights, i);
    EXPECT_NEAR(weights["hip"], 1 - roots[i].y / 4, 1e-6);
    EXPECT_NEAR(weights["chest"], roots[i].y / 4, 1e-6);
    const float* w = binding->weights.strands[i].weights;
    EXPECT_NEAR(double{w[0]} + w[1] + w[2] + w[3], 1, 1e-6);
    EXPECT_GE(w[0], w[1]);
  }
  EXPECT_NEAR(binding->report.maxDistance, 0.001, 1e-6);
  EXPECT_NEAR(binding->report.meanDistance, 0.001, 1e-6);
  EXPECT_TRUE(binding->report.farStrands.empty());
  EXPECT_EQ(binding->report.maxLostWeight, 0);
}

TEST_F(BoundToATube, ARootKnowsItsTriangleInTheFile) {
  auto binding =
      required(bindRoots(std::vector<Float3>{{0.5f, 2.25f, 1.5f}, {0.25f, 5.5f, 0.25f}}, mesh_));
  // Front of the lowest ring of the upper half: the triangles 0 1 5 and 0 5 4 of its primitive.
  const SurfaceRoot& front = binding->table.roots[0];
  EXPECT_EQ(front.part, 1u);
  EXPECT_EQ(front.triangle, 0u);
  EXPECT_EQ((std::array{front.corners[0], front.corners[1], front.corners[2]}),
            (std::array{0u, 1u, 5u}));
  EXPECT_NEAR(front.barycentric.x, 0.25, 1e-6);
  EXPECT_NEAR(front.barycentric.y, 0.5, 1e-6);
  EXPECT_NEAR(front.barycentric.z, 0.25, 1e-6);
  EXPECT_NEAR(front.offset.x, 0, 1e-6);
  EXPECT_NEAR(front.offset.y, 0, 1e-6);
  EXPECT_NEAR(front.offset.z, 0.5, 1e-6);
  EXPECT_EQ(binding->table.parts[1].name, "body");
  EXPECT_EQ(binding->table.parts[1].material, "skin");
  EXPECT_EQ(binding->table.roots[1].part, 2u);
  EXPECT_TRUE(validate(binding->table));
}

TEST_F(BoundToATube, OnlyBonesThatARootFollowsAreKept) {
  auto binding =
      required(bindRoots(std::vector<Float3>{{0.2f, 5.01f, 0.2f}, {0, -0.001f, 0}}, mesh_));
  ASSERT_EQ(binding->weights.bones.size(), 2u);
  EXPECT_EQ(binding->weights.bones[0], (BoneName{0, "hip"}));
  EXPECT_EQ(binding->weights.bones[1], (BoneName{1, "hat"}));
  EXPECT_EQ(weightsOf(binding->weights, 0).at("hat"), 1);
  EXPECT_EQ(weightsOf(binding->weights, 1).at("hip"), 1);
  EXPECT_TRUE(saveTfxBone(binding->weights));
}

TEST_F(BoundToATube, StrandsThatDoNotTouchTheMeshAreReported) {
  BindDef def;
  def.maxDistance = 0.01f;
  auto binding = required(bindRoots(
      std::vector<Float3>{{1, 1, 0}, {1.5f, 1, 0}, {1.009f, 1, 0}, {0, 1, 3}}, mesh_, def));
  const std::vector<FarStrand>& far = binding->report.farStrands;
  ASSERT_EQ(far.size(), 2u);
  EXPECT_EQ(far[0], (FarStrand{1, 0.5f}));
  EXPECT_EQ(far[1], (FarStrand{3, 2.0f}));
  EXPECT_EQ(binding->report.maxDistance, 2);
  EXPECT_NEAR(weightsOf(binding->weights, 3).at("hip"), 0.75, 1e-6);  // bound all the same
}

TEST(BindRoots, KeepsTheHeaviestBonesAndSaysWhatIsLost) {
  SkinnedMesh mesh = meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.bones.clear();
  for (uint32_t i = 0; i < 12; ++i) mesh.bones.push_back({i, "bone" + std::to_string(i)});
  for (uint32_t v = 0; v < 3; ++v)
    mesh.influences[v] = {{4 * v, 4 * v + 1, 4 * v + 2, 4 * v + 3}, {0.4f, 0.3f, 0.2f, 0.1f}};
  // At 1/2 1/4 1/4: 0.2 0.15 0.1 0.05 and twice 0.1 0.075 0.05 0.025.
  const std::vector<Float3> roots = {{0.25f, 0.25f, 0}};
  auto binding = required(bindRoots(roots, mesh));
  auto weights = weightsOf(binding->weights, 0);
  EXPECT_EQ(weights.size(), 4u);
  EXPECT_NEAR(weights["bone0"], 0.2 / 0.55, 1e-6);
  EXPECT_NEAR(weights["bone1"], 0.15 / 0.55, 1e-6);
  EXPECT_NEAR(binding->report.maxLostWeight, 0.45, 1e-6);

  BindDef one;
  one.maxBones = 1;
  binding = bindRoots(roots, mesh, one);
  ASSERT_TRUE(binding);
  EXPECT_EQ(weightsOf(binding->weights, 0), (std::map<std::string, double>{{"bone0", 1.0}}));
  EXPECT_NEAR(binding->report.maxLostWeight, 0.8, 1e-6);
}

TEST(BindRoots, NoRootIsBoundToATriangleWithoutArea) {
  SkinnedMesh mesh = meshOf({{0, 0, 0},
                             {1, 0, 0},
                             {0.5f, 0, 0},  // a segment, closest
                             {0, -1, 0},
                             {1, -1, 0},
                             {0, -1, 1}});
  auto binding = required(bindRoots(std::vector<Float3>{{0.25f, 0, 0.25f}}, mesh));
  EXPECT_EQ(binding->table.roots[0].triangle, 1u);
  EXPECT_EQ(binding->report.degenerateTriangles, 1u);
  mesh = meshOf({{0, 0, 0}, {1, 0, 0}, {0.5f, 0, 0}});
  binding = bindRoots(std::vector<Float3>{{0, 0, 0}}, mesh);
  expectError(binding, "area");
}

TEST(BindRoots, BadInputIsAnErrorThatSaysWhich) {
  const SkinnedMesh good = meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const std::vector<Float3> roots = {{0, 0, 0}, {0, 0, 0}};
  const auto fails = [&](std::span<const Float3> at, const SkinnedMesh& mesh, const BindDef& def,
                         std::string_view text) { expectError(bindRoots(at, mesh, def), {text}); };
  EXPECT_TRUE(bindRoots(roots, good));
  fails({}, good, {}, "no roots");
  fails(std::vector<Float3>{{0, 0, 0}, {0, kNan, 0}}, good, {}, "strand 1");
  fails(std::vector<Float3>{{2e6f, 0, 0}}, good, {}, "strand 0");
  fails(roots, good, {0.1f, 0}, "maxBones is 0");
  fails(roots, good, {0.1f, 5}, "maxBones is 5");
  fails(roots, good, {-1, 4}, "maxDistance");
  fails(roots, good, {kNan, 4}, "maxDistance");
  fails(roots, {}, {}, "it needs parts");
  SkinnedMesh mesh = good;
  mesh.indices[1] = 3;
  fails(roots, mesh, {}, "refers to vertex 3");
  mesh = good;
  mesh.positions[2].y = kNan;
  fails(roots, mesh, {}, "vertex 2");
  mesh = good;
  mesh.influences[1].weights[0] = 0;
  fails(roots, mesh, {}, "vertex 1");
  mesh = good;
  mesh.parts[0].triangleCount = 2;
  fails(roots, mesh, {}, "2 of 1 triangles");
  mesh = good;
  mesh.bones[0].index = 1;
  fails(roots, mesh, {}, "bone 'root'");
}

TEST(CompareWeights, IsTheSumOfDifferencesByName) {
  BoneWeights a, b;
  a.bones = {{0, "x"}, {1, "y"}};
  b.bones = {{1, "x"}, {0, "y"}, {2, "z"}};
  a.strands = {{{0, 1, 0, 0}, {0.75f, 0.25f, 0, 0}}, {{0, 0, 0, 0}, {1, 0, 0, 0}}};
  b.strands = {{{1, 0, 0, 0}, {1.5f, 0.5f, 0, 0}}, {{2, 2, 1, 2}, {0.5f, 0.25f, 0.25f, 0}}};
  auto comparison = required(compareWeights(a, b));
  EXPECT_EQ(comparison->difference, (std::vector<float>{0, 1.5f}));
  EXPECT_FLOAT_EQ(comparison->mean, 0.75f);
  EXPECT_FLOAT_EQ(comparison->max, 1.5f);
  EXPECT_FLOAT_EQ(comparison->shareAboveTenth, 0.5f);
  b.strands.pop_back();
  EXPECT_FALSE(compareWeights(a, b));
}

TEST(RatboysMohawk, BoundToItsBodyHasTheWeightsThatItCameWith) {
  const std::filesystem::path folder = std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no test data";
  auto hair = loadTfx(folder / "Ratboy_mohawk.tfx");
  auto mesh = loadSkinnedMesh(folder / "Ratboy_body.tfxmesh");
  auto own = loadTfxBone(folder / "Ratboy_mohawk.tfxbone");
  ASSERT_TRUE(hair && mesh && own);
  auto binding = required(bindRoots(rootsOf(*hair), *mesh));
  // It grows on the mesh: same space, same unit.
  EXPECT_LT(binding->report.maxDistance, 0.001);
  EXPECT_LT(binding->report.meanDistance, 0.0001);
  EXPECT_TRUE(binding->report.farStrands.empty());
  auto comparison = required(compareWeights(binding->weights, *own));
  EXPECT_LT(comparison->mean, 0.0005);
  EXPECT_LT(comparison->max, 0.01);
  EXPECT_EQ(comparison->shareAboveTenth, 0);
}

}  // namespace
}  // namespace pelage
