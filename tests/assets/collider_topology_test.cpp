// Neighborhood of a collider's triangles, and warnings about a mesh on load.
#include "assets/collider_topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "reference/sdf/mesh_shapes.h"
#include "support/errors.h"

namespace pelage {
namespace {

using detail::ColliderTopology;
using reference::TriangleMesh;
using test::expectError;
using test::expectHas;
using test::required;
using test::valueOf;

ColliderTopology topologyOf(const TriangleMesh& mesh) {
  return valueOf(detail::makeColliderTopology(
      mesh.indices, static_cast<uint32_t>(mesh.positions.size()), mesh.positions));
}

uint32_t pointOf(const ColliderTopology& topology, uint32_t corner) {
  return topology.weldedVertices[topology.indices[corner]];
}

// The two points of edge k of a triangle.
std::set<uint32_t> edgeOf(const ColliderTopology& topology, uint32_t triangle, uint32_t k) {
  return {pointOf(topology, triangle * 3 + k), pointOf(topology, triangle * 3 + (k + 1) % 3)};
}

// Neighbors share the edge's points and know each other.
void expectMutualAdjacency(const ColliderTopology& topology) {
  for (uint32_t t = 0; t < topology.triangleCount(); ++t)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t other = topology.adjacency[size_t{t} * 3 + k];
      if (other == ColliderTopology::kNone) continue;
      ASSERT_LT(other, topology.triangleCount());
      bool found = false;
      for (uint32_t j = 0; j < 3; ++j)
        found = found || (topology.adjacency[size_t{other} * 3 + j] == t &&
                          edgeOf(topology, other, j) == edgeOf(topology, t, k));
      ASSERT_TRUE(found) << "triangle " << t << ", edge " << k << ", neighbour " << other;
    }
}

uint32_t openSides(const ColliderTopology& topology) {
  return static_cast<uint32_t>(
      std::count(topology.adjacency.begin(), topology.adjacency.end(), ColliderTopology::kNone));
}

TEST(ColliderTopology, EveryEdgeOfAClosedMeshHasANeighbour) {
  for (const TriangleMesh& mesh :
       {reference::cube(1), reference::sphere(1, 9, 14), reference::torus(1, 0.3f, 17, 8),
        reference::plate(1, 0.01f, 6, 0.4f), reference::blob(12, 20)}) {
    const ColliderTopology topology = topologyOf(mesh);
    EXPECT_TRUE(topology.report.closed);
    EXPECT_TRUE(topology.report.consistentlyOriented);
    EXPECT_TRUE(topology.isSolid());
    EXPECT_FALSE(topology.report.inverted);
    EXPECT_GT(topology.report.volume, 0);
    EXPECT_EQ(openSides(topology), 0u);
    EXPECT_EQ(topology.indices, mesh.indices);
    expectMutualAdjacency(topology);
  }
}

TEST(ColliderTopology, HasTheVolumeOfTheMeshAlsoFarAway) {
  EXPECT_NEAR(topologyOf(reference::cube(2)).report.volume, 8, 1e-12);
  EXPECT_NEAR(topologyOf(reference::moved(reference::cube(2), {8192, -4096, 8192})).report.volume,
              8, 1e-9);
}

TEST(ColliderTopology, WeldsVerticesAtOnePlace) {
  const TriangleMesh mesh = reference::sphere(1, 9, 14);
  const ColliderTopology whole = topologyOf(mesh);
  const ColliderTopology split = topologyOf(reference::unwelded(mesh));
  EXPECT_EQ(split.report.vertexCount, mesh.indices.size());
  EXPECT_EQ(split.report.weldedVertexCount, mesh.positions.size());
  EXPECT_EQ(split.adjacency, whole.adjacency);
  EXPECT_TRUE(split.isSolid());
  for (uint32_t p = 0; p < split.pointCount(); ++p)
    EXPECT_EQ(split.weldedVertices[split.pointVertices[p]], p);
}

TEST(ColliderTopology, ZeroAndMinusZeroAreOnePlace) {
  TriangleMesh mesh = reference::box({0, 0, 0}, {1, 1, 1});
  mesh = reference::unwelded(mesh);
  for (size_t i = 0; i < mesh.positions.size(); i += 2)
    if (mesh.positions[i].x == 0) mesh.positions[i].x = -0.0f;
  EXPECT_EQ(topologyOf(mesh).report.weldedVertexCount, 8u);
}

TEST(ColliderTopology, WithoutPositionsEveryVertexIsAPlace) {
  const TriangleMesh mesh = reference::torus(1, 0.3f, 9, 8);
  auto topology = required(detail::makeColliderTopology(mesh.indices, 72, {}));
  EXPECT_EQ(topology->pointCount(), 72u);
  EXPECT_TRUE(topology->isSolid());
  EXPECT_EQ(topology->adjacency, topologyOf(mesh).adjacency);
}

TEST(ColliderTopology, ListsEveryCornerAtItsPlaceOnce) {
  const ColliderTopology topology = topologyOf(reference::unwelded(reference::blob(8, 10)));
  std::vector<uint32_t> seen(topology.indices.size(), 0);
  ASSERT_EQ(topology.pointOffsets.size(), topology.pointCount() + 1u);
  EXPECT_EQ(topology.pointOffsets.back(), topology.indices.size());
  for (uint32_t p = 0; p < topology.pointCount(); ++p)
    for (uint32_t i = topology.pointOffsets[p]; i < topology.pointOffsets[p + 1]; ++i) {
      EXPECT_EQ(pointOf(topology, topology.pointCorners[i]), p);
      ++seen[topology.pointCorners[i]];
    }
  EXPECT_EQ(seen, std::vector<uint32_t>(seen.size(), 1));
}

TEST(ColliderTopology, CountsOpenEdges) {
  const TriangleMesh mesh = reference::sphereWithHoles(1, 12, 16, 40);
  const uint32_t holes = reference::sphere(1, 12, 16).triangleCount() - mesh.triangleCount();
  ASSERT_GT(holes, 3u);
  const ColliderTopology topology = topologyOf(mesh);
  EXPECT_EQ(topology.report.openEdges, holes * 3);
  EXPECT_EQ(openSides(topology), holes * 3);
  EXPECT_FALSE(topology.report.closed);
  EXPECT_TRUE(topology.report.consistentlyOriented);
  EXPECT_FALSE(topology.isSolid());
  expectMutualAdjacency(topology);
}

TEST(ColliderTopology, DropsDuplicatesAndKeepsTheFirst) {
  const TriangleMesh mesh = reference::sphere(1, 9, 14);
  const TriangleMesh doubled = reference::withDuplicates(mesh, 5);
  const ColliderTopology topology = topologyOf(doubled);
  EXPECT_EQ(topology.report.duplicateTriangles, doubled.triangleCount() - mesh.triangleCount());
  EXPECT_EQ(topology.indices, mesh.indices);
  EXPECT_EQ(topology.report.nonManifoldEdges, 0u);
  EXPECT_TRUE(topology.isSolid());
}

TEST(ColliderTopology, ATriangleAndItsBackSideAreNoDuplicates) {
  TriangleMesh mesh = reference::cube(1);
  mesh.indices.insert(mesh.indices.end(), {mesh.indices[0], mesh.indices[2], mesh.indices[1]});
  const ColliderTopology topology = topologyOf(mesh);
  EXPECT_EQ(topology.report.duplicateTriangles, 0u);
  EXPECT_EQ(topology.report.nonManifoldEdges, 3u);
  EXPECT_EQ(openSides(topology), 9u);  // both sides and the cube's three neighbours
}

TEST(ColliderTopology, DropsTrianglesWithTwoCornersAtOnePlace) {
  const TriangleMesh mesh = reference::cube(1);
  TriangleMesh worse = reference::withZeroArea(mesh, 6);  // 2 x (point, edge, line)
  const ColliderTopology topology = topologyOf(worse);
  EXPECT_EQ(topology.report.degenerateTriangles, 6u);
  EXPECT_EQ(topology.report.usedTriangleCount, mesh.triangleCount() + 2);  // lines may open later
  EXPECT_EQ(topology.sourceTriangles.back(), worse.triangleCount() - 1);
  expectMutualAdjacency(topology);
}

TEST(ColliderTopology, AMeshWithTrianglesThatAreNotFiniteIsNotClosed) {
  const ColliderTopology topology = topologyOf(reference::withNaN(reference::cube(1)));
  EXPECT_EQ(topology.report.nonFiniteVertices, 2u);
  EXPECT_EQ(topology.report.nonFiniteTriangles, 1u);
  EXPECT_FALSE(topology.report.closed);
  EXPECT_NEAR(topology.report.volume, 1, 1e-12);

  TriangleMesh closed = reference::cube(1);
  closed.positions[3].y = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(topologyOf(closed).report.closed);
}

TEST(ColliderTopology, TurnsAnInvertedMeshRound) {
  const TriangleMesh mesh = reference::torus(1, 0.3f, 12, 9);
  const ColliderTopology right = topologyOf(mesh);
  const ColliderTopology topology = topologyOf(reference::mirroredMesh(mesh));
  EXPECT_TRUE(topology.report.inverted);
  EXPECT_NEAR(topology.report.volume, -right.report.volume, 1e-12);
  EXPECT_EQ(topology.indices, right.indices);
  EXPECT_EQ(topology.adjacency, right.adjacency);
  EXPECT_EQ(topology.pointCorners, right.pointCorners);
}

TEST(ColliderTopology, FindsTrianglesOfOppositeOrientation) {
  TriangleMesh mesh = reference::sphere(1, 9, 14);
  std::swap(mesh.indices[90], mesh.indices[91]);
  const ColliderTopology topology = topologyOf(mesh);
  EXPECT_EQ(topology.report.misorientedEdges, 3u);
  EXPECT_TRUE(topology.report.closed);
  EXPECT_FALSE(topology.report.consistentlyOriented);
  EXPECT_FALSE(topology.isSolid());
}

TEST(ColliderTopology, ThreeFansAtOneEdgeAreNotNeighbours) {
  // Two tetrahedra that share an edge: closed all the same, since every crossing in has one out.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, 0, 4, 1, 0, 1, 5, 0, 5, 4, 1, 4, 5};
  const ColliderTopology topology = topologyOf(mesh);
  EXPECT_EQ(topology.report.nonManifoldEdges, 1u);
  EXPECT_EQ(openSides(topology), 4u);
  EXPECT_TRUE(topology.isSolid());
  expectMutualAdjacency(topology);
}

TEST(ColliderTopology, AnEmptyMeshIsNotClosed) {
  const ColliderTopology topology = topologyOf({});
  EXPECT_FALSE(topology.report.closed);
  EXPECT_EQ(topology.pointOffsets, std::vector<uint32_t>{0});
  expectHas(describe(topology.report), "empty");
}

TEST(ColliderTopology, RefusesIndicesThatAreWrong) {
  const std::array<uint32_t, 3> beyond = {0, 1, 3};
  expectError(detail::makeColliderTopology(beyond, 3, {}), "triangle 0 refers to vertex 3 of 3");
  EXPECT_FALSE(detail::makeColliderTopology(std::span(beyond).first(2), 4, {}));
  const std::array<Float3, 2> few = {};
  EXPECT_FALSE(detail::makeColliderTopology(beyond, 4, few));
}

TEST(MeshReport, SaysWhatIsWrong) {
  TriangleMesh shape = reference::withNaN(
      reference::withZeroArea(reference::withDuplicates(reference::cube(1), 6), 12));
  CollisionMesh mesh;
  mesh.positions = shape.positions;
  mesh.indices = shape.indices;
  auto report = required(inspectMesh(mesh));
  const std::string text = describe(*report);
  for (const char* part : {"open", "2 vertices that are not finite", "1 triangles that are not",
                           "2 duplicate triangles", "triangles without area", "two of three axes"})
    expectHas(text, part);
  EXPECT_EQ(describe(topologyOf(reference::cube(1)).report),
            "12 triangles, 8 vertices at 8 points, closed");
}

TEST(MeshReport, TheRealMeshesAreClosed) {
  const std::filesystem::path folder = std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy";
  for (const auto& [file, triangles] :
       {std::pair{"Ratboy_body.tfxmesh", 25814u}, {"Ratboy_left_hand.tfxmesh", 2490u}}) {
    if (!std::filesystem::exists(folder / file)) GTEST_SKIP() << "skipped: " << folder / file;
    auto mesh = required(loadTfxMesh(folder / file));
    auto report = required(inspectMesh(*mesh));
    EXPECT_EQ(report->triangleCount, triangles);
    EXPECT_TRUE(report->closed && report->consistentlyOriented) << describe(*report);
    EXPECT_FALSE(report->inverted);
  }
}

}  // namespace
}  // namespace pelage
