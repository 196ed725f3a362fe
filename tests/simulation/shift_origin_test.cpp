// Shifts of the world's origin: hair in a world that is shifted against the same without, with both
// solvers on every API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pelage/demo/groom.h"
#include "pelage/skeleton.h"
#include "reference/sdf/mesh_shapes.h"
#include "support/collision_shapes.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/scene_test.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

using reference::TriangleMesh;

/// Shifts before a frame, in turn.
using Shifts = std::map<int, std::vector<Float3>>;

const Shifts kWholeMetres = {{0, {{3, 0, -2}}},
                             {4, {{8, -3, 1}}},
                             {9, {{-20, 0, 5}, {7, 7, 7}}},
                             {10, {{1, 0, 0}}},
                             {16, {{-2, -9, 30}}}};

/// The state of hair after a frame; positions are in the first world.
struct Snapshot {
  std::vector<Vector3d> positions;
  std::vector<Float4> tangents;
  std::vector<uint32_t> state;  ///< bits
  uint32_t awake = 0;
};
using Story = std::vector<Snapshot>;

/// NaN where something is not a number, and infinite where there is nothing or not as much.
double storyDistance(const Story& a, const Story& b) {
  double largest = a.empty() || a.size() != b.size() ? HUGE_VAL : 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    keepLargest(largest, maxDistance(a[i].positions, b[i].positions));
  return largest;
}

AffineTransform turned(float angle, const Float3& shift) {
  return rigidTransform({0, std::sin(angle / 2), 0, std::cos(angle / 2)}, shift);
}

/// Steps that floats hold exactly up to 65 km from any origin of whole metres.
Float3 onFineGrid(double x, double y, double z) {
  const auto snap = [](double v) { return static_cast<float>(std::round(v * 128) / 128); };
  return {snap(x), snap(y), snap(z)};
}

/// Strands that hang around a ball of 8 cm at the origin without touching it.
HairAsset fringe(uint32_t strands = 40, uint32_t vertices = 12) {
  return strandsAt(strands, vertices, [&](uint32_t s, uint32_t v) {
    const float angle = 2.4f * static_cast<float>(s);
    const float r = 0.09f + 0.03f * static_cast<float>(s) / static_cast<float>(strands);
    const float t = 0.25f * static_cast<float>(v) / static_cast<float>(vertices - 1);
    return Float3{r * std::cos(angle), 0.14f - t, r * std::sin(angle)};
  });
}

class ShiftOrigin : public SolverTest {
 protected:
  ShiftOrigin() {
    if (exact()) return;
    // A breath that moves nothing, as in scene_simulation_test.
    settings_.airDrag = 1e-4f;
    settings_.wind = {.velocity = {0, 0, 1e-4f}, .gustStrength = 0, .strandVariation = 0};
  }
  void TearDown() override {
    end();
    SolverTest::TearDown();
  }

  /// An empty scene in the first world.
  void end() {
    run_.clear();
    // Floats hold what is left after a few rounds.
    for (int round = 0; round < 4; ++round) shift(toFloat3(-moved_));
    EXPECT_EQ(moved_.norm(), 0);
  }
  void shift(const Float3& by) {
    expectOk(run_.scene.shiftOrigin(by));
    moved_ += toVector({by.x, by.y, by.z, 0});
  }
  /// From the first world into the one that there is.
  Float3 here(const Float3& p) const { return toFloat3(toVector({p.x, p.y, p.z, 0}) - moved_); }
  AffineTransform boneHere(AffineTransform bone) const {
    const Float3 p = here({bone.rows[0].w, bone.rows[1].w, bone.rows[2].w});
    bone.rows[0].w = p.x;
    bone.rows[1].w = p.y;
    bone.rows[2].w = p.z;
    return bone;
  }
  template <class Object>
  void setBone(Object& object, const AffineTransform& bone) const {
    test::setBone(object, boneHere(bone));
  }
  CapsuleCollider ballAt(const Float3& p, float radius) const {
    return sphereCollider(here(p), radius);
  }

