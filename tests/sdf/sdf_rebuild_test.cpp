// Signed distance fields that are rebuilt where something moved: the same bits as from scratch.
#include <gtest/gtest.h>

#include <bit>
#include <string>

#include "sdf/sdf_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

using detail::SdfBuildMode;
using reference::blob;
using reference::cube;
using reference::joined;
using reference::moved;
using reference::plate;
using reference::sphereWithHoles;

constexpr SdfOptions kOptions = {.cellSize = 0.06f};

TriangleMesh head() { return blob(30, 45); }

/// Room around the mesh, so that what moves stays in the grid.
std::vector<Float3> roomAround(const TriangleMesh& mesh, float room) {
  std::vector<Float3> box = mesh.positions;
  for (size_t i = mesh.positions.size(); i-- > 0;) {
    const Float3 p = box[i];
    box.push_back({p.x - room, p.y - room, p.z - room});
    box.push_back({p.x + room, p.y + room, p.z + room});
  }
  return box;
}

/// Moves vertices right of a plane along z, in proportion to their distance from it.
std::vector<Float3> bent(const TriangleMesh& mesh, float plane, float amount) {
  std::vector<Float3> positions = mesh.positions;
  for (Float3& p : positions)
    if (p.x > plane) p.z += amount * (p.x - plane);
  return positions;
}

void expectSameSdf(SdfRun& run, SdfRun& expected, const std::string& what) {
  EXPECT_TRUE(run.keys->read() == expected.keys->read()) << what;
  EXPECT_TRUE(run.counts->read() == expected.counts->read()) << what;
  EXPECT_TRUE(run.surface->read() == expected.surface->read()) << what;
}

void rebuild(SdfRun& run, const std::vector<Float3>& positions) {
  run.move(positions);
  run.build(SdfBuildMode::kIncremental);
}

bool startedNothing(const SdfRun& run) {
  const std::vector<uint32_t> words = run.words();
  for (size_t i = 0; i < 32; i += 4)
    if (words[i] != 0) return false;
  return true;
}

class SdfRebuild : public GpuTest {
 protected:
  /// Against a field that is built from scratch on the same grid, whose counters it returns.
  detail::SdfBuildCounters expectAsFromScratch(SdfRun& run, const TriangleMesh& mesh,
                                               const SdfOptions& options,
                                               const std::vector<Float3>& positions,
                                               const std::string& what) {
    SdfRun fresh(gpu(), mesh, options);
    fresh.move(positions);
    fresh.build();
    expectSameSdf(run, fresh, what);
    return fresh.counters();
  }
};

TEST_P(SdfRebuild, GivesTheBitsOfAFullBuild) {
  const TriangleMesh mesh = head();
  SdfOptions options = kOptions;
  options.box = roomAround(mesh, 0.3f);
  SdfRun run(gpu(), mesh, options);
  run.build(SdfBuildMode::kIncremental);  // the first one is a full one
  EXPECT_EQ(run.counters().movedTriangles, 0u);
  // A small part, a larger one, all of it, and back.
  const std::pair<float, float> steps[] = {{0.6f, 0.1f},   {0.6f, 0.35f}, {0.2f, 0.3f},
                                           {-3.0f, 0.05f}, {0.5f, -0.2f}, {5.0f, 0.0f}};
  for (const auto& [plane, amount] : steps) {
    const std::vector<Float3> positions = bent(mesh, plane, amount);
    rebuild(run, positions);
    EXPECT_GT(run.counters().movedTriangles, 0u);
    const auto fresh =
        expectAsFromScratch(run, mesh, options, positions, "plane " + std::to_string(plane));
    EXPECT_EQ(run.counters().interiorNodes, fresh.interiorNodes);
  }
}

TEST_P(SdfRebuild, TouchesWhatMovedAndNoMore) {
  const TriangleMesh mesh = head();
  SdfRun run(gpu(), mesh, kOptions);
  run.build();
  const std::vector<Float3> positions = bent(mesh, 0.6f, 0.1f);
  rebuild(run, positions);
  uint32_t points = 0, triangles = 0;
  const auto moved = [&](uint32_t v) { return !(positions[v] == mesh.positions[v]); };
  for (uint32_t v = 0; v < positions.size(); ++v) points += moved(v) ? 1 : 0;
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t)
    triangles += moved(mesh.indices[3 * t]) || moved(mesh.indices[3 * t + 1]) ||
                         moved(mesh.indices[3 * t + 2])
                     ? 1
                     : 0;
  const detail::SdfBuildCounters counters = run.counters();
  EXPECT_GT(points, 20u);
  EXPECT_EQ(counters.movedPoints, points);
  EXPECT_EQ(counters.movedTriangles, triangles);
  EXPECT_GT(counters.clearedBricks, 0u);
  EXPECT_LT(counters.clearedBricks, run.nodeCount() / 64 / 4);
}

