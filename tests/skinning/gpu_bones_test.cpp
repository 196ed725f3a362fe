// Bones that an engine has in a buffer on the GPU: hair and meshes follow them as those of the
// host.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pelage/skeleton.h"
#include "stress/stress_run.h"
#include "support/collision_shapes.h"
#include "support/engine_buffer.h"
#include "support/not_numbers.h"
#include "support/scene_list_test.h"

namespace pelage::test {
namespace {

constexpr uint32_t kBones = 3;

using Pose = std::vector<AffineTransform>;

/// Bones that turn against each other while all of them walk along x.
Pose walk(int frame, double speed) {
  Pose pose;
  for (uint32_t bone = 0; bone < kBones; ++bone) {
    const Eigen::AngleAxisd turn(0.3 * std::sin(0.3 * frame + bone),
                                 Vector3d(1, 2, -0.5 + bone).normalized());
    pose.push_back(
        toTransform(turn.toRotationMatrix(), {speed * frame / 60, 0.01 * frame, 0.02 * bone}));
  }
  return pose;
}

AffineTransform placementOf(const Pose& pose) {
  AffineTransform placement;
  for (int row = 0; row < 3; ++row) placement.rows[row].w = pose[0].rows[row].w;
  return placement;
}

Pose moved(Pose pose, const Float3& by) {
  for (AffineTransform& bone : pose) {
    bone.rows[0].w += by.x;
    bone.rows[1].w += by.y;
    bone.rows[2].w += by.z;
  }
  return pose;
}

std::vector<float> floatsOf(const AffineTransform& bone, BoneLayout layout) {
  const Float4* r = bone.rows;
  if (layout == BoneLayout::kRows)
    return {r[0].x, r[0].y, r[0].z, r[0].w, r[1].x, r[1].y,
            r[1].z, r[1].w, r[2].x, r[2].y, r[2].z, r[2].w};
  if (layout == BoneLayout::kColumns)
    return {r[0].x, r[1].x, r[2].x, 0, r[0].y, r[1].y, r[2].y, 0,
            r[0].z, r[1].z, r[2].z, 0, r[0].w, r[1].w, r[2].w, 1};
  const DualQuaternion q = toDualQuaternion(bone);
  return {q.real.x, q.real.y, q.real.z, q.real.w, q.dual.x, q.dual.y, q.dual.z, q.dual.w};
}

/// Bones that an engine has on the GPU.
class BonePalette {
 public:
  BonePalette(SceneRun& run, BoneLayout layout, uint32_t stride = 0, uint32_t offset = 0)
      : layout_(layout),
        stride_(stride > 0 ? stride
                           : static_cast<uint32_t>(floatsOf(AffineTransform{}, layout).size())),
        offset_(offset),
        given_{.layout = layout, .stride = stride, .offset = offset},
        buffer_(run, "palette", offset + kBones * stride_) {
    given_.buffer = buffer_.id();
  }
  const BoneBuffer& given() const { return given_; }
  void write(const Pose& pose) {
    std::vector<float> floats(offset_ + kBones * stride_, 4711);
    for (uint32_t bone = 0; bone < kBones; ++bone) {
      const std::vector<float> from = floatsOf(pose[bone], layout_);
      std::copy(from.begin(), from.end(), floats.begin() + offset_ + bone * stride_);
    }
    buffer_.write(floats);
  }

 private:
  BoneLayout layout_;
  uint32_t stride_, offset_;
  BoneBuffer given_;
  EngineBuffer buffer_;
};

class GpuBones : public SolverTest {
 protected:
  GpuBones() : asset_(wavyAsset(40, 8)) {
    for (uint32_t s = 0; s < asset_.strandCount; ++s) {
      const float share = 0.2f + 0.1f * static_cast<float>(s % 7);
      influences_.push_back({{s % kBones, (s + 1) % kBones, 0, 0}, {share, 1 - share, 0, 0}});
    }
  }

  SkeletonId hostSkeleton() { return run_.add(SkeletonDef{.name = "host", .boneCount = kBones}); }
  SkeletonId gpuSkeleton(float deviation = 0.5f) {
    return run_.add(SkeletonDef{
        .name = "gpu", .boneCount = kBones, .source = BoneSource::kBuffer, .deviation = deviation});
  }
  HairObject& addHair(const char* name, SkeletonId skeleton, SkinningMethod method) {
    return run_.add(asset_, {.name = name,
                             .settings = settings_,
                             .skinning = method,
                             .influences = influences_,
                             .skeleton = skeleton});
  }