  std::vector<Vector3d> positions(const HairObject& hair) const {
    std::vector<Vector3d> all;
    for (const Float4& p : run_.positions(hair)) all.push_back(toVector(p) + moved_);
    return all;
  }
  uint32_t awake(const HairObject& hair) const {
    return exact() ? run_.awake(hair) : hair.guideCount();
  }
  Snapshot snapshot(const HairObject& hair) const {
    return {.positions = positions(hair),
            .tangents = run_.read(hair.buffers().tangents),
            .state = run_.read<uint32_t>(hair.buffers().state),
            .awake = awake(hair)};
  }
  /// Steps until everything sleeps.
  void fallAsleep(const HairObject& hair) {
    for (int frame = 0; frame < 900; ++frame) {
      run_.step();
      if (awake(hair) == 0) return;
    }
    ADD_FAILURE() << awake(hair) << " strands did not come to rest";
  }

  /// A scene from its beginning to its end.
  Story tell(int frames, const Shifts& shifts, const std::function<HairObject*()>& begin,
             const std::function<void(int, HairObject&)>& move) {
    Story story;
    HairObject* hair = begin();
    for (int frame = 0; frame < frames; ++frame) {
      if (const auto found = shifts.find(frame); found != shifts.end())
        for (const Float3& by : found->second) shift(by);
      move(frame, *hair);
      run_.step();
      story.push_back(snapshot(*hair));
    }
    end();
    return story;
  }
  /// Without shifts, and with them.
  std::pair<Story, Story> tellBoth(const Shifts& shifts, const std::function<HairObject*()>& begin,
                                   const std::function<void(int, HairObject&)>& move) {
    Story still = tell(24, {}, begin, move);
    return {std::move(still), tell(24, shifts, begin, move)};
  }
  static void expectSameStates(const Story& a, const Story& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_TRUE(a[i].state == b[i].state) << "frame " << i;
      ASSERT_TRUE(a[i].tangents == b[i].tangents) << "frame " << i;
      ASSERT_EQ(a[i].awake, b[i].awake) << "frame " << i;
    }
  }

  /// A ball of 8 cm with a field.
  SdfCollider& addBall() {
    mesh_ = &run_.scene.collider(
        run_.add(toMesh(reference::sphere(0.08f, 12, 16)), {.cellSize = 0.01f}));
    return *mesh_;
  }

  SdfCollider* mesh_ = nullptr;
  Vector3d moved_ = {0, 0, 0};
};

/// A head that walks and turns: far enough for the object's own origin to follow.
AffineTransform walk(int frame) {
  return turned(0.1f * static_cast<float>(frame),
                onFineGrid(0.15 * frame, 0.3 * std::sin(0.5 * frame), 0.2));
}

/// Slow enough for roundings not to grow.
AffineTransform stroll(int frame) {
  return turned(0.02f * static_cast<float>(frame), onFineGrid(0.0078125 * frame, 0, 0.2));
}

TEST_P(ShiftOrigin, StatesKeepTheirBitsWithWholeMetres) {
  const HairAsset asset = wavyAsset(40, 12);
  const auto begin = [&] { return &run_.add(asset, {.settings = settings_}); };
  const auto move = [&](int frame, HairObject& hair) { setBone(hair, walk(frame)); };
  const auto [still, shifted] = tellBoth(kWholeMetres, begin, move);
  expectSameStates(shifted, still);
  EXPECT_LT(storyDistance(shifted, still), 4e-6) << "floats at 30 m";
  Shifts everyFrame;
  for (int frame = 0; frame < 24; ++frame) everyFrame[frame] = {{1, 0, -1}};
  const Story running = tell(24, everyFrame, begin, move);
  expectSameStates(running, still);
  EXPECT_LT(storyDistance(running, still), 4e-6);
}

