// A scene in use: every parameter changes in every frame, objects come and go.

#include "pelage/random.h"
#include "pelage/skeleton.h"
#include "reference/sdf/mesh_shapes.h"
#include "stress/stress_run.h"
#include "support/collision_shapes.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

constexpr int kUsedFrames = 120;

/// Draws numbers within the ranges that the headers name.
struct Dice {
  pelage::Random random;
  float between(float low, float high) { return low + (high - low) * random.uniform(); }
  /// 0 and 1 are taken, too, because they leave code out.
  float share() {
    const uint32_t kind = random.below(8);
    return kind < 2 ? static_cast<float>(kind) : random.uniform();
  }
  bool coin() { return random.below(2) == 1; }
  Float3 vector(float size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
};

void change(ParameterCurve& curve, Dice& dice) {
  for (float& value : curve) value = dice.between(0, 3);
}

/// \param structure  also what other permutations and buffers follow from
void change(SimulationSettings& s, Dice& dice, bool structure) {
  s.gravity = {structure ? dice.between(-20, 20) : 0, dice.between(-20, 20), dice.between(-20, 20)};
  s.damping = structure ? dice.share() : dice.between(0.01f, 1);
  s.bendLength = dice.between(0, 10) * dice.share();
  s.twistRatio = dice.between(0.05f, 10);
  s.subSteps = 1 + dice.random.below(3);
  s.localStiffness = structure ? dice.share() : dice.between(0.1f, 1);
  s.localIterations = 1 + dice.random.below(16);
  s.globalStiffness = structure ? dice.share() : dice.between(0.01f, 1);
  s.globalRange = structure ? dice.share() : dice.between(0.01f, 1);
  s.vspCoefficient = dice.share();
  s.vspThreshold = structure && dice.coin() ? kInf : dice.between(0.1f, 300);
  s.wind.velocity = structure && dice.coin() ? Float3{} : dice.vector(10);
  if (!structure) s.wind.velocity.x = 0;
  s.wind.gustStrength = dice.share();
  s.wind.gustPeriod = dice.between(0.1f, 5);
  s.wind.strandVariation = dice.share();
  s.airDrag = structure && dice.coin() ? 0 : dice.between(0.1f, 5);
  s.lengthIterations = 1 + dice.random.below(16);
  s.maxSpeed = dice.between(0.1f, 100);
  s.sleep.speed = dice.between(0, 0.01f);
  s.sleep.time = dice.share();
  s.sleep.wakeDistance = dice.between(0, 0.01f);
  s.tipSeparation = dice.between(0, 3);
  change(s.curves.stiffness, dice);
  change(s.curves.globalStiffness, dice);
  change(s.curves.damping, dice);
  if (!structure) return;
  s.solver = dice.random.below(8) == 0 ? Solver::kClassic : Solver::kExact;
  s.relaxationTime = dice.share();
  s.sagCompensation = dice.coin() ? 0 : dice.share();
  s.sleep.enabled = dice.coin();
  s.contact.stiffness = dice.coin() ? 0 : dice.share();
  s.contact.friction = dice.coin() ? 0 : dice.share();
  s.contact.cellSize = dice.between(5e-3f, 0.1f);
}

void change(StrandMaterial& m, Dice& dice) {
  const auto color = [&] { return Float3{dice.share(), dice.share(), dice.share()}; };
  m.rootColor = color();
  m.tipColor = color();
  m.colorVariation = dice.share();
  m.opacity = dice.share();
  m.fiberRadius = dice.between(1e-6f, 1e-3f);
  m.tipRadiusRatio = dice.share();
  m.model = dice.coin() ? ShadingModel::kKajiyaKay : ShadingModel::kFiber;
  m.ambientStrength = dice.share();
  m.diffuseStrength = dice.share();
  m.primaryStrength = dice.between(0, 3);
  m.primaryExponent = dice.between(1, 200);
  m.primaryShift = dice.between(-0.3f, 0.3f);
  m.secondaryStrength = dice.between(0, 3);
  m.secondaryExponent = dice.between(1, 200);
  m.secondaryShift = dice.between(-0.3f, 0.3f);
  m.secondaryTint = dice.share();
  m.longitudinalRoughness = dice.share();
  m.azimuthalRoughness = dice.share();
  m.cuticleTilt = dice.between(-0.2f, 0.2f);
  m.refractiveIndex = dice.between(1.01f, 3);
  m.scatteredShare = dice.share();
  m.multipleScattering = dice.share();
}

void change(HairObject& hair, Dice& dice, bool structure) {
  change(hair.settings, dice, structure);
  change(hair.material, dice);
  hair.simulatedShare = dice.share();
  hair.drawnShare = dice.share();
  hair.drawnStrands = dice.random.below(hair.strandCount() + 1);
  hair.visible = dice.random.below(8) != 0;
  if (structure) hair.usesMeshColliders = dice.coin();
  if (structure) hair.tracksMotion = dice.coin();
  hair.interpolates = hair.tracksMotion && hair.usesMeshColliders;
  std::vector<CapsuleCollider> capsules(structure ? dice.random.below(4) : 1);
  for (CapsuleCollider& capsule : capsules) {
    capsule = {.head = dice.vector(0.3f),
               .headRadius = dice.between(0, 0.1f),
               .tail = dice.vector(0.3f),
               .tailRadius = dice.between(0, 0.1f),
               .friction = dice.share()};
    // Always in reach.
    if (!structure) capsule.head = {0, 0, 0};
  }
  hair.setColliders(capsules);
  if (structure && dice.random.below(20) == 0) hair.reset();
}

void change(SdfCollider& collider, Dice& dice, bool structure) {
  collider.margin = dice.between(0, 0.01f);
  collider.friction = dice.between(0, 2);
  if (structure) collider.enabled = dice.random.below(4) != 0;
}

AffineTransform randomPose(Dice& dice) {
  const Quaternion turn = {dice.between(-0.2f, 0.2f), dice.between(-0.2f, 0.2f),
                           dice.between(-0.2f, 0.2f), 1};
  return rigidTransform(turn, dice.vector(0.1f));
}

/// All that a list names is there and large enough.
void expectValid(const PassList& list, const ResourceTable& resources, const std::string& where) {
  const auto fits = [&](BufferId id, uint64_t offset, uint64_t size) {
    const BufferDesc* desc = resources.find(id);
    return desc != nullptr && offset + size <= desc->size;
  };
  for (const Upload& upload : list.uploads) {
    ASSERT_TRUE(fits(upload.buffer, upload.offset, upload.size)) << where;
    ASSERT_LE(upload.dataOffset + upload.size, list.uploadData.size()) << where;
    for (const Upload& other : list.uploads) {
      const bool overlap = &other != &upload && other.buffer == upload.buffer &&
                           other.offset < upload.offset + upload.size &&
                           upload.offset < other.offset + other.size;
      ASSERT_FALSE(overlap) << where << ": two uploads to one place of "
                            << resources.find(upload.buffer)->name;
    }
  }
  for (const Pass& pass : list.passes) {
    if (pass.kind == PassKind::kDispatch) {
      for (const uint32_t groups : pass.groups) {
        ASSERT_GE(groups, 1u) << where << ", " << pass.name;
        ASSERT_LE(groups, 65535u) << where << ", " << pass.name;
      }
    }
    if (pass.kind == PassKind::kDispatchIndirect) {
      ASSERT_TRUE(fits(pass.indirect, pass.indirectOffset, 12)) << where << ", " << pass.name;
    }
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      const bool inside = binding.buffer == BufferId::kInvalid
                              ? binding.offset + binding.size <= list.constants.size()
                              : fits(binding.buffer, binding.offset, binding.size);
      ASSERT_TRUE(inside && binding.size > 0)
          << where << ", " << pass.name << ", entry " << int{binding.entry};
    }
  }
}

