// Input that no animation, artist or asset should hand over: refused by name, or survived without a
// NaN and forgotten within a second.
#include <functional>

#include "stress/stress_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

constexpr int kCalmFrames = 20, kTroubledFrames = 10, kForgettingFrames = 60;

// ---- refused

TEST(BadSettings, EveryNumberThatIsNotOneIsRefusedByName) {
  SimulationSettings s;
  const std::pair<const char*, float*> numbers[] = {
      {"gravity.x", &s.gravity.x},
      {"gravity.y", &s.gravity.y},
      {"gravity.z", &s.gravity.z},
      {"damping", &s.damping},
      {"bendLength", &s.bendLength},
      {"twistRatio", &s.twistRatio},
      {"relaxationTime", &s.relaxationTime},
      {"sagCompensation", &s.sagCompensation},
      {"localStiffness", &s.localStiffness},
      {"globalStiffness", &s.globalStiffness},
      {"globalRange", &s.globalRange},
      {"vspCoefficient", &s.vspCoefficient},
      {"vspThreshold", &s.vspThreshold},
      {"wind.velocity.x", &s.wind.velocity.x},
      {"wind.velocity.y", &s.wind.velocity.y},
      {"wind.velocity.z", &s.wind.velocity.z},
      {"wind.gustStrength", &s.wind.gustStrength},
      {"wind.gustPeriod", &s.wind.gustPeriod},
      {"wind.strandVariation", &s.wind.strandVariation},
      {"sleep.speed", &s.sleep.speed},
      {"sleep.time", &s.sleep.time},
      {"sleep.wakeDistance", &s.sleep.wakeDistance},
      {"contact.stiffness", &s.contact.stiffness},
      {"contact.friction", &s.contact.friction},
      {"contact.cellSize", &s.contact.cellSize},
      {"curves.stiffness", &s.curves.stiffness[0]},
      {"curves.globalStiffness", &s.curves.globalStiffness[3]},
      {"curves.damping", &s.curves.damping[7]},
      {"airDrag", &s.airDrag},
      {"maxSpeed", &s.maxSpeed},
      {"tipSeparation", &s.tipSeparation},
  };
  const HairAsset asset = wavyAsset(2, 4);
  Scene scene;
  const Result<HairId> hair = required(scene.addHair(asset, {.name = "tail"}));
  PassList list;
  for (const auto& [name, number] : numbers) {
    for (const float bad : {kNan, kInf, -kInf}) {
      // An infinite threshold is one that is never reached.
      if (bad == kInf && number == &s.vspThreshold) continue;
      const float good = *number;
      *number = bad;
      expectError(validate(s), name);
      // Wherever it comes in, and without harm: the scene goes on once it is mended.
      const Result<HairId> added = scene.addHair(asset, {.settings = s});
      EXPECT_FALSE(added) << name;
      scene.hair(*hair).settings = s;
      expectError(scene.simulate(1.0f / 60, list), "'tail'");
      EXPECT_TRUE(list.passes.empty());
      *number = good;
    }
  }
  scene.hair(*hair).settings = s;
  expectOk(scene.simulate(1.0f / 60, list));
  EXPECT_FALSE(list.passes.empty());
}

TEST(BadSettings, TimeStepsThatAreNoneAreRefused) {
  Scene scene;
  ASSERT_TRUE(scene.addHair(wavyAsset(2, 4), {}));
  PassList list;
  for (const float dt : {-1e-6f, -1.0f, kNan, kInf, -kInf}) {
    expectError(scene.simulate(dt, list), "time step");
  }
  EXPECT_EQ(scene.time(), 0);
}

TEST(BadAssets, HairWithoutStrandsIsRefused) {
  HairAsset asset;
  asset.verticesPerStrand = 8;
  expectError(asset.process(), "no strands");
  Scene scene;
  expectError(scene.addHair(asset, {.name = "bald"}), "'bald'");
}

TEST(BadAssets, ValuesThatAreNotNumbersAreRefusedWithTheirPlace) {
  for (const float bad : {kNan, kInf, -kInf, 1e30f}) {
    HairAsset asset = wavyAsset(3, 5);
    asset.positions[2 * 5 + 3].y = bad;
    expectError(asset.process(), "strand 2, vertex 3");
  }
}