TEST_P(ShiftOrigin, AFractionOfAMetreIsNotFeltEither) {
  const HairAsset asset = wavyAsset(40, 12);
  const auto begin = [&] { return &run_.add(asset, {.settings = settings_}); };
  const auto move = [&](int frame, HairObject& hair) { setBone(hair, walk(frame)); };
  const Story still = tell(24, {}, begin, move);
  // Where floats hold what an engine passes, fractions are exact, too.
  const Story exactly = tell(
      24, {{0, {{0.25f, 0.75f, -0.125f}}}, {5, {{0.5f, -4.625f, 7.875f}}}, {9, {{0.0625f, 0, 0}}}},
      begin, move);
  expectSameStates(exactly, still);
  EXPECT_LT(storyDistance(exactly, still), 4e-6);
  // Elsewhere bones are rounded anew, by up to 2.4e-7 m here.
  settings_.damping = 0.3f;
  const auto slowly = [&](int frame, HairObject& hair) { setBone(hair, stroll(frame)); };
  const Story slow = tell(24, {}, begin, slowly);
  const Story shifted =
      tell(24, {{0, {{0.3f, 0.7f, -0.1f}}}, {5, {{0.123f, -4.56f, 3.89f}}}, {9, {{1e-3f, 0, 0}}}},
           begin, slowly);
  EXPECT_LT(storyDistance(shifted, slow), 1e-4);
}

TEST_P(ShiftOrigin, CollisionsGoOn) {
  // A mesh and a ball that go into the strands from two sides.
  const HairAsset asset = fringe();
  const auto begin = [&] {
    addBall();
    return &run_.add(asset, {.settings = settings_});
  };
  const auto move = [&](int frame, HairObject& hair) {
    setBone(*mesh_, turned(0.02f * static_cast<float>(frame), onFineGrid(0.002 * frame, 0, 0)));
    setCollider(hair, ballAt(onFineGrid(-0.2 + 0.004 * frame, 0.02, 0.05), 0.05f));
    setBone(hair, {});
  };
  const auto [still, shifted] = tellBoth(kWholeMetres, begin, move);
  // Contacts are found from the outputs, which are rounded differently.
  EXPECT_LT(storyDistance(shifted, still), 1e-4);
  std::vector<Vector3d> bind;
  for (const Float4& p : asset.positions) bind.push_back(toVector(p));
  EXPECT_GT(maxDistance(still.back().positions, bind), 0.02) << "they were touched";
}

TEST_P(ShiftOrigin, StoredFollowHairsMoveAlong) {
  const HairAsset asset = fringe();
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 3, .maxRadius = 0.02f}));
  std::vector<Story> all;
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    const auto begin = [&] {
      addBall();
      return &run_.add(asset, {.settings = settings_,
                               .followHairs = follows,
                               .storeFollowHairs = true,
                               .collidingHair = colliding});
    };
    const auto move = [&](int frame, HairObject& hair) {
      setBone(*mesh_, turned(0.02f * static_cast<float>(frame), {}));
      setBone(hair, {});
    };
    const auto [still, shifted] = tellBoth(kWholeMetres, begin, move);
    all.push_back(still);
    EXPECT_EQ(still.back().positions.size(), 4u * 40 * 12);
    EXPECT_LT(storyDistance(shifted, still), 1e-4)
        << (colliding == CollidingHair::kGuides ? "guides collide" : "all collide");
  }
  EXPECT_GT(storyDistance(all[0], all[1]), 1e-3) << "some collide";
}

// ---- what is between two simulations

