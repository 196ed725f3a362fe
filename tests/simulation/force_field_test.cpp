// Fields of forces that an engine has on the GPU.
#include <gtest/gtest.h>

#include <iterator>
#include <limits>
#include <vector>

#include "stress/stress_run.h"
#include "support/engine_buffer.h"
#include "support/not_numbers.h"
#include "support/scene_list_test.h"

namespace pelage::test {
namespace {

/// A field and its buffer.
class Field {
 public:
  Field(SceneRun& run, std::array<uint32_t, 3> nodes, Float3 origin, float cellSize,
        uint32_t first = 0)
      : field{.first = first, .origin = origin, .cellSize = cellSize, .nodes = nodes},
        buffer_(run, "field", 4 * (first + nodes[0] * nodes[1] * nodes[2])) {
    field.values = buffer_.id();
  }
  template <class Value>
  void write(const Value& valueAt) {
    std::vector<float> floats(size_t{4} * field.first, kNan);
    for (uint32_t z = 0; z < field.nodes[2]; ++z) {
      for (uint32_t y = 0; y < field.nodes[1]; ++y) {
        for (uint32_t x = 0; x < field.nodes[0]; ++x) {
          const Vector3d at(field.origin.x + field.cellSize * static_cast<float>(x),
                            field.origin.y + field.cellSize * static_cast<float>(y),
                            field.origin.z + field.cellSize * static_cast<float>(z));
          const Float4 value = valueAt(at);
          floats.insert(floats.end(), {value.x, value.y, value.z, value.w});
        }
      }
    }
    buffer_.write(floats);
  }
  ForceField field;

 private:
  EngineBuffer buffer_;
};

class ForceFieldTest : public SolverTest {
 protected:
  ForceFieldTest() : asset_(wavyAsset(30, 10)) {
    // The solvers do different things with a drag of the settings and with one of forces.
    settings_.damping = 0;
    settings_.airDrag = 0;
    settings_.wind = {};
    settings_.sleep.enabled = false;
  }
  HairObject& add(const char* name, const SimulationSettings& settings) {
    return run_.add(asset_, {.name = name, .settings = settings});
  }

