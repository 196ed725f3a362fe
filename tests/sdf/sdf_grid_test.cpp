// The grid of a distance field, before any GPU.
#include "sdf/sdf_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sdf/sdf_build.h"
#include "support/errors.h"
#include "support/not_numbers.h"

namespace pelage::detail {
namespace {

using test::kNan;
using test::required;

SdfGridDef bodyDef() {
  return {.lowest = {-0.5f, 0, -0.2f},
          .highest = {0.5f, 1.8f, 0.25f},
          .cellSize = 0.02f,
          .triangleCount = 25814};
}

double at(const Float3& p, int axis) {
  return static_cast<double>(axis == 0 ? p.x : axis == 1 ? p.y : p.z);
}

TEST(SdfGrid, HasRoomForTheBandOnEveryAxisByItself) {
  for (const float band : {1.0f, 2.0f, 3.5f}) {
    SdfGridDef def = bodyDef();
    def.band = band;
    const auto plan = required(planSdfGrid(def));
    const double cell = static_cast<double>(def.cellSize);
    for (int axis = 0; axis < 3; ++axis) {
      const double before = (at(def.lowest, axis) - at(plan->origin, axis)) / cell;
      const double last = at(plan->origin, axis) + (plan->nodes[axis] - 1) * cell;
      const double behind = (last - at(def.highest, axis)) / cell;
      EXPECT_GE(before, static_cast<double>(band) + 1 - 1e-4);
      EXPECT_LT(before, static_cast<double>(band) + 2 + 1e-4);
      EXPECT_GE(behind, static_cast<double>(band) + 1 - 1e-4);
      EXPECT_LT(behind, static_cast<double>(band) + 2 + (axis == 0 ? 3 : 0) + 1e-4);
    }
    EXPECT_EQ(plan->nodes[0] % 4, 0u);
  }
}

TEST(SdfGrid, NodesStayInPlaceWhenTheMeshMovesALittle) {
  SdfGridDef def = bodyDef();
  def.cellSize = 0.03125f;  // exact multiples
  const auto plan = planSdfGrid(def);
  def.lowest.x += 0.01f;
  def.highest.x += 0.01f;
  def.lowest.y += 100;
  def.highest.y += 100;
  const auto moved = planSdfGrid(def);
  ASSERT_TRUE(plan.ok() && moved.ok());
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = (at(moved->origin, axis) - at(plan->origin, axis)) / 0.03125;
    EXPECT_EQ(steps, std::round(steps));
  }
  EXPECT_EQ(moved->origin.z, plan->origin.z);
}

TEST(SdfGrid, KeysHaveBitsForEveryTriangle) {
  for (const auto& [count, bits] : {std::pair(0u, 1u),
                                    {1u, 1u},
                                    {2u, 2u},
                                    {16383u, 14u},
                                    {16384u, 15u},
                                    {(1u << 20) - 1, 20u}}) {
    SdfGridDef def = bodyDef();
    def.triangleCount = count;
    const auto plan = required(planSdfGrid(def));
    EXPECT_EQ(plan->triangleBits, bits) << count;
    EXPECT_GT(1u << plan->triangleBits, count);
  }
}

TEST(SdfGrid, TheErrorNamesACellSizeThatFits) {
  SdfGridDef def = bodyDef();
  def.memoryCap = 200'000;
  const auto plan = planSdfGrid(def);
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.error().message.find("the cap is 200000"), std::string::npos);
  const size_t where = plan.error().message.find("a cell size of ");
  ASSERT_NE(where, std::string::npos) << plan.error().message;
  const float fitting = std::stof(plan.error().message.substr(where + 15));
  def.cellSize = 1.001f * fitting;  // the message is rounded
  const auto second = required(planSdfGrid(def));
  EXPECT_LE(second->bytes, def.memoryCap);
  def.cellSize = 0.95f * fitting;
  EXPECT_FALSE(planSdfGrid(def).ok()) << "and no much smaller one does";
}

TEST(SdfGrid, RefusesTooManyNodesWhateverTheCap) {
  SdfGridDef def = bodyDef();
  def.memoryCap = std::numeric_limits<uint64_t>::max();
  def.cellSize = 5e-4f;
  test::expectError(planSdfGrid(def), "1073741824");
  def = bodyDef();
  def.highest.y = 2000;
  EXPECT_FALSE(planSdfGrid(def).ok()) << "100,000 nodes on one axis";
  def.cellSize = 1e-30f;
  EXPECT_FALSE(planSdfGrid(def).ok());
}