TEST_P(ShiftOrigin, APauseShowsHairWhereItIsNow) {
  const HairAsset asset = fringe();
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.02f}));
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    HairObject& hair = run_.add(asset, {.settings = settings_,
                                        .followHairs = follows,
                                        .storeFollowHairs = true,
                                        .collidingHair = colliding});
    hair.visible = false;
    setCollider(hair, ballAt({0.05f, 0, 0}, 0.05f));
    for (int frame = 0; frame < 5; ++frame) run_.step();
    const Snapshot before = snapshot(hair);
    shift({10, -20, 3});
    shift({-2, 1.5f, 0.25f});
    run_.step(0);
    const Snapshot after = snapshot(hair);
    EXPECT_TRUE(after.state == before.state);
    EXPECT_LT(maxDistance(after.tangents, before.tangents), 1e-3) << "those of follow hairs";
    EXPECT_LT(maxDistance(after.positions, before.positions), 4e-6);
    // And does so once.
    run_.step(0);
    EXPECT_EQ(maxDistance(positions(hair), after.positions), 0);
    if (colliding == CollidingHair::kGuidesAndFollows) {
      EXPECT_NE(hair.buffers().followContactWords, BufferId::kInvalid) << "they do collide";
    }
    end();
  }
}

TEST_P(ShiftOrigin, ADrawBeforeTheNextSimulationShowsTheSamePicture) {
  const HairAsset asset = fringe();
  HairObject& hair = run_.add(asset, {.settings = settings_});
  hair.material.fiberRadius = 1e-3f;
  for (int frame = 0; frame < 5; ++frame) run_.step();
  const std::vector<Vector3d> before = positions(hair);
  const RenderedImage expected = run_.render(here({0.03f, 0.1f, 0.6f}), 96);
  shift({8, -4, 16});
  const RenderedImage shown = run_.render(here({0.03f, 0.1f, 0.6f}), 96);
  EXPECT_LT(maxDistance(positions(hair), before), 4e-6);
  double difference = 0, light = 0;
  for (size_t i = 0; i < expected.pixels.size(); ++i) {
    difference += std::abs(static_cast<double>(shown.pixels[i].y - expected.pixels[i].y));
    light += static_cast<double>(expected.pixels[i].w);
  }
  EXPECT_GT(light, 100) << "there is hair";
  EXPECT_LT(difference / static_cast<double>(expected.pixels.size()), 1e-3);
}

TEST_P(ShiftOrigin, DrawsForDebuggingShowTheSamePicture) {
  const HairAsset asset = fringe();
  const ColliderId mesh = run_.add(toMesh(reference::sphere(0.08f, 12, 16)), {.cellSize = 0.01f});
  HairObject& hair = run_.add(asset, {.settings = settings_});
  setCollider(hair, ballAt({-0.12f, 0.02f, 0.05f}, 0.08f));
  for (int frame = 0; frame < 5; ++frame) run_.step();
  const ColliderId data = run_.add(run_.copySdf(mesh), {.name = "data"});
  run_.step();
  const auto deepest = [&] {
    const Result<float> depth =
        run_.scene.deepestContact(run_.lastHair(), *run_.device()->read(hair.buffers().contacts),
                                  *run_.device()->read(hair.buffers().contactWords),
                                  *run_.device()->read(hair.buffers().positions));
    EXPECT_TRUE(depth) << depth.error().message;
    return depth ? *depth : INFINITY;
  };
  using Draw = std::function<Result<void>(const View&, PassList&)>;
  const std::vector<Draw> draws = {
      [&](const View& view, PassList& list) {
        return run_.scene.drawContacts(run_.lastHair(), view, {.length = 0.05f, .width = 6}, list);
      },
      [&](const View& view, PassList& list) {
        return run_.scene.drawCollider(mesh, view, {}, {}, list);
      },
      [&](const View& view, PassList& list) {
        return run_.scene.drawCollider(data, view, {}, {}, list);
      }};
  const auto pictures = [&] {
    std::vector<RenderedImage> all;
    for (const Draw& draw : draws) {
      PassList list;
      expectOk(draw(SceneRun::viewFrom(here({0.03f, 0.05f, 0.6f}), 96), list));
      all.push_back(run_.render(list, 96));
    }
    return all;
  };
  const float before = deepest();
  const std::vector<RenderedImage> expected = pictures();
  shift({8, -4, 16.5f});
  EXPECT_EQ(deepest(), before) << "positions are still the old ones";
  const std::vector<RenderedImage> shown = pictures();
  EXPECT_NEAR(deepest(), before, 4e-6f);
  ASSERT_EQ(expected.size(), 3u);
  ASSERT_EQ(shown.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    size_t covered = 0, off = 0;
    for (size_t i = 0; i < expected[k].pixels.size(); ++i) {
      const Float4 &a = expected[k].pixels[i], &b = shown[k].pixels[i];
      covered += a.w > 0.1f ? 1 : 0;
      off += std::abs(a.y - b.y) < 0.05f ? 0 : 1;
    }
    EXPECT_GT(covered, 20u) << "picture " << k;
    EXPECT_LT(off, 1 + covered / 50) << "picture " << k;
  }
}