  /// Two objects of the same hair, one with bones of the host, one with those of the palette.
  struct Pair {
    SkeletonId host, gpu;
    HairObject *expected, *hair;
  };
  Pair addPair(SkinningMethod method = SkinningMethod::kMatrices) {
    const SkeletonId host = hostSkeleton(), gpu = gpuSkeleton();
    HairObject& expected = addHair("expected", host, method);
    return {host, gpu, &expected, &addHair("hair", gpu, method)};
  }
  void setPose(SkeletonId gpu, BonePalette& palette, const Pose& pose) {
    palette.write(pose);
    run_.scene.skeleton(gpu).setBones(palette.given(), placementOf(pose));
  }
  void setPose(const Pair& pair, BonePalette& palette, const Pose& pose) {
    run_.scene.skeleton(pair.host).setBones(pose);
    setPose(pair.gpu, palette, pose);
  }

  HairAsset asset_;
  std::vector<BoneInfluences> influences_;
};

struct Layout {
  BoneLayout layout;
  uint32_t stride, offset;
};

TEST_P(GpuBones, MatricesGiveTheBitsOfThoseOfTheHost) {
  for (const Layout& layout : {Layout{BoneLayout::kRows, 0, 0}, Layout{BoneLayout::kRows, 16, 5},
                               Layout{BoneLayout::kColumns, 0, 3}}) {
    BonePalette palette(run_, layout.layout, layout.stride, layout.offset);
    const Pair pair = addPair();
    HairObject &expected = *pair.expected, &hair = *pair.hair;
    for (int frame = 0; frame < 12; ++frame) {
      // Through several origins; the placement moves the origin at another time than the bones.
      const Pose pose = walk(frame, 30);
      setPose(pair, palette, pose);
      run_.step();
      const auto a = run_.positions(expected), b = run_.positions(hair);
      // States are rounded relative to origins that are up to 1.5 m apart.
      EXPECT_LT(maxDistance(a, b), 5e-5) << "frame " << frame;
      // Where both are relative to the same origin.
      if (frame < 2) {
        EXPECT_TRUE(sameBits(a, b)) << "frame " << frame;
      }
    }
    run_.clear();
  }
}

TEST_P(GpuBones, BonesAreThoseThatTheHostUploads) {
  for (const bool dual : {false, true}) {
    const SkinningMethod method =
        dual ? SkinningMethod::kDualQuaternions : SkinningMethod::kMatrices;
    BonePalette palette(run_, dual ? BoneLayout::kDualQuaternions : BoneLayout::kRows);
    const Pair pair = addPair(method);
    HairObject &expected = *pair.expected, &hair = *pair.hair;
    for (int frame = 0; frame < 4; ++frame) {
      const Pose pose = moved(walk(frame, 0), {dual ? 0.0f : 4.25f, 0, 0});
      setPose(pair, palette, pose);
      run_.step();
      EXPECT_TRUE(sameBits(run_.read(expected.buffers().boneTransforms),
                           run_.read(hair.buffers().boneTransforms)))
          << "frame " << frame << (dual ? ", dual quaternions" : ", matrices");
      EXPECT_TRUE(sameBits(run_.positions(expected), run_.positions(hair))) << "frame " << frame;
    }
    run_.clear();
  }
}

TEST_P(GpuBones, EveryLayoutServesEveryMethodWithinRounding) {
  for (const SkinningMethod method :
       {SkinningMethod::kMatrices, SkinningMethod::kDualQuaternions}) {
    for (const BoneLayout layout :
         {BoneLayout::kRows, BoneLayout::kColumns, BoneLayout::kDualQuaternions}) {
      BonePalette palette(run_, layout, 21, 2);
      const Pair pair = addPair(method);
      HairObject &expected = *pair.expected, &hair = *pair.hair;
      expected.simulated = hair.simulated = false;
      for (const float x : {0.0f, 7.5f}) {
        const Pose pose = moved(walk(5, 0), {x, -x, 2 * x});
        setPose(pair, palette, pose);
        run_.step();
        // A root of a float that is 16 m from 0 is rounded by 1e-6.
        EXPECT_LT(maxDistance(run_.positions(expected), run_.positions(hair)), 1e-5)
            << "layout " << static_cast<int>(layout) << ", " << x << " m";
      }
      run_.clear();
    }
  }
}

TEST_P(GpuBones, MeshesFollowThem) {
  CollisionMesh plain = toMesh(reference::box({-0.1f, -0.1f, -0.1f}, {0.1f, 0.1f, 0.1f}));
  for (uint32_t v = 0; v < 8; ++v)
    plain.influences.push_back({{v % kBones, (v + 1) % kBones, 0, 0}, {0.75f, 0.25f, 0, 0}});
  BonePalette palette(run_, BoneLayout::kRows);
  const SkeletonId host = hostSkeleton(), gpu = gpuSkeleton(0.1f);
  const Pair pair = {host, gpu, nullptr, nullptr};
  addHair("hair", host, SkinningMethod::kMatrices);
  const ColliderId a = run_.add(plain, {.name = "a", .cellSize = 0.02f, .skeleton = host});
  const ColliderId b = run_.add(plain, {.name = "b", .cellSize = 0.02f, .skeleton = gpu});
  for (int frame = 0; frame < 5; ++frame) {
    const Pose pose = walk(frame, 1);
    setPose(pair, palette, pose);
    run_.step();
    const auto expected = run_.read<float>(run_.scene.collider(a).buffers().vertices);
    const auto vertices = run_.read<float>(run_.scene.collider(b).buffers().vertices);
    EXPECT_TRUE(sameBits(expected, vertices)) << "frame " << frame;
    EXPECT_EQ(countPasses(run_.list(), "skin_vertices"), 2u);
    EXPECT_EQ(countPasses(run_.list(), "convert_bones"), 1u);
  }
  run_.step();
  EXPECT_EQ(countPasses(run_.list(), "skin_vertices"), 0u) << "nothing has moved";
}

TEST_P(GpuBones, ShiftsOfTheWorldAreNotNoticed) {
  BonePalette palette(run_, BoneLayout::kRows);
  const Pair pair = addPair();
  HairObject &expected = *pair.expected, &hair = *pair.hair;
  const Float3 shift = {3, -2, 11};
  Float3 from = {};
  for (int frame = 0; frame < 8; ++frame) {
    if (frame == 4) {
      expectOk(run_.scene.shiftOrigin(shift));
      from = {-shift.x, -shift.y, -shift.z};
    }
    // On binary fractions, which a shift does not round.
    Pose pose = walk(0, 0);
    for (AffineTransform& bone : pose)
      bone.rows[0].w = 0.125f * static_cast<float>(frame), bone.rows[1].w = bone.rows[2].w = 0.25f;
    pose = moved(pose, from);
    setPose(pair, palette, pose);
    run_.step();
    EXPECT_TRUE(sameBits(run_.positions(expected), run_.positions(hair))) << "frame " << frame;
  }
  expectOk(run_.scene.shiftOrigin({-shift.x, -shift.y, -shift.z}));
}

// Where the origin of bones is no float: 3 km away, what floats leave of it is up to 0.06 mm.
TEST_P(GpuBones, OriginsThatAreNoFloatsAreExact) {
  // The sums are no floats.
  const Float3 shifts[] = {{-3000.3f, 0.7f, 1234.1f}, {0.1f, 0.01f, -0.03f}};
  const Float3 shift = {shifts[0].x + shifts[1].x, shifts[0].y + shifts[1].y,
                        shifts[0].z + shifts[1].z};
  BonePalette palette(run_, BoneLayout::kRows);
  const Pair pair = addPair();
  HairObject &expected = *pair.expected, &hair = *pair.hair;
  for (const Float3& by : shifts) expectOk(run_.scene.shiftOrigin(by));
  const Pose pose = moved(walk(3, 0), {-shift.x, -shift.y, -shift.z});
  setPose(pair, palette, pose);
  run_.step();
  const auto a = run_.read(expected.buffers().boneTransforms);
  const auto b = run_.read(hair.buffers().boneTransforms);
  ASSERT_EQ(a.size(), b.size());
  double off = 0;
  for (size_t i = 0; i < a.size(); ++i)
    keepLargest(off, std::abs(static_cast<double>(a[i].w) - static_cast<double>(b[i].w)));
  EXPECT_LT(off, 1e-6);
  for (const Float3& by : shifts) expectOk(run_.scene.shiftOrigin({-by.x, -by.y, -by.z}));
}

TEST_P(GpuBones, TeleportsTakeHairAlong) {
  BonePalette palette(run_, BoneLayout::kRows);
  const SkeletonId host = hostSkeleton(), gpu = gpuSkeleton();
  const HairObject& expected = addHair("expected", host, SkinningMethod::kMatrices);
  const HairId first = run_.lastHair();
  const HairObject& hair = addHair("hair", gpu, SkinningMethod::kMatrices);
  const HairId second = run_.lastHair();
  const Pair pair = {host, gpu, nullptr, nullptr};
  AffineTransform jump;
  jump.rows[0].w = 32;
  for (int frame = 0; frame < 6; ++frame) {
    Pose pose = walk(frame, 0);
    if (frame >= 3) pose = moved(pose, {32, 0, 0});
    if (frame == 3) {
      expectOk(run_.scene.teleport(first, jump));
      expectOk(run_.scene.teleport(second, jump));
    }
    setPose(pair, palette, pose);
    run_.step();
    EXPECT_TRUE(sameBits(run_.positions(expected), run_.positions(hair))) << "frame " << frame;
  }
}

TEST_P(GpuBones, BrokenBonesLeaveRootsWhereTheyWere) {
  for (const SkinningMethod method :
       {SkinningMethod::kMatrices, SkinningMethod::kDualQuaternions}) {
    BonePalette palette(run_, BoneLayout::kRows);
    const SkeletonId gpu = gpuSkeleton();
    const HairObject& hair = addHair("hair", gpu, method);
    Pose pose = walk(3, 0);
    const auto step = [&] {
      setPose(gpu, palette, pose);
      run_.step();
    };
    step();
    const auto before = run_.positions(hair);
    pose = walk(4, 0);
    pose[1].rows[2].y = kNan;
    step();
    const auto after = run_.positions(hair);
    EXPECT_TRUE(allFinite(after));
    for (uint32_t s = 0; s < asset_.strandCount; ++s) {
      const bool broken = influences_[s].bones[0] == 1 || influences_[s].bones[1] == 1;
      const size_t root = size_t{s} * asset_.verticesPerStrand;
      EXPECT_EQ(before[root] == after[root], broken) << "strand " << s;
    }
    run_.clear();
  }
}

TEST_P(GpuBones, HairSleepsUntilTheyMove) {
  if (!exact()) return;
  // Everything is slow enough to sleep.
  settings_.sleep = {.enabled = true, .speed = 1e6f, .time = 0};
  settings_.wind = {};
  BonePalette palette(run_, BoneLayout::kRows);
  const SkeletonId gpu = gpuSkeleton();
  const HairObject& hair = addHair("hair", gpu, SkinningMethod::kMatrices);
  const auto awake = [&] { return run_.awake(hair); };
  Pose pose = walk(0, 0);
  setPose(gpu, palette, pose);
  for (int frame = 0; frame < 20 && (frame < 5 || awake() > 0); ++frame) run_.step();
  ASSERT_EQ(awake(), 0u) << "it does not come to rest";
  // The same bones, written again: the passes run, and nothing wakes.
  setPose(gpu, palette, pose);
  run_.step();
  EXPECT_EQ(countPasses(run_.list(), "convert_bones"), 1u);
  EXPECT_EQ(awake(), 0u);
  pose = moved(pose, {0.05f, 0, 0});
  palette.write(pose);
  run_.step();
  EXPECT_EQ(awake(), 0u) << "nobody has said that the buffer changed";
  run_.scene.skeleton(gpu).setBones(palette.given(), placementOf(walk(0, 0)));
  run_.step();
  EXPECT_EQ(awake(), asset_.strandCount) << "the placement is the same, and the bones are not";
}

INSTANTIATE_TEST_SUITE_P(Apis, GpuBones, testing::ValuesIn(solversOnApis()), solverTestName);

// ---- without a device

class GpuBonesList : public SceneListTest {
 protected:
  void expectRefused(const char* what) { SceneListTest::expectRefused({what, "'gpu'"}); }
  SkeletonPose& addSkeleton(const SkeletonDef& def) {
    id_ = *scene_.addSkeleton(def);
    return scene_.skeleton(id_);
  }
  BufferId addBuffer(uint64_t floats) {
    return scene_.resources().add(
        {.name = "palette", .size = floats * sizeof(float), .stride = sizeof(float)});
  }

