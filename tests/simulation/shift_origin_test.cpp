// Shifts of the world's origin: hair in a world that is shifted against the same without, with both
// solvers on every API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "pelage/demo/groom.h"
#include "pelage/skeleton.h"
#include "reference/sdf/mesh_shapes.h"
#include "support/extremes.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/strand_run.h"

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

/// What hair is after a frame, in the first world.
struct Snapshot {
  std::vector<Vector3d> positions;
  std::vector<Float4> tangents;
  std::vector<uint32_t> state;  ///< bits
  uint32_t awake = 0;
};
using Story = std::vector<Snapshot>;

/// Infinite where there is something else than numbers, or nothing.
double maxDistance(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  if (a.empty() || a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double distance = (a[i] - b[i]).norm();
    if (!(distance <= largest)) largest = distance;
    if (std::isnan(distance)) return std::numeric_limits<double>::infinity();
  }
  return largest;
}

double largestRotation(const std::vector<Float4>& a, const std::vector<Float4>& b) {
  const auto vectors = [](const std::vector<Float4>& all) {
    std::vector<Vector3d> result;
    for (const Float4& v : all) result.push_back(toVector(v));
    return result;
  };
  return maxDistance(vectors(a), vectors(b));
}

double maxDistance(const Story& a, const Story& b) {
  if (a.empty() || a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    keepLargest(largest, maxDistance(a[i].positions, b[i].positions));
  }
  return largest;
}

CollisionMesh toMesh(const TriangleMesh& shape) {
  CollisionMesh mesh;
  mesh.positions = shape.positions;
  mesh.normals.resize(shape.positions.size());
  mesh.indices = shape.indices;
  return mesh;
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
  HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  for (uint32_t s = 0; s < strands; ++s) {
    const float angle = 2.4f * static_cast<float>(s);
    const float r = 0.09f + 0.03f * static_cast<float>(s) / static_cast<float>(strands);
    for (uint32_t v = 0; v < vertices; ++v) {
      const float t = 0.25f * static_cast<float>(v) / static_cast<float>(vertices - 1);
      asset.positions.push_back(
          {r * std::cos(angle), 0.14f - t, r * std::sin(angle), v < 2 ? 0.0f : 1.0f});
    }
  }
  expectOk(asset.process());
  return asset;
}