TEST_P(ShiftOrigin, TexelsOfShadowMapsStayOnTheHair) {
  run_.add(fringe(), {.settings = settings_}).drawnStrands = 40;
  run_.step();
  const std::vector<Light> lights = {
      {.direction = {0.3f, 0.8f, 0.4f}, .shadow = HairShadow::kDeep}};
  const auto texelOf = [&](const Float3& p) {
    PassList list;
    const Result<uint32_t> maps = run_.scene.castShadows(lights, list);
    EXPECT_TRUE(maps && *maps == 1);
    run_.execute(list);
    const StrandShadowView map = run_.read<StrandShadowView>(run_.scene.shadowViews()).at(0);
    const Float3 q = here(p);
    const auto along = [&](const Float4& row) {
      return double{row.x} * double{q.x} + double{row.y} * double{q.y} +
             double{row.z} * double{q.z} + double{row.w};
    };
    return Vector3d(along(map.mapX), along(map.mapY), along(map.mapZ) / double{map.texelSize});
  };
  const Vector3d before = texelOf({0.1f, 0.14f, 0});
  shift({0.301f, 1.7f, -2.9f});
  EXPECT_LT((texelOf({0.1f, 0.14f, 0}) - before).norm(), 0.02) << "floats of mapX";
}

TEST_P(ShiftOrigin, AResetAfterAShiftIsInTheNewWorld) {
  const HairAsset asset = wavyAsset(10, 12);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  run_.step();
  const std::vector<Vector3d> first = positions(hair);
  for (int frame = 0; frame < 5; ++frame) run_.step();
  shift({5, 6, 7});
  hair.reset();
  run_.step();
  EXPECT_LT(maxDistance(positions(hair), first), 4e-6);
}

// ---- far away

TEST_P(ShiftOrigin, EdgesAreExactAHundredKilometresAway) {
  const HairAsset asset = wavyAsset(40, 12);
  const auto stretch = [&](const HairObject& hair) {
    return maxStretch(asset, run_.positions(hair));
  };
  HairObject& hair = run_.add(asset, {.settings = settings_});
  const AffineTransform bone = turned(0.3f, {100000, 20, -100000});
  setBone(hair, bone);
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_GT(stretch(hair), 1e-2) << "floats at 100 km are 8 mm apart";
  shift({99990, 0, -99995});
  run_.step(0);
  EXPECT_LT(stretch(hair), 1e-4) << "in a pause";
  const std::vector<Vector3d> paused = positions(hair);
  setBone(hair, bone);
  run_.step();
  EXPECT_LT(stretch(hair), 1e-4);
  EXPECT_LT(maxDistance(positions(hair), paused), 0.05) << "and nothing jumps";
  if (!exact()) return;
  hair.settings.damping = 0.3f;
  fallAsleep(hair);
  shift({-99990, 0, 99995});
  run_.step();
  EXPECT_GT(stretch(hair), 1e-2);
  shift({99990, 0, -99995});
  run_.step();
  EXPECT_EQ(awake(hair), 0u);
  EXPECT_LT(stretch(hair), 1e-4) << "asleep";
}