TEST(BadAssets, AnAssetThatHasChangedSinceItWasProcessedIsRefusedWithItsArray) {
  const HairAsset good = wavyAsset(3, 5);
  const std::pair<const char*, std::function<void(HairAsset&)>> troubles[] = {
      {"call process()",
       [](HairAsset& a) {
         a.positions[8].y = kNan;
         EXPECT_FALSE(a.process());
         a.positions[8].y = 0.1f;
       }},
      {"position of strand 1, vertex 3", [](HairAsset& a) { a.positions[8].y = kNan; }},
      {"positions has 14", [](HairAsset& a) { a.positions.pop_back(); }},
      {"positions has 15", [](HairAsset& a) { a.strandCount = 4; }},
      {"strandUv has 2", [](HairAsset& a) { a.strandUv.resize(2); }},
      {"restVectors of strand 2, vertex 1", [](HairAsset& a) { a.restVectors[11].z = kInf; }},
      {"restFrames of strand 0, vertex 0", [](HairAsset& a) { a.restFrames[0].w = kNan; }},
      {"restLengths of strand 1, vertex 0", [](HairAsset& a) { a.restLengths[5] = kNan; }},
      {"inverseMasses has 0", [](HairAsset& a) { a.inverseMasses.clear(); }},
      {"tangents has 14", [](HairAsset& a) { a.tangents.pop_back(); }},
      {"vertexThickness has 0", [](HairAsset& a) { a.vertexThickness.clear(); }},
  };
  Scene scene;
  for (const auto& [words, make] : troubles) {
    HairAsset asset = good;
    make(asset);
    expectError(scene.addHair(asset, {.name = "stale"}), {words, "'stale'"});
    EXPECT_EQ(scene.resources().count(), 0u) << words;
  }
  EXPECT_TRUE(scene.addHair(good, {}));
}

TEST(BadAssets, AnEnumWithoutThatValueIsRefused) {
  const HairAsset asset = wavyAsset(3, 5);
  Scene scene;
  expectError(scene.addHair(asset, {.skinning = SkinningMethod{9}}), "HairDef::skinning is 9");
  expectError(scene.addHair(asset, {.collidingHair = CollidingHair{7}}),
              "HairDef::collidingHair is 7");
}

// ---- survived

/// A head that turns and moves for a second, and then stands still.
AffineTransform headAt(int frame) {
  const double t = std::min(frame, kCalmFrames + kTroubledFrames) / 60.0;
  return RigidMotion::about(0.5 * std::sin(5 * t), {0.2, 1, 0.1},
                            {0.3 * t, 0.05 * std::sin(9 * t), 0})
      .transform();
}

AffineTransform scaled(const AffineTransform& from, const Vector3d& by) {
  AffineTransform result = from;
  for (Float4& row : result.rows) {
    row.x *= static_cast<float>(by.x());
    row.y *= static_cast<float>(by.y());
    row.z *= static_cast<float>(by.z());
  }
  return result;
}

/// Something bad that happens to one object for a while.
struct HairTrouble {
  std::string name;
  std::function<void(HairObject&, int frame)> make;
};

HairTrouble boneEntry(const std::string& name, int row, int column, float value) {
  return {name, [=](HairObject& hair, int frame) {
            AffineTransform bone = headAt(frame);
            Float4& entry = bone.rows[row];
            float* entries[] = {&entry.x, &entry.y, &entry.z, &entry.w};
            *entries[column] = value;
            setBone(hair, bone);
          }};
}

HairTrouble boneScale(const std::string& name, const Vector3d& by) {
  return {name, [=](HairObject& hair, int frame) { setBone(hair, scaled(headAt(frame), by)); }};
}

HairTrouble collider(const std::string& name, const CapsuleCollider& shape) {
  return {name, [=](HairObject& hair, int) { setCollider(hair, shape); }};
}