  SkeletonId id_ = SkeletonId::kInvalid;
};

TEST_F(GpuBonesList, HasAPassForEachMethodInFramesInWhichTheyChanged) {
  SkeletonPose& skeleton =
      addSkeleton({.name = "gpu", .boneCount = 70, .source = BoneSource::kBuffer});
  ASSERT_TRUE(scene_.addHair(makeAsset(), {.skeleton = id_}));
  ASSERT_TRUE(scene_.addHair(makeAsset(), {.skeleton = id_}));
  skeleton.setBones({.buffer = addBuffer(70 * 12)}, {});
  simulate();
  EXPECT_EQ(count("convert_bones"), 1u) << "two objects of one method";
  EXPECT_EQ(count("skin_roots"), 2u);
  EXPECT_EQ(scene_.skeleton(id_).bones().size(), 0u);
  EXPECT_EQ(scene_.skeleton(id_).boneCount(), 70u);
  for (int frame = 0; frame < 3; ++frame) simulate();
  EXPECT_EQ(count("convert_bones") + count("skin_roots"), 0u) << "at rest";
  ASSERT_TRUE(
      scene_.addHair(makeAsset(), {.skinning = SkinningMethod::kDualQuaternions, .skeleton = id_}));
  skeleton.setBones({.buffer = addBuffer(70 * 12)}, {});
  simulate();
  EXPECT_EQ(count("convert_bones"), 2u);
  EXPECT_EQ(count("skin_roots"), 3u);
}

TEST_F(GpuBonesList, OfAFrameThatDoesNotRunAreReadAgain) {
  SkeletonPose& skeleton = addSkeleton({.name = "gpu", .source = BoneSource::kBuffer});
  ASSERT_TRUE(scene_.addHair(makeAsset(), {.skeleton = id_}));
  const BufferId buffer = addBuffer(12);
  skeleton.setBones({.buffer = buffer}, {});
  for (int frame = 0; frame < 4; ++frame) simulate();
  skeleton.setBones({.buffer = buffer}, {});
  simulate(1.0f / 60, false);
  EXPECT_EQ(count("convert_bones"), 1u);
  simulate();
  EXPECT_EQ(count("convert_bones"), 1u);
  EXPECT_EQ(count("skin_roots"), 1u);
}

TEST_F(GpuBonesList, ViewsSeeHairAsFarFromThePlacementAsItMayBe) {
  for (const float deviation : {0.5f, 4.0f}) {
    SkeletonPose& skeleton =
        addSkeleton({.name = "gpu", .source = BoneSource::kBuffer, .deviation = deviation});
    const auto hair = required(scene_.addHair(makeAsset(), {.skeleton = id_}));
    const AffineTransform placement = rigidTransform({0, 0, 0, 1}, {6, 0, 0});
    skeleton.setBones({.buffer = addBuffer(12)}, placement);
    simulate();
    for (const float x : {0.0f, 3.0f, 6.0f, 9.0f}) {
      View view;
      view.eye = {x, 0, 1};
      view.worldToClip = lookAt(view.eye, {x, 0, 0}, {0, 1, 0}, 0.4f, 1, 0.1f, 10);
      view.width = view.height = 16;
      PassList drawn;
      ASSERT_TRUE(scene_.draw(view, {}, drawn));
      EXPECT_EQ(!drawn.passes.empty(), std::abs(x - 6) < deviation) << x << ", " << deviation;
    }
    ASSERT_TRUE(scene_.removeHair(*hair));
  }
}

TEST_F(GpuBonesList, WhatIsWrongIsNamed) {
  const auto expectNoSkeleton = [&](const SkeletonDef& def, const char* what) {
    expectError(scene_.addSkeleton(def), what);
  };
  expectNoSkeleton({.source = BoneSource::kBuffer, .deviation = kNan}, "deviation");
  expectNoSkeleton({.source = BoneSource::kBuffer, .deviation = -1}, "deviation");
  expectNoSkeleton({.source = BoneSource{9}}, "SkeletonDef::source is 9");
  expectNoSkeleton({.source = BoneSource::kSurface}, "SkeletonDef::surface");
  SkeletonPose& skeleton =
      addSkeleton({.name = "gpu", .boneCount = 3, .source = BoneSource::kBuffer});
  simulate();  // nothing follows it
  ASSERT_TRUE(scene_.addHair(makeAsset(), {.skeleton = id_}));
  expectRefused("has no bones yet");
  skeleton.setBones({.buffer = addBuffer(35)}, {});
  expectRefused("has 140 bytes; 3 of them take 144");
  const BufferId buffer = addBuffer(36);
  skeleton.setBones({.buffer = buffer, .offset = 1}, {});
  expectRefused("take 148");
  skeleton.setBones({.buffer = buffer, .stride = 11}, {});
  expectRefused("stride is 11, but a bone has 12 floats");
  skeleton.setBones({.buffer = buffer, .layout = BoneLayout{7}}, {});
  expectRefused("no BoneLayout");
  skeleton.setBones({.buffer = buffer}, {});
  simulate();
  scene_.resources().remove(buffer);
  expectRefused("does not exist");
}

}  // namespace
}  // namespace pelage::test
