// Odd mesh colliders: without area, larger than their grid, overlapping, coming and going; grids
// over the memory cap; and fields of meshes that do what no mesh should.
#include "sdf/sdf_run.h"
#include "stress/sdf_stress.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

class SdfOdd : public SdfStress {};

TEST_P(SdfOdd, OddCollidersAreSurvived) {
  const HairAsset asset = comb();
  settings_.globalStiffness = 0.02f;
  std::vector<Location> sites;
  const auto at = [&](const std::string& name, const TriangleMesh& mesh, SdfColliderDef def) {
    Location site{name, mesh};
    site.at.z = kSpacing * static_cast<float>(sites.size() + 1);
    addHair(site, asset, settings_);
    def.name = name;
    def.cellSize = kCell;
    if (def.vertices != BufferId::kInvalid) {
      std::vector<float> floats;
      for (const Float3& p : mesh.positions)
        floats.insert(floats.end(), {p.x + site.at.x, p.y + site.at.y, p.z + site.at.z});
      def.vertices = run_.add("engine", floats);
    }
    // The grid of an engine's vertices is that of their bounds, which are given later.
    site.collider =
        add(def.vertices != BufferId::kInvalid ? reference::scaled(mesh, 1e-3f) : mesh, def);
    setBones(site, {});
    sites.push_back(site);
    return sites.size() - 1;
  };
  const auto bounds = [&](size_t i, const Float3& low, const Float3& high) {
    colliderOf(sites[i]).setVertexBounds(plus(sites[i].at, low), plus(sites[i].at, high));
  };
  const SdfColliderDef engine = {.vertices = static_cast<BufferId>(1)};
  const size_t plain = at("plain", block(), {});
  const size_t points =
      at("points", {{{0, 0.08f, 0}, {0, 0.08f, 0}, {0, 0.08f, 0}}, {0, 1, 2}}, {});
  // Its top is two triangles of 70 m, of which the grid has a quarter of a metre.
  const size_t giant = at("giant", reference::box({-50, -100, -50}, {50, 0.0717f, 50}), engine);
  bounds(giant, {-0.15f, -0.05f, -0.05f}, {0.2f, 0.1f, 0.05f});
  const size_t triangle =
      at("one triangle", {{{-40, 0.0717f, -40}, {0, 0.0717f, 80}, {40, 0.0717f, -40}}, {0, 1, 2}},
         engine);
  bounds(triangle, {-0.15f, 0, -0.05f}, {0.2f, 0.1f, 0.05f});
  // The mesh leaves its grid on all sides but the one that the hair lies on.
  const size_t cut = at("too small bounds", block(), engine);
  bounds(cut, {-0.05f, 0.02f, -0.05f}, {0.05f, 0.09f, 0.05f});
  const size_t overlap =
      at("overlapping parts",
         reference::joined(block(), reference::moved(block(), {0.05f, -0.013f, 0.02f})), {});
  const size_t two = at("two colliders", block(), {});
  const ColliderId second = add(block(), {.name = "second", .cellSize = kCell});
  setBone(run_.scene.collider(second), boneAt(plus(sites[two].at, {0.061f, -0.006f, 0.013f})));
  at("holes", reference::sphereWithHoles(0.075f, 14, 20, 17), {});
  const size_t guest = at("comes and goes", block(), {});
  double deepest = 0, fallen = 0;
  for (int frame = 0; frame < 45; ++frame) {
    // In the middle of its hair's fall, and before others in the list.
    if (frame == 20) {
      remove(sites[guest].collider);
      sites[guest].collider = ColliderId::kInvalid;
    }
    if (frame == 30) {
      sites[guest].collider = add(block(), {.name = "guest", .cellSize = kCell});
      setBones(sites[guest], {});
    }
    if (frame == 35) bounds(cut, {kNan, 0, 0}, {kInf, 1, 1});
    run_.step();
    for (const Location& site : sites) expectSane(asset, site, "frame " + std::to_string(frame));
    if (HasFatalFailure()) return;
    if (frame == 29) {
      // As without it.
      for (const Float4& p : run_.positions(hairOf(sites[guest])))
        keepLargest(fallen, 0.08 - double{p.y});
    }
    for (const size_t i : {plain, giant, overlap, two, guest}) {
      if (i == guest && frame >= 20 && frame < 32) continue;
      const double deep = depth(sites[i], reference::moved(sites[i].mesh, sites[i].at));
      EXPECT_LT(deep, 0.02 * double{kCell}) << sites[i].name << ", frame " << frame;
      keepLargest(deepest, deep);
    }
  }
  // Points leave nothing for hair to lie on.
  const auto tipOf = [&](size_t i) { return double{run_.positions(hairOf(sites[i])).back().y}; };
  EXPECT_LT(tipOf(points), 0.05);
  EXPECT_GT(tipOf(triangle), tipOf(points) + 0.01);
  EXPECT_GT(fallen, 0.02);
  const std::vector<SdfData> sdf = copySdfs({sites[points]});
  for (const uint32_t key : sdf[0].keys) ASSERT_EQ(key, 0x7fffffffu);
  printFigure("odd colliders, " + label() + ": deepest [cell]", deepest / double{kCell});
  printFigure("  largest stretch [%]", 100 * worstStretch_);
}