std::vector<HairTrouble> hairTroubles() {
  std::vector<HairTrouble> all;
  for (const auto& [name, value] : {std::pair<std::string, float>{"NaN", kNan},
                                    {"inf", kInf},
                                    {"-inf", -kInf},
                                    {"1e30", 1e30f},
                                    {"1e12", 1e12f}}) {
    all.push_back(boneEntry("bone rotation " + name, 1, 1, value));
    all.push_back(boneEntry("bone translation " + name, 0, 3, value));
  }
  all.push_back({"every bone entry NaN", [](HairObject& hair, int) {
                   AffineTransform bone;
                   for (Float4& row : bone.rows) row = {kNan, kNan, kNan, kNan};
                   setBone(hair, bone);
                 }});
  all.push_back({"NaN every other frame", [](HairObject& hair, int frame) {
                   AffineTransform bone = headAt(frame);
                   if (frame % 2 == 0) bone.rows[2].x = kNan;
                   setBone(hair, bone);
                 }});
  all.push_back(boneScale("mirrored bone", {-1, 1, 1}));
  all.push_back(boneScale("bone turned inside out", {-1, -1, -1}));
  all.push_back(boneScale("bone without scale", {0, 0, 0}));
  all.push_back(boneScale("flat bone", {1, 0, 1}));
  all.push_back(boneScale("line of a bone", {0, 1, 0}));
  all.push_back(boneScale("tiny bone", {1e-20, 1e-20, 1e-20}));
  all.push_back(boneScale("uneven bone", {1e3, 1, 1e-3}));
  all.push_back({"teleports of 100 m", [](HairObject& hair, int frame) {
                   AffineTransform bone = headAt(frame);
                   bone.rows[frame % 3].w += frame % 2 == 0 ? 100.0f : -100.0f;
                   setBone(hair, bone);
                 }});
  const Float3 near = {0, -0.1f, 0}, nowhere = {kNan, 0, 0}, away = {0, kInf, 0};
  all.push_back(collider("collider at NaN", {.head = nowhere, .headRadius = 1, .tail = near}));
  all.push_back(collider("collider from infinity", {.head = near, .headRadius = 1, .tail = away}));
  all.push_back(
      collider("collider of NaN radius", {.head = near, .headRadius = kNan, .tail = near}));
  all.push_back(collider("collider of negative radius",
                         {.head = near, .headRadius = -1, .tail = near, .tailRadius = -1}));
  all.push_back(collider("collider of NaN friction", sphereCollider(near, 0.1f, kNan)));
  all.push_back(collider("collider that spins by NaN", {.head = near,
                                                        .headRadius = 0.1f,
                                                        .tail = near,
                                                        .tailRadius = 0.1f,
                                                        .friction = 1,
                                                        .angularVelocity = nowhere}));
  all.push_back(collider("collider that spins fast", {.head = near,
                                                      .headRadius = 0.1f,
                                                      .tail = near,
                                                      .tailRadius = 0.1f,
                                                      .friction = 1,
                                                      .angularVelocity = {1e30f, 0, 0}}));
  all.push_back(collider("point collider", {.head = near, .tail = near}));
  all.push_back(collider("collider around everything", sphereCollider(near, 50)));
  all.push_back(collider("huge collider", sphereCollider(near, 1e15f)));
  all.push_back(collider("cone with its apex in the hair",
                         {.head = near, .headRadius = 0, .tail = {0, 1, 0}, .tailRadius = 2}));
  all.push_back({"64 colliders in one place", [=](HairObject& hair, int) {
                   hair.setColliders(
                       std::vector<CapsuleCollider>(64, sphereCollider(near, 0.1f, 1)));
                 }});
  all.push_back({"collider that jumps", [=](HairObject& hair, int frame) {
                   const float x = frame % 2 == 0 ? 1e6f : 0;
                   setCollider(hair, sphereCollider({x, 0, 0}, 0.2f));
                 }});
  all.push_back(
      {"gravity of 1e30", [](HairObject& hair, int) { hair.settings.gravity.z = 1e30f; }});
  all.push_back(
      {"wind of 1e30", [](HairObject& hair, int) { hair.settings.wind.velocity.z = 1e30f; }});
  all.push_back({"resets", [](HairObject& hair, int) { hair.reset(); }});
  return all;
}