TEST_P(ShiftOrigin, WhatIsNotSetAnewComesBackAsItWas) {
  // Bones that stand still where floats are 8 mm apart, and move on at home.
  const HairAsset asset = wavyAsset(10, 12);
  const auto begin = [&] {
    HairObject& hair = run_.add(asset, {.settings = settings_});
    setBone(hair, turned(0.3f, {0.123f, 0.456f, 0.789f}));
    return &hair;
  };
  const auto move = [&](int frame, HairObject& hair) {
    if (frame == 20) setBone(hair, turned(0.4f, {0.125f, 0.456f, 0.789f}));
  };
  Shifts thereAndBack;
  for (int k = 0; k < 7; ++k) {
    thereAndBack[5 + k] = {{12345, -12345.25f, 1000}};
    thereAndBack[12 + k] = {{-12345, 12345.25f, -1000}};
  }
  const auto [still, shifted] = tellBoth(thereAndBack, begin, move);
  expectSameStates(shifted, still);
  EXPECT_LT(maxDistance(shifted.back().positions, still.back().positions), 1e-6);
}

TEST_P(ShiftOrigin, FieldsAreNotBuiltAgain) {
  // Four meshes: on bones, on a skeleton, in a buffer of the engine's, and as a field out of a
  // file.
  // All of it is added to a world that was shifted before.
  const TriangleMesh ball = reference::sphere(0.05f, 8, 10);
  shift({1000, 0.375f, -3});
  const Vector3d start = moved_;
  const auto inWorld = [&](const Float3& p) {
    return toFloat3(start + toVector({p.x, p.y, p.z, 0}) - moved_);
  };
  const HairObject& hair = run_.add(fringe(), {.settings = settings_});
  const ColliderId own = run_.add(toMesh(ball), {.name = "own", .cellSize = 0.01f});
  const SkeletonId skeleton = run_.add(SkeletonDef{.name = "skeleton"});
  const ColliderId led =
      run_.add(toMesh(ball), {.name = "led", .cellSize = 0.01f, .skeleton = skeleton});
  const BufferId buffer = run_.add("vertices", std::vector<float>(3 * ball.positions.size()));
  const auto upload = [&] {
    std::vector<float> now;
    for (const Float3& p : ball.positions) {
      const Float3 q = inWorld(p);
      now.insert(now.end(), {q.x, q.y, q.z});
    }
    PassList list;
    addUpload(list, buffer, std::as_bytes(std::span(now)));
    run_.execute(list);
  };
  const ColliderId engine =
      run_.add(toMesh(ball), {.name = "engine", .cellSize = 0.01f, .vertices = buffer});
  upload();
  run_.step();
  const ColliderId data = run_.add(run_.copySdf(own), {.name = "data"});
  run_.step();
  run_.step();
  const std::vector<uint32_t> keys = run_.read<uint32_t>(run_.scene.sdfKeys());
  const std::vector<uint32_t> sdfs = run_.read<uint32_t>(hair.buffers().sdfs);
  EXPECT_EQ(sdfs.size(), 4 * sizeof(Sdf) / sizeof(uint32_t));
  for (const Float3& by : {Float3{16, -4, 2}, Float3{0.25f, 0.5f, 100.125f}}) {
    std::map<ColliderId, Float3> before;
    for (const ColliderId id : {own, led, engine, data})
      before[id] = run_.scene.collider(id).grid().origin;
    shift(by);
    upload();
    PassList list;
    expectOk(run_.scene.simulate(1.0f / 60, list));
    for (const Pass& pass : list.passes)
      EXPECT_NE(std::string(pass.name), "compute_points") << "a field is built";
    for (const Upload& sent : list.uploads)
      EXPECT_NE(sent.buffer, hair.buffers().sdfs) << "another field is in reach";
    run_.execute(list);
    EXPECT_TRUE(run_.read<uint32_t>(hair.buffers().sdfs) == sdfs) << "all are in reach";
    for (const ColliderId id : {own, led, engine, data}) {
      const Float3 now = run_.scene.collider(id).grid().origin;
      EXPECT_NEAR(now.x, before[id].x - by.x, 1e-5f);
      EXPECT_NEAR(now.y, before[id].y - by.y, 1e-5f);
      EXPECT_NEAR(now.z, before[id].z - by.z, 1e-5f);
      EXPECT_EQ(run_.copySdf(id).grid.origin, now);
    }
  }
  EXPECT_TRUE(run_.read<uint32_t>(run_.scene.sdfKeys()) == keys);
  // An engine's vertices that are built again are where the field has them.
  const SdfGrid grid = run_.scene.collider(engine).grid();
  const Float3 low = inWorld({-0.05f, -0.05f, -0.05f});
  const Float3 high = inWorld({0.05f, 0.05f, 0.05f});
  run_.scene.collider(engine).setVertexBounds(low, high);
  run_.step();
  EXPECT_EQ(run_.scene.collider(engine).grid(), grid);
  EXPECT_TRUE(run_.read<uint32_t>(run_.scene.sdfKeys()) == keys) << "within the motion's tolerance";
}

