// Signed distance fields from meshes, against a tree of boxes in double precision.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <bit>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include "pelage/collision_mesh.h"
#include "pelage/random.h"
#include "sdf/sdf_run.h"
#include "support/full_stress.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

using detail::SdfBuildMode;
using reference::blob;
using reference::box;
using reference::cube;
using reference::joined;
using reference::moved;
using reference::overlappingSpheres;
using reference::plate;
using reference::rotated;
using reference::scaled;
using reference::sphere;
using reference::sphereWithHoles;
using reference::torus;
using reference::unwelded;
using reference::withDuplicates;
using reference::withNaN;
using reference::withZeroArea;

struct ClosedShape {
  const char* name;
  TriangleMesh mesh;
  float cell;
};

// Along x, lines through nodes meet edges on the way in and a face on the way out.
TriangleMesh pyramid() {
  return {{{-1, 0, 0}, {0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}},
          {0, 2, 1, 0, 3, 2, 0, 4, 3, 0, 1, 4, 1, 2, 3, 1, 3, 4}};
}

// Closed ones. The plates are 1.2 and 0.3 cells thick.
std::vector<ClosedShape> closedShapes() {
  return {{"sphere", sphere(1, 24, 36), 0.1f},
          {"torus", torus(1, 0.35f, 48, 20), 0.09f},
          {"cube", rotated(cube(1.5f), {0.3f, 0.7f, 0.2f}, 0.6f), 0.11f},
          {"upright cube", cube(1.6f), 0.1f},
          {"plate of 1.2 cells", plate(2, 0.12f, 6, 0.4f), 0.1f},
          {"plate of 0.3 cells", plate(2, 0.03f, 6, 0.4f), 0.1f},
          {"pyramid", pyramid(), 0.125f},
          {"blob", blob(24, 36), 0.06f}};
}

/// A mesh of the data folder; empty when it is not there.
TriangleMesh ratboy(const char* file) {
  const auto path = std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy" / file;
  const auto loaded = loadTfxMesh(path);
  if (!loaded) return {};
  return {loaded->positions, loaded->indices};
}

/// So that its extent along x is that many cells.
float cellOf(const TriangleMesh& mesh, float cells) {
  float low = mesh.positions[0].x, high = low;
  for (const Float3& p : mesh.positions) {
    keepSmallest(low, p.x);
    keepLargest(high, p.x);
  }
  return (high - low) / cells;
}

/// The same triangles in another order.
TriangleMesh shuffled(const TriangleMesh& mesh, uint64_t seed) {
  TriangleMesh result = mesh;
  pelage::Random random(seed);
  for (size_t i = mesh.triangleCount(); i > 1; --i) {
    const size_t j = random.below(static_cast<uint32_t>(i));
    for (size_t k = 0; k < 3; ++k)
      std::swap(result.indices[3 * (i - 1) + k], result.indices[3 * j + k]);
  }
  return result;
}

void expectRightBand(const SdfErrors& errors, const std::string& what = "") {
  EXPECT_EQ(errors.wrongSigns, 0u) << what;
  EXPECT_EQ(errors.missing, 0u) << what;
  EXPECT_LE(errors.band, 5e-5) << what << " [cell]";
}

void expectRight(const SdfErrors& errors, const std::string& what) {
  expectRightBand(errors, what);
  EXPECT_EQ(errors.unsetInside, 0u) << what;
  EXPECT_EQ(errors.misplacedFar, 0u) << what;
  EXPECT_LE(errors.interior, 0.5) << what << " [cell]";
  EXPECT_LE(errors.interiorMean, 0.005) << what << " [cell]";
  std::printf("[ FIGURE ] %s: %llu coarse nodes inside, off by %.4f on average, by %.4f at most\n",
              what.c_str(), static_cast<unsigned long long>(errors.far), errors.interiorMean,
              errors.interior);
}

class SdfBuild : public GpuTest {
 protected:
  /// How many offsets of a mesh from its grid are tried: one on the APIs whose bits are the first
  /// one's.
  int offsets(int ofFirst) const { return GetParam() == kFirstApi ? ofFirst : 1; }
};