class BadInput : public StressTest {
 protected:
  BadInput() { makeHairReturnSoon(); }
  void expectSane(const HairAsset& asset, const HairObject& hair, const std::string& when) {
    const std::vector<Float4> positions = run_.positions(hair);
    ASSERT_TRUE(allFinite(positions)) << hair.name() << ", " << when;
    ASSERT_TRUE(allFinite(run_.read(hair.buffers().tangents))) << hair.name() << ", " << when;
    double size = 0;
    for (const Float4& p : positions)
      keepLargest(size, toVector(p).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    for (uint32_t s = 0; s < asset.strandCount; ++s)
      ASSERT_LT(stretchOf(asset, positions, s, 1e-4 * size), 0.01) << hair.name() << ", " << when;
  }
};

TEST_P(BadInput, IsSurvivedAndForgottenWithinASecond) {
  const HairAsset asset = wavyAsset(7, 12);
  const std::vector<HairTrouble> all = hairTroubles();
  const HairId calm = add(asset, {.name = "untouched", .settings = settings_});
  std::vector<HairId> ids;
  for (const HairTrouble& trouble : all)
    ids.push_back(add(asset, {.name = trouble.name, .settings = settings_}));
  for (int frame = 0; frame < kCalmFrames + kTroubledFrames + kForgettingFrames; ++frame) {
    const bool bad = frame >= kCalmFrames && frame < kCalmFrames + kTroubledFrames;
    setBone(run_.scene.hair(calm), headAt(frame));
    for (size_t i = 0; i < all.size(); ++i) {
      HairObject& hair = run_.scene.hair(ids[i]);
      hair.settings = settings_;
      hair.setColliders({});
      setBone(hair, headAt(frame));
      if (bad) all[i].make(hair, frame);
    }
    run_.step();
    const int since = frame - kCalmFrames;
    if (since < 0 || since > kTroubledFrames + 3) continue;
    for (const HairId id : ids)
      expectSane(asset, run_.scene.hair(id), "bad frame " + std::to_string(since));
  }
  const std::vector<Float4> untouched = run_.positions(run_.scene.hair(calm));
  double worst = 0;
  for (const HairId id : ids) {
    const HairObject& hair = run_.scene.hair(id);
    expectSane(asset, hair, "at the end");
    const std::vector<Float4> positions = run_.positions(hair);
    const double off = maxDistance(positions, untouched);
    EXPECT_LT(off, 3e-4) << hair.name() << ", metres, of strands of 0.3 m";
    keepLargest(worst, off);
  }
  printFigure("bad input, " + label() + ": " + std::to_string(all.size()) +
                  " kinds, largest distance to untouched hair after 60 frames [mm]",
              1000 * worst);
}

TEST_P(BadInput, StepsOfAnyLengthAreSurvivedAndForgotten) {
  const HairAsset asset = wavyAsset(7, 12);
  HairObject& hair = run_.scene.hair(add(asset, {.settings = settings_}));
  SceneRun calm(api());
  HairObject& untouched = calm.add(asset, {.settings = settings_});
  int frame = 0;
  const auto advance = [&](SceneRun& run, HairObject& object, float dt) {
    setBone(object, headAt(frame));
    run.step(dt);
  };
  for (; frame < kCalmFrames; ++frame) {
    advance(run_, hair, 1.0f / 60);
    advance(calm, untouched, 1.0f / 60);
  }
  const std::vector<Float4> before = run_.positions(hair);
  run_.step(0);
  EXPECT_EQ(run_.positions(hair), before) << "a frame of no time moves nothing";
  run_.step(1e-6f);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LT(distance(run_.positions(hair)[i], before[i]), 1e-3);
  for (const float dt : {1.0f, 1e-6f, 0.0f, 1.0f, 1e-6f, 1e-6f, 1e-9f, 1.0f / 60, 1e-12f, 1e-20f,
                         1e-38f, 1e-45f, 1e6f, 1.0f / 60}) {
    advance(run_, hair, dt);
    expectSane(asset, hair, "after a step of " + std::to_string(dt) + " s");
  }
  for (; frame < kCalmFrames + kForgettingFrames; ++frame) {
    advance(run_, hair, 1.0f / 60);
    advance(calm, untouched, 1.0f / 60);
  }
  const std::vector<Float4> a = run_.positions(hair), b = calm.positions(untouched);
  const double worst = maxDistance(a, b);
  EXPECT_LT(worst, 3e-4);
  printFigure("steps of 0, 1e-45 to 1e6 s, " + label() +
                  ": distance to untouched hair after 60 frames [mm]",
              1000 * worst);
}

/// A groom that is odd in one way.
struct Odd {
  std::string name;
  HairAsset asset;
  bool keepsLength = true;  ///< what is held in several places may be too far apart
};

std::vector<Odd> oddGrooms() {
  std::vector<Odd> all;
  const auto add = [&](const std::string& name, HairAsset asset, bool keepsLength = true) {
    expectOk(asset.process());
    all.push_back({name, std::move(asset), keepsLength});
  };
  add("one strand", wavyAsset(1, 9));
  add("two vertices", wavyAsset(5, 2));
  add("three vertices", wavyAsset(5, 3));
  add("256 vertices", wavyAsset(2, 256));
  add("mass 0 in the middle", wavyAsset(5, 9, 1, {4}), false);
  add("mass 0 at the tip", wavyAsset(5, 9, 1, {8}), false);
  add("mass 0 everywhere", wavyAsset(5, 9, 1, {2, 3, 4, 5, 6, 7, 8}), false);
  add("mass 0 at every other vertex", wavyAsset(5, 9, 1, {3, 5, 7}), false);
  HairAsset heavy = wavyAsset(5, 9);
  for (size_t i = 0; i < heavy.positions.size(); ++i)
    if (i % 9 > 1) heavy.positions[i].w = i % 2 == 0 ? 1e30f : 1e-30f;
  add("masses of 1e-30 and 1e30", heavy);
  HairAsset point = wavyAsset(5, 9);
  for (size_t i = 0; i < point.positions.size(); ++i) {
    const Float4 root = point.positions[i - i % 9];
    point.positions[i] = {root.x, root.y, root.z, point.positions[i].w};
  }
  add("all vertices in one place", point);
  HairAsset gaps = wavyAsset(5, 9);
  for (size_t i = 0; i < gaps.positions.size(); ++i) {
    if (i % 9 != 1 && i % 9 != 5 && i % 9 != 8) continue;
    const Float4& before = gaps.positions[i - 1];
    gaps.positions[i] = {before.x, before.y, before.z, gaps.positions[i].w};
  }
  add("coincident neighbours, at root and tip, too", gaps);
  HairAsset fold = wavyAsset(5, 9);
  for (size_t i = 0; i < fold.positions.size(); ++i) {
    const Float4& root = fold.positions[i - i % 9];
    fold.positions[i].x = root.x;
    fold.positions[i].y = root.y + (i % 2 == 0 ? 0.0f : 0.05f);
    fold.positions[i].z = root.z;
  }
  add("folded back onto itself", fold);
  return all;
}

TEST_P(BadInput, GroomsMayBeOdd) {
  const std::vector<Odd> all = oddGrooms();
  std::vector<HairId> ids;
  for (const Odd& odd : all)
    ids.push_back(add(odd.asset, {.name = odd.name, .settings = settings_}));
  AffineTransform bone;
  for (int frame = 0; frame < 60; ++frame) {
    bone = headAt(frame);
    for (const HairId id : ids) setBone(run_.scene.hair(id), bone);
    run_.step();
    for (size_t i = 0; i < all.size(); ++i) {
      const HairObject& hair = run_.scene.hair(ids[i]);
      const std::vector<Float4> positions = run_.positions(hair);
      ASSERT_TRUE(allFinite(positions)) << hair.name() << ", frame " << frame;
      ASSERT_TRUE(allFinite(run_.read(hair.buffers().tangents))) << hair.name();
      for (uint32_t s = 0; all[i].keepsLength && s < all[i].asset.strandCount; ++s)
        ASSERT_LT(stretchOf(all[i].asset, positions, s, 5e-5), 0.01) << hair.name();
    }
  }
  // Held vertices are where the bones have them.
  double worst = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    const HairAsset& asset = all[i].asset;
    const std::vector<Float4> positions = run_.positions(run_.scene.hair(ids[i]));
    for (size_t v = 0; v < positions.size(); ++v) {
      if (asset.inverseMasses[v] > 0) continue;
      const Float4& p = asset.positions[v];
      Float4 target;
      float* out[] = {&target.x, &target.y, &target.z};
      for (int row = 0; row < 3; ++row) {
        const Float4& r = bone.rows[row];
        *out[row] = r.x * p.x + r.y * p.y + r.z * p.z + r.w;
      }
      keepLargest(worst, distance(positions[v], target));
    }
  }
  EXPECT_LT(worst, exact() ? 2e-3 : 1e-5) << "the exact solver holds with springs";
  printFigure("held vertices, " + label() + ": largest distance to their place [mm]", 1000 * worst);
}

INSTANTIATE_TEST_SUITE_P(All, BadInput, allSolversOnRuntimes(), solverTestName);

}  // namespace
}  // namespace pelage::test