// ---- what only the exact solver has

class ShiftOriginExact : public ShiftOrigin {
 protected:
  ShiftOriginExact() { settings_.damping = 0.3f; }
  /// Until the strands sleep; then a shift, and frames after it.
  void sleepThrough(HairObject& hair, const Float3& by, double bound) {
    fallAsleep(hair);
    for (int frame = 0; frame < 3; ++frame) run_.step();
    const Snapshot before = snapshot(hair);
    shift(by);
    for (int frame = 0; frame < 4; ++frame) {
      run_.step();
      const Snapshot after = snapshot(hair);
      EXPECT_EQ(after.awake, 0u) << "frame " << frame;
      EXPECT_TRUE(after.state == before.state);
      EXPECT_LT(maxDistance(after.positions, before.positions), bound);
    }
  }
};

TEST_P(ShiftOriginExact, SleepersSleepOn) {
  const HairAsset asset = wavyAsset(70, 10);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  sleepThrough(hair, {16, -3, 20}, 4e-6);
  sleepThrough(hair, {0.3f, 1.7f, 5.55f}, 8e-6);
}

TEST_P(ShiftOriginExact, SleepersAmongCollidersSleepOn) {
  // Guides hang beside a mesh and a ball; some of their follow hairs are pushed out of these.
  const HairAsset asset = fringe(40, 10);
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 3, .maxRadius = 0.02f}));
  addBall();
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    HairObject& hair = run_.add(asset, {.settings = settings_,
                                        .followHairs = follows,
                                        .storeFollowHairs = true,
                                        .collidingHair = colliding});
    const auto setColliders = [&] { setCollider(hair, ballAt({-0.2f, 0.02f, 0}, 0.07f)); };
    setBone(hair, {});
    setColliders();
    sleepThrough(hair, {16, -3, 20}, 1e-5);
    sleepThrough(hair, {0.3f, 1.7f, 5.55f}, 1e-5);
    // An engine that rounds its own positions anew.
    const Snapshot before = snapshot(hair);
    shift({1000.3f, 0, -77.7f});
    setColliders();
    run_.step();
    EXPECT_EQ(awake(hair), 0u);
    EXPECT_LT(maxDistance(positions(hair), before.positions), 2e-4) << "floats at 1 km";
    shift({-1000.3f, 0, 77.7f});
    if (colliding == CollidingHair::kGuidesAndFollows) {
      const std::vector<uint32_t> words = run_.read<uint32_t>(hair.buffers().followContactWords);
      EXPECT_GT(readFollowContactCounters(std::as_bytes(std::span(words))).records, 10u);
    }
  }
}