TEST_P(SdfBuild, SignsAndDistancesAreRightWhereverTheGridIs) {  // K25, K26, K27, K28
  for (const ClosedShape& shape : closedShapes()) {
    uint64_t far = 0;
    for (int i = 0; i < offsets(10); ++i) {
      const float s = shape.cell * static_cast<float>(i) / 10;
      const TriangleMesh mesh = moved(shape.mesh, {s, 0.7f * s, -0.4f * s});
      SdfRun run(gpu(), mesh, {.cellSize = shape.cell});
      run.build();
      const SdfErrors errors = errorsOf(run, trueDistances(run, mesh));
      expectRight(errors, std::string(shape.name) + ", offset " + std::to_string(i));
      EXPECT_EQ(run.counters().interiorNodes, errors.far);
      far += errors.far;
    }
    const bool plate = std::string(shape.name).starts_with("plate");
    EXPECT_EQ(far == 0, plate) << "the interior of " << shape.name << " is beyond the band";
  }
}

TEST_P(SdfBuild, TheHandAndTheBodyAreRight) {
  for (const auto& [file, cells] :
       {std::pair("Ratboy_left_hand.tfxmesh", 18.0f), {"Ratboy_body.tfxmesh", 50.0f}}) {
    const TriangleMesh shape = ratboy(file);
    if (shape.positions.empty()) GTEST_SKIP() << file << " is not there";
    const float cell = cellOf(shape, cells);
    for (int i = 0; i < offsets(fullStress() ? 10 : 2); ++i) {
      const float s = cell * static_cast<float>(i) / 10;
      const TriangleMesh mesh = moved(shape, {s, 0.7f * s, -0.4f * s});
      SdfRun run(gpu(), mesh, {.cellSize = cell});
      run.build();
      expectRight(errorsOf(run, trueDistances(run, mesh)),
                  std::string(file) + ", offset " + std::to_string(i));
    }
  }
}

TEST_P(SdfBuild, ThreeAxesAgreeWithOneOnClosedMeshes) {
  std::vector<ClosedShape> shapes = closedShapes();
  shapes.push_back({"sphere of 25 cells", sphere(1, 24, 36), 0.079f});
  const TriangleMesh hand = ratboy("Ratboy_left_hand.tfxmesh");
  if (!hand.positions.empty()) shapes.push_back({"hand", hand, cellOf(hand, 18)});
  for (const ClosedShape& shape : shapes) {
    SdfRun one(gpu(), shape.mesh, {.cellSize = shape.cell});
    one.build();
    SdfRun run(gpu(), shape.mesh, {.cellSize = shape.cell, .threeAxes = true});
    run.build();
    const std::vector<double> truth = trueDistances(run, shape.mesh);
    expectRight(errorsOf(run, truth), shape.name);
    // On the surface itself there is no right sign.
    uint64_t different = 0;
    for (uint64_t i = 0; i < run.nodeCount(); ++i)
      if (std::abs(truth[i]) >= 1e-4 && !one.isFar(i) && run.key(i) != one.key(i)) ++different;
    EXPECT_EQ(different, 0u) << shape.name;
  }
}

// A wide band makes the box of every triangle large.
TEST_P(SdfBuild, SmallTrianglesNeedNoGroupsOfTheirOwnInAWideBand) {
  const TriangleMesh mesh = sphere(1, 24, 36);
  for (const float band : {4.0f, 7.0f}) {
    SdfRun run(gpu(), mesh, {.cellSize = 0.1f, .band = band});
    run.build();
    EXPECT_EQ(run.counters().bigTriangles, 0u) << band;
    const SdfErrors errors = errorsOf(run, trueDistances(run, mesh));
    EXPECT_EQ(errors.wrongSigns, 0u) << band;
    EXPECT_EQ(errors.missing, 0u) << band;
    EXPECT_LE(errors.band, static_cast<double>(band) * 2.5e-5) << band;
    EXPECT_LE(errors.interior, 0.1) << band;
  }
}

TEST_P(SdfBuild, ThreeAxesOutvoteHoles) {
  const TriangleMesh mesh = sphereWithHoles(1, 40, 60, 101);
  uint64_t wrong[2] = {};
  for (const bool three : {false, true}) {
    SdfRun run(gpu(), mesh, {.cellSize = 0.06f, .threeAxes = three});
    run.build();
    const SdfErrors errors = errorsOf(run, trueDistances(run, mesh));
    wrong[three ? 1 : 0] = errors.wrongSigns;
    EXPECT_LE(errors.unsetInside, three ? 0u : errors.wrongSigns);
  }
  EXPECT_GT(wrong[0], 200u) << "one axis is deceived along whole lines";
  EXPECT_LT(20 * wrong[1], wrong[0]) << wrong[1];
}