class ShiftOrigin : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  ShiftOrigin() : run_(sharedSceneRun(std::get<0>(GetParam()))) {
    settings_.solver = std::get<1>(GetParam());
    if (exact()) return;
    // A breath that moves nothing, as in scene_simulation_test.
    settings_.airDrag = 1e-4f;
    settings_.wind = {.velocity = {0, 0, 1e-4f}, .gustStrength = 0, .strandVariation = 0};
  }
  void SetUp() override {
    if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    messages_ = run_.device()->messageCount();
  }
  void TearDown() override {
    end();
    if (run_.device() != nullptr) {
      EXPECT_EQ(run_.device()->messageCount(), messages_) << "the driver or a layer complained";
    }
  }
  bool exact() const { return settings_.solver == Solver::kExact; }

  /// An empty scene in the first world.
  void end() {
    run_.clear();
    // Floats hold what is left after a few rounds.
    for (int round = 0; round < 4; ++round)
      shift({static_cast<float>(-moved_.x()), static_cast<float>(-moved_.y()),
             static_cast<float>(-moved_.z())});
    EXPECT_EQ(moved_.norm(), 0);
  }
  void shift(const Float3& by) {
    expectOk(run_.scene.shiftOrigin(by));
    moved_ += toVector({by.x, by.y, by.z, 0});
  }
  /// From the first world into the one that there is.
  Float3 here(const Float3& p) const {
    const Vector3d now = toVector({p.x, p.y, p.z, 0}) - moved_;
    return {static_cast<float>(now.x()), static_cast<float>(now.y()), static_cast<float>(now.z())};
  }
  AffineTransform boneHere(AffineTransform bone) const {
    const Float3 p = here({bone.rows[0].w, bone.rows[1].w, bone.rows[2].w});
    bone.rows[0].w = p.x;
    bone.rows[1].w = p.y;
    bone.rows[2].w = p.z;
    return bone;
  }
  void setBone(HairObject& hair, const AffineTransform& bone) {
    const AffineTransform now = boneHere(bone);
    hair.setBones({&now, 1});
  }
  void setBone(SdfCollider& collider, const AffineTransform& bone) {
    const AffineTransform now = boneHere(bone);
    collider.setBones({&now, 1});
  }
  CapsuleCollider ballAt(const Float3& p, float radius) const {
    return {.head = here(p), .headRadius = radius, .tail = here(p), .tailRadius = radius};
  }

  /// The only object's.
  HairId hairId() const { return run_.lastHair(); }
  std::vector<Vector3d> positions(const HairObject& hair) const {
    std::vector<Vector3d> all;
    for (const Float4& p : run_.positions(hair)) all.push_back(toVector(p) + moved_);
    return all;
  }
  uint32_t awake(const HairObject& hair) const {
    if (!exact()) return hair.guideCount();
    const std::vector<uint32_t> words = run_.read<uint32_t>(hair.buffers().sleep);
    return readCounters(std::as_bytes(std::span(words))).awakeStrands;
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
  static void expectSameStates(const Story& a, const Story& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_TRUE(a[i].state == b[i].state) << "frame " << i;
      ASSERT_TRUE(a[i].tangents == b[i].tangents) << "frame " << i;
      ASSERT_EQ(a[i].awake, b[i].awake) << "frame " << i;
    }
  }

  SceneRun& run_;
  SimulationSettings settings_;
  SdfCollider* mesh_ = nullptr;
  Vector3d moved_ = {0, 0, 0};

 private:
  uint32_t messages_ = 0;
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
  const Story still = tell(24, {}, begin, move);
  const Story shifted = tell(24, kWholeMetres, begin, move);
  expectSameStates(shifted, still);
  EXPECT_LT(maxDistance(shifted, still), 4e-6) << "floats at 30 m";
  Shifts everyFrame;
  for (int frame = 0; frame < 24; ++frame) everyFrame[frame] = {{1, 0, -1}};
  const Story running = tell(24, everyFrame, begin, move);
  expectSameStates(running, still);
  EXPECT_LT(maxDistance(running, still), 4e-6);
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
  EXPECT_LT(maxDistance(exactly, still), 4e-6);
  // Elsewhere bones are rounded anew, by up to 2.4e-7 m here.
  settings_.damping = 0.3f;
  const auto slowly = [&](int frame, HairObject& hair) { setBone(hair, stroll(frame)); };
  const Story slow = tell(24, {}, begin, slowly);
  const Story shifted =
      tell(24, {{0, {{0.3f, 0.7f, -0.1f}}}, {5, {{0.123f, -4.56f, 3.89f}}}, {9, {{1e-3f, 0, 0}}}},
           begin, slowly);
  EXPECT_LT(maxDistance(shifted, slow), 1e-4);
}

TEST_P(ShiftOrigin, CollisionsGoOn) {
  // A mesh and a ball that go into the strands from two sides.
  const HairAsset asset = fringe();
  const auto begin = [&] {
    mesh_ = &run_.scene.collider(
        run_.add(toMesh(reference::sphere(0.08f, 12, 16)), {.cellSize = 0.01f}));
    return &run_.add(asset, {.settings = settings_});
  };
  const auto move = [&](int frame, HairObject& hair) {
    setBone(*mesh_, turned(0.02f * static_cast<float>(frame), onFineGrid(0.002 * frame, 0, 0)));
    const CapsuleCollider ball = ballAt(onFineGrid(-0.2 + 0.004 * frame, 0.02, 0.05), 0.05f);
    hair.setColliders({&ball, 1});
    setBone(hair, {});
  };
  const Story still = tell(24, {}, begin, move);
  const Story shifted = tell(24, kWholeMetres, begin, move);
  // Contacts are found from the outputs, which are rounded differently.
  EXPECT_LT(maxDistance(shifted, still), 1e-4);
  std::vector<Vector3d> bind;
  for (const Float4& p : asset.positions) bind.push_back(toVector(p));
  EXPECT_GT(maxDistance(still.back().positions, bind), 0.02) << "they were touched";
}