TEST_P(ShiftOriginExact, HairThatTouchesHairGoesOn) {
  const HairAsset asset = fringe(60, 12);
  settings_.contact = {.stiffness = 0.3f, .friction = 0.2f};
  const auto begin = [&] { return &run_.add(asset, {.settings = settings_}); };
  const auto move = [&](int frame, HairObject& hair) { setBone(hair, stroll(frame)); };
  const auto [still, shifted] = tellBoth(kWholeMetres, begin, move);
  EXPECT_LT(storyDistance(shifted, still), 1e-4);
}

TEST_P(ShiftOriginExact, ReducedHairGoesOn) {
  const HairAsset asset = wavyAsset(100, 10);
  const auto begin = [&] {
    HairObject& hair = run_.add(asset, {.settings = settings_, .levelOfDetail = true});
    hair.simulatedShare = 0.4f;
    return &hair;
  };
  const auto move = [&](int frame, HairObject& hair) {
    setBone(hair, walk(frame));
    if (frame > 12) hair.simulatedShare = 0.8f;
  };
  const auto [still, shifted] = tellBoth(kWholeMetres, begin, move);
  expectSameStates(shifted, still);
  EXPECT_LT(storyDistance(shifted, still), 4e-6);
  HairObject& hair = *begin();
  for (int frame = 0; frame < 5; ++frame) run_.step();
  const Snapshot before = snapshot(hair);
  shift({5, 6, 7});
  run_.step(0);
  EXPECT_LT(maxDistance(positions(hair), before.positions), 4e-6);
}

TEST_P(ShiftOriginExact, RewrittenPositionsHaveTheSolversBits) {
  // There and back between two frames: the origin is the same, and so is all but vertex 0.
  HairAsset asset = wavyAsset(70, 12);
  asset.vertexCounts.resize(70);
  for (uint32_t s = 0; s < 70; ++s) asset.vertexCounts[s] = 2 + (s * 7) % 11;
  expectOk(asset.process());
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 9; ++frame) run_.step();
  const std::vector<Float4> before = run_.positions(hair);
  shift({3, 0, 0});
  run_.step(0);
  shift({-3, 0, 0});
  run_.step(0);
  const std::vector<Float4> after = run_.positions(hair);
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    if (i % 12 == 0)
      EXPECT_LT((toVector(after[i]) - toVector(before[i])).norm(), 1e-6);
    else
      EXPECT_EQ(after[i], before[i]) << "vertex " << i;
    EXPECT_EQ(after[i].w, before[i].w);
  }
}

// ---- the kernel

class ShiftPositions : public GpuTest {};

TEST_P(ShiftPositions, AddsToARangeAndKeepsTheRest) {
  Random random(7);
  std::vector<Float4> data(1000);
  for (Float4& v : data) v = toFloat4(random.vector(1000), random.between(-1, 1));
  const GuardedBuffer<Float4> buffer(gpu(), "positions", data);
  ShiftPositionsConstants constants = {};
  constants.shift = {12.5f, -0.1f, 1e5f, 77};
  constants.shiftedFirst = 30;
  constants.shiftedCount = 901;
  dispatch(gpu(), shiftPositionsVariant({}), constants.shiftedCount, [&](PassBuilder& pass) {
    buffer.bindTo(pass, "g_shiftedPositions");
    pass.constants("ShiftPositionsConstants", constants);
  });
  for (size_t i = 30; i < 931; ++i) {
    data[i].x += constants.shift.x;
    data[i].y += constants.shift.y;
    data[i].z += constants.shift.z;
  }
  EXPECT_TRUE(buffer.read() == data);
}

INSTANTIATE_TEST_SUITE_P(All, ShiftPositions, testing::ValuesIn(kRuntimeApis), apiTestName);

INSTANTIATE_TEST_SUITE_P(All, ShiftOrigin, testing::ValuesIn(solversOnRuntimes()), solverTestName);
INSTANTIATE_TEST_SUITE_P(All, ShiftOriginExact,
                         testing::Combine(testing::ValuesIn(kRuntimeApis),
                                          testing::Values(Solver::kExact)),
                         solverTestName);

}  // namespace
}  // namespace pelage::test