TEST_P(SdfBuild, OverlappingPartsAreOneInsideThatLeadsOut) {
  const TriangleMesh mesh = overlappingSpheres(1, 1.1f, 32, 48);
  const float cell = 0.08f;
  SdfRun run(gpu(), mesh, {.cellSize = cell, .threeAxes = true});
  run.build();
  const std::vector<double> truth = trueDistances(run, mesh);
  const SdfErrors errors = errorsOf(run, truth);
  EXPECT_EQ(errors.wrongSigns, 0u);
  EXPECT_EQ(errors.unsetInside, 0u);

  // Nodes inside that know a triangle have one of the outer surface, or at most two cells behind
  // the seam. Of the nearest ones, many are in the lens between the spheres, up to 5.6 cells deep.
  uint64_t inside = 0, swallowed = 0;
  for (uint64_t i = 0; i < run.nodeCount(); ++i) {
    const uint32_t t = run.triangle(i);
    if (run.isInside(i) && !run.isFar(i)) {
      EXPECT_LE(run.distance(i), -truth[i] + 1e-3) << "with or without a triangle";
    }
    if (run.isFar(i)) {
      EXPECT_LT(t, mesh.triangleCount());
    }
    if (!run.isInside(i) || t >= mesh.triangleCount()) continue;
    ++inside;
    double depth[2] = {0, 0};
    for (size_t k = 0; k < 3; ++k) {
      const Float3& p = mesh.positions[mesh.indices[3 * t + k]];
      const Vector3d corner = {static_cast<double>(p.x), static_cast<double>(p.y),
                               static_cast<double>(p.z)};
      for (int side = 0; side < 2; ++side)
        depth[side] += (1 - (corner - Vector3d(side == 0 ? -0.55 : 0.55, 0, 0)).norm()) / 3;
    }
    if (std::max(depth[0], depth[1]) > 2.5 * static_cast<double>(cell)) ++swallowed;
  }
  EXPECT_GT(inside, 1000u);
  EXPECT_LT(100 * swallowed, inside) << swallowed;
}

TEST_P(SdfBuild, TrianglesLargerThanTheGridAreSharedByGroups) {
  // The top of a block of 400 cells, turned, in a grid of 40 cells; each triangle is as large.
  for (const float angle : {0.0f, 0.3f}) {
    TriangleMesh mesh = rotated(box({-20, -40, -20}, {20, 0.013f, 20}), {1, 0.2f, 0.4f}, angle);
    mesh = joined(mesh, moved(sphere(0.5f, 16, 24), {0.2f, 1.2f, 0.1f}));
    SdfRun run(gpu(), mesh, {.cellSize = 0.1f, .box = {{-2, -2, -2}, {2, 2, 2}}});
    run.build();
    const SdfErrors errors = errorsOf(run, trueDistances(run, mesh));
    expectRightBand(errors);
    EXPECT_EQ(run.counters().bigTriangles, 2u) << angle;
  }
}

TEST_P(SdfBuild, AMeshThatLeavesTheGridKeepsItsSigns) {
  const TriangleMesh mesh = blob(24, 36);
  for (const std::vector<Float3>& box :
       {std::vector<Float3>{{-0.4f, -0.3f, -0.2f}, {0.3f, 0.4f, 0.35f}},
        {{0.2f, -2, -2}, {2, 0.1f, 2}},
        {{-2, 0.1f, -0.3f}, {0.1f, 2, 2}}}) {
    for (const bool three : {false, true}) {
      SdfRun run(gpu(), mesh, {.cellSize = 0.05f, .threeAxes = three, .box = box});
      run.build();
      const SdfErrors errors = errorsOf(run, trueDistances(run, mesh));
      expectRightBand(errors);
    }
  }
}

TEST_P(SdfBuild, DefectsOfTheMeshChangeNothing) {
  const TriangleMesh clean = blob(20, 30);
  SdfRun expected(gpu(), clean, {.cellSize = 0.07f});
  expected.build();
  const TriangleMesh defects[] = {withNaN(clean), unwelded(clean), withZeroArea(clean, 7),
                                  withDuplicates(clean, 5)};
  for (const TriangleMesh& mesh : defects) {
    SdfRun run(gpu(), mesh, {.cellSize = 0.07f, .box = clean.positions});
    run.build();
    const SdfErrors errors = errorsOf(run, trueDistances(run, clean));
    expectRight(errors, std::to_string(&mesh - defects));
    ASSERT_EQ(run.nodeCount(), expected.nodeCount());
    uint64_t different = 0;
    for (uint64_t i = 0; i < run.nodeCount(); ++i)
      if (run.isInside(i) != expected.isInside(i) ||
          std::abs(run.distance(i) - expected.distance(i)) > 2e-4)
        ++different;
    EXPECT_EQ(different, 0u);
  }
}