TEST_P(SdfOdd, AGridOverTheCapRefusesTheFrameAndLosesNothing) {
  const HairAsset asset = comb();
  Location site{"capped", block()};
  addHair(site, asset, settings_);
  site.collider = add(site.mesh, {.name = "capped", .cellSize = kCell});
  setBones(site, {});
  run_.step();
  const uint64_t tight = colliderOf(site).memoryBytes();
  remove(site.collider);
  site.collider =
      add(site.mesh, {.name = "capped", .cellSize = kCell, .memoryCap = tight + tight / 8});
  for (int i = 0; i < 20; ++i) {
    // There is no room for a larger grid, but for one that goes with it.
    setBones(site, {0, 0, 0.05f * static_cast<float>(i % 4)});
    run_.step();
    ASSERT_LE(colliderOf(site).memoryBytes(), tight + tight / 8);
  }
  const std::vector<Float4> before = run_.positions(hairOf(site));
  const std::vector<SdfData> sdf = copySdfs({site});
  setBones(site, {0, 0, 0.15f}, {3, 3, 3});
  PassList list;
  expectError(run_.scene.simulate(1.0f / 60, list), {"'capped'", "fits"});
  EXPECT_TRUE(list.passes.empty());
  EXPECT_EQ(run_.positions(hairOf(site)), before);
  EXPECT_TRUE(copySdfs({site})[0] == sdf[0]);
  setBones(site, {0, 0, 0.15f});
  run_.step();
  expectSane(asset, site, "after it");
  EXPECT_TRUE(copySdfs({site})[0] == sdf[0]);
}

INSTANTIATE_TEST_SUITE_P(All, SdfOdd, testing::ValuesIn(solversOnApis()), solverTestName);

// ---- the field itself

class SdfTableStress : public GpuTest {};

TEST_P(SdfTableStress, WhatAMeshDoesIsBuiltAsFromScratch) {
  // One mesh that is closed and one that is not, in a grid for their first shape. They leave it,
  // grow ten times, go 16 cells a step, are mirrored and flattened, and come back.
  // The sanitizers do not see into the kernels: fewer nodes for them.
  const float cell = kSanitized ? 0.18f : 0.09f;
  for (const TriangleMesh& mesh :
       {reference::blob(14, 20), reference::sphereWithHoles(0.8f, 12, 18, 31)}) {
    const bool open = !DistanceOracle(mesh).isClosed();
    SdfOptions options{.cellSize = cell, .threeAxes = open};
    options.box = mesh.positions;
    SdfRun run(gpu(), mesh, options), fresh(gpu(), mesh, options);
    run.build();
    const std::vector<uint32_t> first = run.keys->read();
    const std::vector<AffineTransform> steps = {boneAt({16 * cell, 0, 0}),
                                                boneAt({0, -16 * cell, 0}),
                                                boneAt({}, {10, 10, 10}),
                                                boneAt({0.5f, 8.1f, 0}, {10, 10, 10}),
                                                boneAt({}, {1, 1, 1}),
                                                boneAt({}, {-1, 1, 1}),
                                                boneAt({}, {0, 0, 0}),
                                                boneAt({}, {1, 0, 1}),
                                                boneAt({kNan, 0, 0}),
                                                boneAt({0, kInf, 0}, {kInf, 1, 1}),
                                                boneAt({1e6f, 0, 0}, {1e5f, 1, 1}),
                                                boneAt({}, {1, 1, 1})};
    for (size_t i = 0; i < steps.size(); ++i) {
      std::vector<Float3> positions = posed(mesh, steps[i]).positions;
      if (i == 4) positions[7] = {30, -20, 25};  // a fan of triangles larger than the grid
      run.move(positions);
      run.build(detail::SdfBuildMode::kIncremental);
      fresh.move(positions);
      fresh.build();
      EXPECT_TRUE(run.keys->read() == fresh.keys->read()) << "step " << i;
      EXPECT_TRUE(run.counts->read() == fresh.counts->read()) << "step " << i;
      const detail::SdfBuildCounters counters = run.counters();
      EXPECT_LE(counters.bigTriangles, mesh.triangleCount());
      EXPECT_LE(counters.interiorNodes, run.nodeCount());
      EXPECT_LE(counters.movedPoints, mesh.positions.size());
      EXPECT_LE(counters.movedTriangles, mesh.triangleCount());
      if (!open && (i < 5)) {
        TriangleMesh now = mesh;
        now.positions = positions;
        EXPECT_EQ(errorsOf(run, trueDistances(run, now)).wrongSigns, 0u) << "step " << i;
      }
    }
    EXPECT_TRUE(run.keys->read() == first) << "back where it was";
  }
}

INSTANTIATE_TEST_SUITE_P(All, SdfTableStress, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