TEST_P(ShiftOrigin, StoredFollowHairsMoveAlong) {
  const HairAsset asset = fringe();
  const auto follows = asset.generateFollowHairs({.countPerGuide = 3, .maxRadius = 0.02f});
  ASSERT_TRUE(follows);
  std::vector<Story> all;
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    const auto begin = [&] {
      mesh_ = &run_.scene.collider(
          run_.add(toMesh(reference::sphere(0.08f, 12, 16)), {.cellSize = 0.01f}));
      return &run_.add(asset, {.settings = settings_,
                               .followHairs = *follows,
                               .storeFollowHairs = true,
                               .collidingHair = colliding});
    };
    const auto move = [&](int frame, HairObject& hair) {
      setBone(*mesh_, turned(0.02f * static_cast<float>(frame), {}));
      setBone(hair, {});
    };
    const Story still = tell(24, {}, begin, move);
    const Story shifted = tell(24, kWholeMetres, begin, move);
    all.push_back(still);
    EXPECT_EQ(still.back().positions.size(), 4u * 40 * 12);
    EXPECT_LT(maxDistance(shifted, still), 1e-4)
        << (colliding == CollidingHair::kGuides ? "guides collide" : "all collide");
  }
  EXPECT_GT(maxDistance(all[0], all[1]), 1e-3) << "some collide";
}

// ---- what is between two simulations