TEST_P(SdfBuild, VerticesThatBecomeNaNTakeTheirTrianglesAway) {
  const TriangleMesh mesh = sphere(1, 16, 24);
  SdfRun run(gpu(), mesh, {.cellSize = 0.1f});
  for (const Float3 bad : {Float3{kNan, 0, 0}, {0, kInf, 0}, {0, 0, 3e38f}}) {
    std::vector<Float3> positions = mesh.positions;
    positions[40] = bad;
    run.move(positions);
    run.build();
    const std::vector<Uint4> surface = run.surface->read();
    uint32_t without = 0;
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      const bool touched = mesh.indices[3 * t] == 40 || mesh.indices[3 * t + 1] == 40 ||
                           mesh.indices[3 * t + 2] == 40;
      const float x = std::bit_cast<float>(surface[4 * t].x);
      EXPECT_TRUE(std::isfinite(x));
      EXPECT_EQ(x == 1e18f, touched) << t;
      if (touched) ++without;
    }
    EXPECT_GE(without, 4u);
    for (uint64_t i = 0; i < run.nodeCount(); ++i) {
      if (!run.isSet(i)) continue;
      const uint32_t t = run.triangle(i);
      ASSERT_LT(t, mesh.triangleCount());
      ASSERT_NE(std::bit_cast<float>(surface[4 * t].x), 1e18f) << "node " << i;
    }
  }
}

TEST_P(SdfBuild, AnEmptyMeshIsOutsideEverywhere) {
  SdfRun run(gpu(), {}, {.cellSize = 0.1f, .firstKey = 32});
  run.build();
  for (uint64_t i = 0; i < run.nodeCount(); ++i) EXPECT_EQ(run.key(i), 0x7fffffffu);
}

TEST_P(SdfBuild, KeysOfOtherFieldsStay) {
  SdfRun run(gpu(), cube(1), {.cellSize = 0.1f, .firstKey = 96});
  run.build();
  for (uint32_t i = 0; i < 96; ++i) EXPECT_EQ(run.allKeys()[i], 0x12345678u);
  expectRight(errorsOf(run, trueDistances(run, cube(1))), "cube");
}

TEST_P(SdfBuild, PlaceAndScaleInTheWorldDoNotMatter) {
  const TriangleMesh shape = torus(1, 0.35f, 40, 16);
  for (const Float3 offset : {Float3{1e4f, -1e4f, 1e4f}, {-3e3f, 20, 7}}) {
    const TriangleMesh mesh = moved(shape, offset);
    SdfRun run(gpu(), mesh, {.cellSize = 0.1f});
    run.build();
    // The vertices themselves are rounded; the surface is no longer smooth, but the same for both.
    expectRight(errorsOf(run, trueDistances(run, mesh)), "offset");
  }
  for (const float scale : {1e-3f, 1e-2f, 10.0f, 1e3f}) {
    const TriangleMesh mesh = scaled(shape, scale);
    SdfRun run(gpu(), mesh, {.cellSize = 0.09f * scale});
    run.build();
    expectRight(errorsOf(run, trueDistances(run, mesh)), "scale " + std::to_string(scale));
  }
}