  HairAsset asset_;
};

TEST_P(ForceFieldTest, OneValueEverywhereIsABufferOfForcesToTheBit) {
  const Float4 value = {2, -9.81f, 1, 0.75f};
  settings_.gravity = {};
  Field field(run_, {5, 6, 7}, {-2, -2, -2}, 0.8f, 3);
  field.write([&](const Vector3d&) { return value; });
  EngineBuffer forces(run_, "forces", uint64_t{4} * asset_.positions.size());
  std::vector<float> floats;
  for (size_t i = 0; i < asset_.positions.size(); ++i)
    floats.insert(floats.end(), {value.x, value.y, value.z, value.w});
  forces.write(floats);
  HairObject& expected = add("expected", settings_);
  HairObject& hair = add("hair", settings_);
  HairObject& both = add("both", settings_);
  // In the frame of a reset a field does not act.
  run_.step();
  expected.setForces(forces.id());
  hair.setForceField(field.field);
  for (int frame = 0; frame < 20; ++frame) {
    run_.step();
    EXPECT_EQ(countPasses(run_.list(), "sample_force_field"), 1u);
    EXPECT_EQ(maxDistance(run_.positions(expected), run_.positions(hair)), 0) << "frame " << frame;
  }
  // Both together are the sum.
  EngineBuffer halfForces(run_, "halfForces", floats.size());
  std::vector<float> half;
  for (const float f : floats) half.push_back(0.5f * f);
  halfForces.write(half);
  field.write([&](const Vector3d&) {
    return Float4{0.5f * value.x, 0.5f * value.y, 0.5f * value.z, 0.5f * value.w};
  });
  expected.setForces(BufferId::kInvalid);
  expected.reset();
  both.reset();
  run_.step();
  expected.setForces(forces.id());
  both.setForces(halfForces.id());
  both.setForceField(field.field);
  for (int frame = 0; frame < 5; ++frame) {
    run_.step();
    EXPECT_EQ(maxDistance(run_.positions(expected), run_.positions(both)), 0) << "frame " << frame;
  }
}

TEST_P(ForceFieldTest, ValuesAreInterpolatedAndEndWithTheGrid) {
  settings_.gravity = {};
  settings_.bendLength = 0;
  settings_.localStiffness = 0;
  // Straight strands of two edges; the last vertex swings, from rest: h^2 a, or 4/9 of it. Where
  // that one is: in all parts of the grid, and beyond each of its sides.
  const Vector3d low(-0.2, 0.15, -0.3), high = low + 0.35 * Vector3d(2, 3, 4);
  const Vector3d ends[] = {{0, 0.4, 0},      {0.3, 0.7, 0.45},  {-0.15, 1.15, 1.05},
                           {0.45, 0.2, 0.9}, {0.4, 1.1, -0.25}, {-0.3, 0.5, 0},
                           {0.6, 0.5, 0},    {0, 0.1, 0},       {0, 1.25, 0},
                           {0, 0.5, -0.4},   {0, 0.5, 1.2}};
  const HairAsset asset =
      strandsAt(static_cast<uint32_t>(std::size(ends)), 3, [&](uint32_t s, uint32_t v) {
        return toFloat3(ends[s] + Vector3d(0.01 * (int(v) - 2), 0, 0));
      });
  HairObject& hair = run_.add(asset, {.name = "hair", .settings = settings_});
  run_.step();
  const auto before = run_.positions(hair);
  Field field(run_, {3, 4, 5}, {-0.2f, 0.15f, -0.3f}, 0.35f, 2);
  const auto valueAt = [](const Vector3d& at) {
    return 0.5 + 0.75 * at.x() + at.y() - 0.4 * at.z();
  };
  field.write([&](const Vector3d& at) { return Float4{0, 0, static_cast<float>(valueAt(at)), 0}; });
  hair.setForceField(field.field);
  run_.step();
  const auto p = run_.positions(hair);
  const double share = exact() ? 2.0 / 3 : 1;
  for (size_t s = 0; s < std::size(ends); ++s) {
    const bool inside = (ends[s] - low).minCoeff() > 0 && (high - ends[s]).minCoeff() > 0;
    EXPECT_EQ(inside, s < 5);
    const double expected = inside ? valueAt(ends[s]) / 3600 * share * share : 0;
    EXPECT_NEAR(double{p[3 * s + 2].z} - double{before[3 * s + 2].z}, expected,
                0.02 * expected + 2e-7)
        << "strand " << s;
  }
}

TEST_P(ForceFieldTest, WhatIsNoNumberActsOnNothing) {
  Field field(run_, {3, 3, 3}, {-1, -1, -1}, 1);
  int node = 0;
  field.write([&](const Vector3d&) {
    ++node;
    return node % 3 == 0   ? Float4{kNan, 0, 0, 0}
           : node % 3 == 1 ? Float4{0, 0, 0, -1}
                           : Float4{0, std::numeric_limits<float>::infinity(), 0, 0};
  });
  HairObject& expected = add("expected", settings_);
  HairObject& hair = add("hair", settings_);
  hair.setForceField(field.field);
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_TRUE(allFinite(run_.positions(hair)));
  EXPECT_LT(maxDistance(run_.positions(expected), run_.positions(hair)), exact() ? 1e-3 : 1e-5);
  // A drag that would speed hair up is none either, whatever else its nodes have.
  field.write([&](const Vector3d&) { return Float4{20, 0, 0, -1}; });
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_LT(maxDistance(run_.positions(expected), run_.positions(hair)), exact() ? 1e-3 : 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Apis, ForceFieldTest, testing::ValuesIn(solversOnApis()), solverTestName);

// ---- without a device

class ForceFieldList : public SceneListTest {
 protected:
  BufferId addField(uint64_t bytes = 128) {
    return scene_.resources().add({.name = "field", .size = bytes, .stride = 16});
  }
};

TEST_F(ForceFieldList, CostsNothingUnused) {
  HairObject& hair = addHair();
  simulate();
  simulate();
  const uint32_t buffers = scene_.resources().count();
  EXPECT_EQ(count("sample_force_field"), 0u);
  hair.setForceField({.values = addField(), .cellSize = 1, .nodes = {2, 2, 2}});
  simulate();
  EXPECT_EQ(count("sample_force_field"), 1u);
  EXPECT_EQ(scene_.resources().count(), buffers + 2);
  hair.setForceField({});
  simulate();
  simulate();
  EXPECT_EQ(count("sample_force_field"), 0u);
  EXPECT_EQ(scene_.resources().count(), buffers + 1) << "the engine's";
}

TEST_F(ForceFieldList, KeepsHairAwake) {
  HairDef def;
  def.settings.sleep.enabled = true;
  def.settings.wind = {};
  HairObject& hair = addHair(def);
  const auto mayBeAsleep = [&] {
    simulate();
    return count("select_awake_tiles") > 0;
  };
  mayBeAsleep();
  EXPECT_TRUE(mayBeAsleep());
  hair.setForceField({.values = addField(), .cellSize = 1, .nodes = {2, 2, 2}});
  EXPECT_FALSE(mayBeAsleep());
  hair.setForceField({});
  EXPECT_TRUE(mayBeAsleep());
}

TEST_F(ForceFieldList, WhatIsWrongIsNamed) {
  HairObject& hair = addHair({.name = "mane"});
  const ForceField good = {.values = addField(127 * 4), .cellSize = 1, .nodes = {2, 2, 2}};
  const auto expectWrong = [&](const ForceField& field, const char* what) {
    hair.setForceField(field);
    expectRefused({"hair 'mane': its force field", what});
  };
  ForceField bad = good;
  bad.cellSize = kNan;
  expectWrong(bad, "cells of nan m");
  bad = good;
  bad.origin.y = kNan;
  expectWrong(bad, "origin that is not finite");
  bad = good;
  bad.nodes = {2, 1, 2};
  expectWrong(bad, "2 x 1 x 2 nodes");
  bad = good;
  bad.nodes = {4, 4, 2};
  expectWrong(bad, "only 508 bytes");
  bad = good;
  bad.first = 24;
  expectWrong(bad, "from element 24 on");
  bad = good;
  bad.values = BufferId{12345};
  expectWrong(bad, "does not exist");
  hair.setForceField(good);
  simulate();
}

}  // namespace
}  // namespace pelage::test