TEST(SdfGrid, RefusesWhatIsOutOfRange) {
  const auto refuses = [](auto change) {
    SdfGridDef def = bodyDef();
    change(def);
    return !planSdfGrid(def).ok();
  };
  EXPECT_TRUE(refuses([&](SdfGridDef& def) { def.lowest.x = kNan; }));
  EXPECT_TRUE(refuses([](SdfGridDef& def) { def.cellSize = 0; }));
  EXPECT_TRUE(refuses([&](SdfGridDef& def) { def.cellSize = kNan; }));
  EXPECT_TRUE(refuses([](SdfGridDef& def) { def.band = 0.5f; }));
  EXPECT_TRUE(refuses([](SdfGridDef& def) { def.band = 17; }));
  EXPECT_TRUE(refuses([](SdfGridDef& def) { def.triangleCount = 1u << 20; }));
}

TEST(SdfGrid, AnEmptyMeshHasASmallGrid) {
  SdfGridDef def = {.lowest = {1, 1, 1}, .highest = {-1, -1, -1}, .cellSize = 0.1f};
  const auto plan = required(planSdfGrid(def));
  EXPECT_LE(plan->nodeCount(), 1000u);
}

TEST(SdfGrid, WhatStaysOfAFieldIsFiveBytesANode) {
  const auto plan = required(planSdfGrid(bodyDef()));
  SdfBuildDef def;
  def.plan = *plan;
  def.triangleCount = 25814;
  def.pointCount = 12909;
  const SdfBufferSizes sizes = sdfBufferSizes(def);
  EXPECT_EQ(sizes.keys + sizes.counts, 5 * plan->nodeCount());
  EXPECT_EQ(sizes.keys + sizes.counts, plan->bytes);
  EXPECT_EQ(sizes.votes, 0u);
}

// One buffer for all that a list names.
SdfBuildBuffers anyBuffers(ResourceTable& resources) {
  const BufferId any = resources.add(
      {.name = "any",
       .size = 64,
       .stride = 4,
       .usage = BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload});
  return {any, any, any, any, any, any, any, any, any, any, any, any, any};
}

// Every dispatch is within 65,535 groups an axis, however large the field is.
TEST(SdfGrid, DispatchesOfTheLargestFieldsAreWithinTheLimits) {
  ResourceTable resources;
  const SdfBuildBuffers buffers = anyBuffers(resources);
  SdfBuildDef def;
  def.plan.cellSize = 1;
  def.plan.band = 2;
  def.plan.triangleBits = 20;
  def.triangleCount = (1u << 20) - 1;
  def.pointCount = 3 * def.triangleCount;
  for (const bool three : {false, true}) {
    def.plan.threeAxes = three;
    for (const auto& [x, y, z] : {std::tuple(1024u, 1024u, 1023u), {4u, 59999u, 4000u}}) {
      def.plan.nodes[0] = x;
      def.plan.nodes[1] = y;
      def.plan.nodes[2] = z;
      PassList list;
      SdfBuildState state;
      ASSERT_TRUE(addSdfBuild(list, resources, buffers, def, SdfBuildMode::kFull, state).ok());
      EXPECT_GT(list.passes.size(), 6u);
      for (const Pass& pass : list.passes)
        for (const uint32_t groups : pass.groups) EXPECT_LE(groups, 65535u) << pass.name;
    }
  }
}

TEST(SdfGrid, AnIncrementalBuildStartsAllButTheFirstPassOnTheGpu) {
  ResourceTable resources;
  const SdfBuildBuffers buffers = anyBuffers(resources);
  SdfBuildDef def;
  def.plan = *planSdfGrid(bodyDef());
  def.triangleCount = 25814;
  def.pointCount = 12909;
  SdfBuildState state;
  for (int i = 0; i < 2; ++i) {
    PassList list;
    ASSERT_TRUE(addSdfBuild(list, resources, buffers, def, SdfBuildMode::kIncremental, state).ok());
    size_t direct = 0;
    for (const Pass& pass : list.passes) direct += pass.kind == PassKind::kDispatch ? 1 : 0;
    EXPECT_EQ(direct == 1, i == 1) << direct << " passes; the first build is a full one";
    const auto dispatches =
        std::count_if(list.passes.begin(), list.passes.end(), [](const Pass& p) {
          return p.kind == PassKind::kDispatch || p.kind == PassKind::kDispatchIndirect;
        });
    EXPECT_EQ(dispatches, 7) << "however large the grid is";
  }
}

}  // namespace
}  // namespace pelage::detail