TEST_P(SdfBuild, RecordsHaveVerticesNeighboursAndAngleWeightedNormals) {
  const TriangleMesh mesh =
      rotated(joined(blob(14, 20), moved(cube(0.7f), {2, 0.3f, 0})), {1, 2, 3}, 0.4f);
  SdfRun run(gpu(), mesh, {.cellSize = 0.1f, .motion = true});
  run.build();
  const detail::SdfGridPlan& plan = run.def.plan;
  const auto topology = required(detail::makeColliderTopology(
      mesh.indices, static_cast<uint32_t>(mesh.positions.size()), mesh.positions));
  std::vector<Vector3d> normals(topology->pointCount(), Vector3d::Zero());
  const auto at = [&](uint32_t corner) {
    const Float3& p = mesh.positions[topology->indices[corner]];
    return Vector3d(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
  };
  for (uint32_t c = 0; c < topology->indices.size(); ++c) {
    const uint32_t first = c / 3 * 3;
    const Vector3d a = (at(first + (c + 1) % 3) - at(c)).normalized();
    const Vector3d b = (at(first + (c + 2) % 3) - at(c)).normalized();
    normals[topology->weldedVertices[topology->indices[c]]] +=
        a.cross(b).normalized() * std::acos(std::clamp(a.dot(b), -1.0, 1.0));
  }
  const std::vector<Uint4> surface = run.surface->read();
  const Vector3d origin = {static_cast<double>(plan.origin.x), static_cast<double>(plan.origin.y),
                           static_cast<double>(plan.origin.z)};
  double worst = 0;
  for (uint32_t t = 0; t < topology->triangleCount(); ++t) {
    for (uint32_t k = 0; k < 3; ++k) {
      const Uint4 row = surface[7 * t + k];
      const Vector3d expected = (at(3 * t + k) - origin) / static_cast<double>(plan.cellSize);
      const Vector3d got = {static_cast<double>(std::bit_cast<float>(row.x)),
                            static_cast<double>(std::bit_cast<float>(row.y)),
                            static_cast<double>(std::bit_cast<float>(row.z))};
      EXPECT_LT((got - expected).norm(), 1e-5);
      const double u = static_cast<double>(row.w & 0xffffu) / 32767 - 1;
      const double v = static_cast<double>(row.w >> 16) / 32767 - 1;
      const double w = 1 - std::abs(u) - std::abs(v);
      Vector3d normal = {u, v, w};
      if (w < 0) {
        normal.x() = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
        normal.y() = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
      }
      const Vector3d reference =
          normals[topology->weldedVertices[topology->indices[3 * t + k]]].normalized();
      keepLargest(worst, (normal.normalized() - reference).norm());
      EXPECT_EQ(surface[7 * t + 4 + k], (Uint4{0, 0, 0, 0})) << "no motion in the first build";
    }
    const Uint4 around = surface[7 * t + 3];
    EXPECT_EQ(around, (Uint4{topology->adjacency[3 * t], topology->adjacency[3 * t + 1],
                             topology->adjacency[3 * t + 2], 0}));
  }
  EXPECT_LT(worst, 2e-4) << "[rad], 0.01 degrees";
}

INSTANTIATE_TEST_SUITE_P(Apis, SdfBuild, testing::ValuesIn(kApis), apiTestName);

TEST(SdfBuildBits, AreTheSameOnEveryApi) {
  const TriangleMesh mesh = joined(blob(24, 36), moved(cube(3), {4, 0, 0}));
  for (const bool three : {false, true}) {
    std::vector<uint32_t> keys;
    std::vector<Uint4> surface;
    int runs = 0;
    for (Gpu* gpu : startedGpus()) {
      for (int turn = 0; turn < 2; ++turn) {
        SdfRun run(*gpu, mesh, {.cellSize = 0.07f, .threeAxes = three});
        run.build();
        EXPECT_GT(run.counters().bigTriangles, 0u);
        if (runs++ == 0) {
          keys = run.keys->read();
          surface = run.surface->read();
        }
        EXPECT_TRUE(run.keys->read() == keys) << apiName(gpu->api());
        EXPECT_TRUE(run.surface->read() == surface) << apiName(gpu->api());
      }
    }
    if (runs == 0) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  }
}

TEST(SdfBuildBits, AreTheSameForEveryOrderOfTriangles) {
  const TriangleMesh mesh = blob(24, 36);
  for (Gpu* gpu : startedGpus()) {
    SdfRun expected(*gpu, mesh, {.cellSize = 0.07f});
    expected.build();
    for (uint64_t seed = 1; seed < 4; ++seed) {
      SdfRun run(*gpu, shuffled(mesh, seed), {.cellSize = 0.07f});
      run.build();
      EXPECT_TRUE(run.counts->read() == expected.counts->read()) << apiName(gpu->api());
      uint64_t different = 0;
      for (uint64_t i = 0; i < run.nodeCount(); ++i) {
        // Keys but for the numbers of triangles. Where those of the interior begin depends on ties.
        const uint32_t change = (run.key(i) ^ expected.key(i)) >> run.def.plan.triangleBits;
        if (change != 0 && !run.isFar(i)) ++different;
        if (run.isFar(i) != expected.isFar(i)) ++different;
      }
      EXPECT_EQ(different, 0u) << apiName(gpu->api());
    }
  }
}

}  // namespace
}  // namespace pelage::test