struct UsedObjects {
  std::vector<HairId> hairs;
  ColliderId collider = ColliderId::kInvalid;
  SkeletonId skeleton = SkeletonId::kInvalid;
};

/// One object on a skeleton with a collider, one with a bone of its own.
UsedObjects addObjects(Scene& scene, uint32_t strands, const SimulationSettings& settings = {}) {
  UsedObjects crowd;
  crowd.skeleton = *scene.addSkeleton({.boneCount = 1});
  const HairAsset asset = wavyAsset(strands, 9);
  const std::vector<FollowHair> follows =
      valueOf(asset.generateFollowHairs({.countPerGuide = 3, .maxRadius = 0.02f}));
  HairDef def = {.settings = settings,
                 .skeleton = crowd.skeleton,
                 .levelOfDetail = true,
                 .followHairs = follows,
                 .collidingHair = CollidingHair::kGuidesAndFollows};
  crowd.hairs.push_back(*scene.addHair(asset, def));
  def.skeleton = SkeletonId::kInvalid;
  def.skinning = SkinningMethod::kDualQuaternions;
  crowd.hairs.push_back(*scene.addHair(asset, def));
  const CollisionMesh mesh = toMesh(reference::sphere(0.08f, 8, 10, {0, -0.12f, 0}));
  crowd.collider = *scene.addCollider(mesh, {.cellSize = 0.02f, .skeleton = crowd.skeleton});
  return crowd;
}