TEST_P(ShiftOrigin, APauseShowsHairWhereItIsNow) {
  const HairAsset asset = fringe();
  const auto follows = asset.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.02f});
  ASSERT_TRUE(follows);
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    HairObject& hair = run_.add(asset, {.settings = settings_,
                                        .followHairs = *follows,
                                        .storeFollowHairs = true,
                                        .collidingHair = colliding});
    hair.visible = false;
    const CapsuleCollider ball = ballAt({0.05f, 0, 0}, 0.05f);
    hair.setColliders({&ball, 1});
    for (int frame = 0; frame < 5; ++frame) run_.step();
    const Snapshot before = snapshot(hair);
    shift({10, -20, 3});
    shift({-2, 1.5f, 0.25f});
    run_.step(0);
    const Snapshot after = snapshot(hair);
    EXPECT_TRUE(after.state == before.state);
    EXPECT_LT(largestRotation(after.tangents, before.tangents), 1e-3) << "those of follow hairs";
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
  const CapsuleCollider ball = ballAt({-0.12f, 0.02f, 0.05f}, 0.08f);
  hair.setColliders({&ball, 1});
  for (int frame = 0; frame < 5; ++frame) run_.step();
  const auto keys = run_.device()->read(run_.scene.sdfKeys());
  const auto surface = run_.device()->read(run_.scene.sdfSurface());
  const Result<SdfData> copied = run_.scene.copySdf(mesh, *keys, *surface);
  ASSERT_TRUE(copied);
  const ColliderId data = run_.add(*copied, {.name = "data"});
  run_.step();
  const auto deepest = [&] {
    const Result<float> depth =
        run_.scene.deepestContact(hairId(), *run_.device()->read(hair.buffers().contacts),
                                  *run_.device()->read(hair.buffers().contactWords),
                                  *run_.device()->read(hair.buffers().positions));
    EXPECT_TRUE(depth) << depth.error().message;
    return depth ? *depth : INFINITY;
  };
  using Draw = std::function<Result<void>(const View&, PassList&)>;
  const std::vector<Draw> draws = {[&](const View& view, PassList& list) {
                                     return run_.scene.drawContacts(
                                         hairId(), view, {.length = 0.05f, .width = 6}, list);
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
      View view;
      view.eye = here({0.03f, 0.05f, 0.6f});
      view.worldToClip = lookAt(view.eye, {view.eye.x, view.eye.y, view.eye.z - 1}, {0, 1, 0},
                                0.785f, 1, 0.1f, 10.0f);
      view.width = view.height = 96;
      PassList list;
      expectOk(draw(view, list));
      run_.scene.finish(list);
      expectOk(run_.device()->update(run_.scene.resources()));
      RenderTargetDef target;
      target.width = target.height = 96;
      const Result<RenderedImage> image = run_.device()->render(list, target);
      EXPECT_TRUE(image) << image.error().message;
      if (image) all.push_back(*image);
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
    run_.scene.finish(list);
    expectOk(run_.device()->update(run_.scene.resources()));
    expectOk(run_.device()->execute(list));
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
  const auto maxStretch = [&](const HairObject& hair) {
    const std::vector<Float4> p = run_.positions(hair);
    double largest = 0;
    for (size_t i = 0; i + 1 < asset.positions.size(); ++i) {
      const double rest = static_cast<double>(asset.restLengths[i]);
      if (!(rest > 0)) continue;
      const double stretch = std::abs((toVector(p[i + 1]) - toVector(p[i])).norm() / rest - 1);
      if (!(stretch <= largest)) largest = stretch;
      if (std::isnan(stretch)) return std::numeric_limits<double>::infinity();
    }
    return largest;
  };
  HairObject& hair = run_.add(asset, {.settings = settings_});
  const AffineTransform bone = turned(0.3f, {100000, 20, -100000});
  setBone(hair, bone);
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_GT(maxStretch(hair), 1e-2) << "floats at 100 km are 8 mm apart";
  shift({99990, 0, -99995});
  run_.step(0);
  EXPECT_LT(maxStretch(hair), 1e-4) << "in a pause";
  const std::vector<Vector3d> paused = positions(hair);
  setBone(hair, bone);
  run_.step();
  EXPECT_LT(maxStretch(hair), 1e-4);
  EXPECT_LT(maxDistance(positions(hair), paused), 0.05) << "and nothing jumps";
  if (!exact()) return;
  hair.settings.damping = 0.3f;
  fallAsleep(hair);
  shift({-99990, 0, 99995});
  run_.step();
  EXPECT_GT(maxStretch(hair), 1e-2);
  shift({99990, 0, -99995});
  run_.step();
  EXPECT_EQ(awake(hair), 0u);
  EXPECT_LT(maxStretch(hair), 1e-4) << "asleep";
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
  const Story still = tell(24, {}, begin, move);
  const Story shifted = tell(24, thereAndBack, begin, move);
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
    const Vector3d from = start + toVector({p.x, p.y, p.z, 0});
    const Vector3d now = from - moved_;
    return Float3{static_cast<float>(now.x()), static_cast<float>(now.y()),
                  static_cast<float>(now.z())};
  };
  const HairObject& hair = run_.add(fringe(), {.settings = settings_});
  const ColliderId own = run_.add(toMesh(ball), {.name = "own", .cellSize = 0.01f});
  const Result<SkeletonId> skeleton = run_.scene.addSkeleton({.name = "skeleton"});
  ASSERT_TRUE(skeleton);
  const ColliderId led =
      run_.add(toMesh(ball), {.name = "led", .cellSize = 0.01f, .skeleton = *skeleton});
  std::vector<float> vertices;
  for (const Float3& p : ball.positions) vertices.insert(vertices.end(), {p.x, p.y, p.z});
  const BufferId buffer =
      run_.scene.resources().add({.name = "vertices",
                                  .size = vertices.size() * sizeof(float),
                                  .stride = 4,
                                  .usage = BufferUsage::kStorage | BufferUsage::kUpload});
  const auto upload = [&] {
    std::vector<float> now;
    for (const Float3& p : ball.positions) {
      const Float3 q = inWorld(p);
      now.insert(now.end(), {q.x, q.y, q.z});
    }
    PassList list;
    addUpload(list, buffer, std::as_bytes(std::span(now)));
    run_.scene.finish(list);
    expectOk(run_.device()->update(run_.scene.resources()));
    expectOk(run_.device()->execute(list));
  };
  const ColliderId engine =
      run_.add(toMesh(ball), {.name = "engine", .cellSize = 0.01f, .vertices = buffer});
  upload();
  run_.step();
  const auto copy = [&](ColliderId id) {
    const auto keys = run_.device()->read(run_.scene.sdfKeys());
    const auto surface = run_.device()->read(run_.scene.sdfSurface());
    Result<SdfData> data = run_.scene.copySdf(id, *keys, *surface);
    EXPECT_TRUE(data) << data.error().message;
    return *data;
  };
  const SdfData baked = copy(own);
  const ColliderId data = run_.add(baked, {.name = "data"});
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
    run_.scene.finish(list);
    expectOk(run_.device()->update(run_.scene.resources()));
    expectOk(run_.device()->execute(list));
    EXPECT_TRUE(run_.read<uint32_t>(hair.buffers().sdfs) == sdfs) << "all are in reach";
    for (const ColliderId id : {own, led, engine, data}) {
      const Float3 now = run_.scene.collider(id).grid().origin;
      EXPECT_NEAR(now.x, before[id].x - by.x, 1e-5f);
      EXPECT_NEAR(now.y, before[id].y - by.y, 1e-5f);
      EXPECT_NEAR(now.z, before[id].z - by.z, 1e-5f);
      EXPECT_EQ(copy(id).grid.origin, now);
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
  run_.clear();
  expectOk(run_.scene.removeSkeleton(*skeleton));
  run_.scene.resources().remove(buffer);
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
  const auto follows = asset.generateFollowHairs({.countPerGuide = 3, .maxRadius = 0.02f});
  ASSERT_TRUE(follows);
  run_.add(toMesh(reference::sphere(0.08f, 12, 16)), {.cellSize = 0.01f});
  for (const CollidingHair colliding : {CollidingHair::kGuides, CollidingHair::kGuidesAndFollows}) {
    HairObject& hair = run_.add(asset, {.settings = settings_,
                                        .followHairs = *follows,
                                        .storeFollowHairs = true,
                                        .collidingHair = colliding});
    const auto setColliders = [&] {
      const CapsuleCollider ball = ballAt({-0.2f, 0.02f, 0}, 0.07f);
      hair.setColliders({&ball, 1});
    };
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
  const Story still = tell(24, {}, begin, move);
  const Story shifted = tell(24, kWholeMetres, begin, move);
  EXPECT_LT(maxDistance(shifted, still), 1e-4);
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
  const Story still = tell(24, {}, begin, move);
  const Story shifted = tell(24, kWholeMetres, begin, move);
  expectSameStates(shifted, still);
  EXPECT_LT(maxDistance(shifted, still), 4e-6);
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
  PassList list;
  PassBuilder builder(list);
  builder.dispatch(shiftPositionsVariant({}), constants.shiftedCount);
  buffer.bindTo(builder, "g_shiftedPositions");
  builder.constants("ShiftPositionsConstants", constants);
  expectOk(builder.finish());
  gpu().hazards.resolve(list);
  expectOk(gpu().device()->update(gpu().resources));
  expectOk(gpu().device()->execute(list));
  for (size_t i = 30; i < 931; ++i) {
    data[i].x += constants.shift.x;
    data[i].y += constants.shift.y;
    data[i].z += constants.shift.z;
  }
  EXPECT_TRUE(buffer.read() == data);
}

INSTANTIATE_TEST_SUITE_P(All, ShiftPositions, testing::ValuesIn(kApis), apiTestName);

std::string testName(const testing::TestParamInfo<std::tuple<Api, Solver>>& info) {
  return std::string(apiName(std::get<0>(info.param))) +
         (std::get<1>(info.param) == Solver::kExact ? "Exact" : "Classic");
}

INSTANTIATE_TEST_SUITE_P(All, ShiftOrigin, testing::ValuesIn(solversOnApis()), testName);

std::vector<std::tuple<Api, Solver>> exactOnApis() {
  std::vector<std::tuple<Api, Solver>> all;
  for (const Api api : kApis) all.emplace_back(api, Solver::kExact);
  return all;
}
INSTANTIATE_TEST_SUITE_P(All, ShiftOriginExact, testing::ValuesIn(exactOnApis()), testName);

}  // namespace
}  // namespace pelage::test