TEST_P(SdfRebuild, StartsNothingWhenNothingMoved) {
  const TriangleMesh mesh = head();
  for (const bool three : {false, true}) {
    SdfOptions options = kOptions;
    options.threeAxes = three;
    options.motionTolerance = 0.05f;
    SdfRun run(gpu(), mesh, options);
    run.build();
    const std::vector<uint32_t> keys = run.keys->read();
    run.build(SdfBuildMode::kIncremental);
    EXPECT_TRUE(startedNothing(run));
    // Within the tolerance of 0.05 cells, however often: it counts from where it was built.
    for (const float shift : {0.04f, -0.04f}) {
      std::vector<Float3> positions = mesh.positions;
      for (Float3& p : positions) p.y += shift * options.cellSize;
      rebuild(run, positions);
      EXPECT_TRUE(startedNothing(run)) << shift;
      EXPECT_EQ(run.counters().movedPoints, 0u);
    }
    EXPECT_TRUE(run.keys->read() == keys);
    std::vector<Float3> positions = mesh.positions;
    for (Float3& p : positions) p.y += 0.08f * options.cellSize;
    rebuild(run, positions);
    EXPECT_FALSE(startedNothing(run));
    expectAsFromScratch(run, mesh, options, positions, "beyond the tolerance");
  }
}

TEST_P(SdfRebuild, KnowsOpenMeshesBigTrianglesAndGridsThatAreTooSmall) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
    bool threeAxes;
    std::vector<Float3> box;
  };
  const TriangleMesh large = joined(blob(16, 24), moved(cube(2.2f), {2.5f, 0.2f, 0.1f}));
  const TriangleMesh holes = sphereWithHoles(0.8f, 20, 30, 61);
  for (const Case& c : {Case{"big", large, false, roomAround(large, 0.2f)},
                        Case{"open", holes, true, roomAround(holes, 0.2f)},
                        Case{"cut", large, false, {{0, -0.5f, -0.6f}, {1.8f, 0.9f, 0.5f}}},
                        Case{"thin", plate(2, 0.02f, 8, 0.3f), false, {}}}) {
    SdfOptions options = kOptions;
    options.threeAxes = c.threeAxes;
    options.box = c.box;
    SdfRun run(gpu(), c.mesh, options);
    run.build();
    for (const auto& [plane, amount] : {std::pair(0.4f, 0.2f), {-0.1f, -0.15f}, {0.4f, 0.0f}}) {
      const std::vector<Float3> positions = bent(c.mesh, plane, amount);
      rebuild(run, positions);
      expectAsFromScratch(run, c.mesh, options, positions, c.name);
    }
  }
}

TEST_P(SdfRebuild, SurvivesVerticesThatComeAndGo) {
  const TriangleMesh mesh = head();
  SdfRun run(gpu(), mesh, kOptions);
  run.build();
  std::vector<Float3> broken = mesh.positions;
  broken[100].x = kNan;
  broken[400].z = kInf;
  broken[500] = {1e6f, -1e6f, 0};
  for (const std::vector<Float3>& positions : {broken, mesh.positions, broken}) {
    rebuild(run, positions);
    expectAsFromScratch(run, mesh, kOptions, positions, "broken");
  }
}

TEST_P(SdfRebuild, RecordsHaveTheMotionSinceTheLastBuild) {
  const TriangleMesh mesh = head();
  SdfOptions options = kOptions;
  options.motion = true;
  SdfRun run(gpu(), mesh, options);
  run.build();
  const auto check = [&](float speed, const std::string& what) {
    const std::vector<Uint4> surface = run.surface->read();
    double worst = 0;
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t)
      for (uint32_t k = 0; k < 3; ++k) {
        const Uint4 row = surface[7 * t + 4 + k];
        const float x = mesh.positions[mesh.indices[3 * t + k]].x;
        const float displacement = x > 0.6f ? speed * (x - 0.6f) / options.cellSize : 0;
        keepLargest(worst, static_cast<double>(std::abs(std::bit_cast<float>(row.x))));
        keepLargest(worst,
                    static_cast<double>(std::abs(std::bit_cast<float>(row.z) - displacement)));
      }
    EXPECT_LT(worst, 1e-4) << what << " [cell]";
  };
  rebuild(run, bent(mesh, 0.6f, 0.2f));
  check(0.2f, "moves");
  run.build(SdfBuildMode::kIncremental);
  check(0, "rests");
  run.build(SdfBuildMode::kIncremental);
  EXPECT_TRUE(startedNothing(run)) << "records that rest are not written again";
  check(0, "still rests");
  run.move(bent(mesh, 0.6f, 0.3f));
  run.build();
  check(0.1f, "moves in a full build");
  run.build(SdfBuildMode::kIncremental);
  check(0, "rests after a full build");
}

TEST_P(SdfRebuild, IsAFullBuildWhenTheGridGoesOn) {
  const TriangleMesh mesh = head();
  SdfOptions options = kOptions;
  options.motion = true;
  SdfRun run(gpu(), mesh, options);
  run.build();
  // The grid takes a step of three cells, the mesh one of 0.2.
  const float step = 3 * options.cellSize;
  run.def.plan.origin.x -= step;
  std::vector<Float3> positions = mesh.positions;
  for (Float3& p : positions) p.x -= 0.2f * options.cellSize;
  rebuild(run, positions);
  TriangleMesh now = mesh;
  now.positions = positions;
  const SdfErrors errors = errorsOf(run, trueDistances(run, now));
  EXPECT_EQ(errors.wrongSigns, 0u);
  EXPECT_EQ(errors.missing, 0u);
  EXPECT_LE(errors.band, 5e-5);
  const std::vector<Uint4> surface = run.surface->read();
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t)
    EXPECT_NEAR(std::bit_cast<float>(surface[7 * t + 4].x), -0.2f, 1e-4f);
}

INSTANTIATE_TEST_SUITE_P(Apis, SdfRebuild, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