void removeObjects(Scene& scene, const UsedObjects& crowd) {
  for (const HairId id : crowd.hairs) EXPECT_TRUE(scene.removeHair(id));
  EXPECT_TRUE(scene.removeCollider(crowd.collider));
  expectOk(scene.removeSkeleton(crowd.skeleton));
}

void changeAll(Scene& scene, const UsedObjects& crowd, Dice& dice, bool structure) {
  for (const HairId id : crowd.hairs) change(scene.hair(id), dice, structure);
  change(scene.collider(crowd.collider), dice, structure);
  const AffineTransform pose = randomPose(dice);
  setBone(scene.skeleton(crowd.skeleton), pose);
  setBone(scene.hair(crowd.hairs[1]), pose);
  if (!structure) return;
  if (dice.coin())
    scene.hair(crowd.hairs[0]).useAllMeshColliders();
  else
    scene.hair(crowd.hairs[0]).setMeshColliders({&crowd.collider, dice.coin() ? 1u : 0u});
}

TEST(RuntimeUse, EveryParameterMayChangeInEveryFrame) {
  Scene scene;
  Dice dice{pelage::Random(5)};
  const UsedObjects crowd = addObjects(scene, 7);
  View view;
  view.worldToClip = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 1, 1, 0.1f, 10);
  view.eye = {0, 0, 1};
  view.width = view.height = 40;
  const Transparency methods[] = {Transparency::kAlphaTest, Transparency::kStochastic,
                                  Transparency::kWindowed,  Transparency::kHybrid4,
                                  Transparency::kHybrid8,   Transparency::kHybrid16,
                                  Transparency::kShortCut,  Transparency::kTiles};
  std::vector<PassList> lists(1);
  for (int frame = 0; frame < kUsedFrames; ++frame) {
    const std::string where = "frame " + std::to_string(frame);
    changeAll(scene, crowd, dice, true);
    PassList list;
    const Result<void> done = scene.simulate(dice.between(0, 0.05f), list);
    ASSERT_TRUE(done) << where << ": " << done.error().message;
    expectValid(list, scene.resources(), where);
    // One of three frames does not run.
    scene.finish(list);
    if (frame % 3 != 0) setDelivered(list.run);
    Light light;
    light.shadow = static_cast<HairShadow>(dice.random.below(3));
    lists[0].clear();
    const Result<void> drawn =
        scene.draw(view, {&light, 1}, {.method = methods[dice.random.below(8)]}, lists);
    ASSERT_TRUE(drawn) << where << ": " << drawn.error().message;
    for (const PassList& part : lists) expectValid(part, scene.resources(), where + ", drawing");
    scene.setTier(kTiers[dice.random.below(3)]);
    PassList depth;
    const Result<void> written = scene.drawDepth(
        view, {.opacity = dice.share(), .color = static_cast<HairDepthColor>(dice.random.below(3))},
        depth);
    ASSERT_TRUE(written) << where << ": " << written.error().message;
    expectValid(depth, scene.resources(), where + ", depth");
  }
  removeObjects(scene, crowd);
  EXPECT_EQ(scene.resources().count(), 0u);
}

class RuntimeUseOnGpu : public StressTest {};

TEST_P(RuntimeUseOnGpu, StaysFiniteAndGivesItsMemoryBack) {
  const int rounds = fullStress() ? 8 : 2;
  const uint64_t before = run_.device()->bufferBytes();
  Dice dice{pelage::Random(7)};
  for (int round = 0; round < rounds; ++round) {
    const UsedObjects crowd = addObjects(run_.scene, 5, settings_);
    for (int frame = 0; frame < kUsedFrames / rounds; ++frame) {
      changeAll(run_.scene, crowd, dice, fullStress());
      run_.step(dice.between(0.001f, fullStress() ? 0.05f : 1.0f / 60));
      for (const HairId id : crowd.hairs) {
        const HairObject& hair = run_.scene.hair(id);
        ASSERT_TRUE(allFinite(run_.positions(hair))) << "frame " << frame;
        ASSERT_TRUE(allFinite(run_.read(hair.buffers().tangents))) << "frame " << frame;
      }
    }
    const RenderedImage image = run_.render({0, 0, 1}, 32);
    EXPECT_TRUE(allFinite(image.pixels));
    EXPECT_GE(run_.device()->bufferBytes(), before + run_.scene.resources().totalBytes());
    removeObjects(run_.scene, crowd);
    ASSERT_EQ(run_.scene.resources().count(), 0u);
    expectOk(run_.device()->update(run_.scene.resources()));
    EXPECT_EQ(run_.device()->bufferBytes(), before) << "round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RuntimeUseOnGpu, allSolversOnRuntimes(), solverTestName);

}  // namespace
}  // namespace pelage::test
