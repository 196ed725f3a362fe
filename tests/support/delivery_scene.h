// A scene whose every part has a history from frame to frame, and the inputs of its frames, for
// tests of frames that do not run.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "pelage/constants.h"
#include "pelage/scene.h"
#include "pelage/scene_features.h"
#include "pelage/skeleton.h"
#include "support/plain_asset.h"

namespace pelage::test {

/// Two closed boxes, one a bone.
inline CollisionMesh twoBoxes() {
  CollisionMesh mesh;
  const auto addBox = [&](Float3 low, Float3 high, uint32_t bone) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (int i = 0; i < 8; ++i) {
      mesh.positions.push_back({(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                                (i & 4) != 0 ? high.z : low.z});
      mesh.normals.push_back({0, 1, 0});
      BoneInfluences influences = {};
      influences.bones[0] = bone;
      influences.weights[0] = 1;
      mesh.influences.push_back(influences);
    }
    for (const uint32_t corner : {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                  2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5})
      mesh.indices.push_back(first + corner);
  };
  addBox({-0.06f, -0.06f, -0.06f}, {0.12f, -0.01f, 0.06f}, 0);
  addBox({0.04f, 0.02f, 0.01f}, {0.07f, 0.05f, 0.04f}, 1);
  return mesh;
}

/// Hair with bones of its own, hair on a skeleton, and a mesh on the same skeleton.
class DeliveryScene {
 public:
  static constexpr int kFrames = 10;
  static constexpr float kShare = 0.3f;  // of interpolate()
  static constexpr uint32_t kShadowSize = 64;

  /// \param engineInputs  also hair that follows what an engine has on the GPU
  DeliveryScene(Scene& scene, Solver solver, bool engineInputs = false)
      : scene_(scene), started_(scene.time()) {
    SimulationSettings settings;
    settings.solver = solver;
    settings.wind.velocity = {0, 0, 0.5f};
    settings.wind.gustStrength = 0;
    const bool exact = solver == Solver::kExact;
    if (exact) settings.contact.stiffness = 0.3f;
    if (exact) settings.sagCompensation = 0.5f;
    const Result<SkeletonId> skeleton = scene.addSkeleton({.name = "walker", .boneCount = 2});
    EXPECT_TRUE(skeleton);
    skeleton_ = *skeleton;
    std::vector<FollowHair> follows;
    for (uint32_t i = 0; i < 6; ++i) {
      FollowHair follow;
      follow.guide = i;
      follow.offset = {0.004f, 0, 0.003f, 1.5f};
      follows.push_back(follow);
    }
    const Result<HairId> own =
        scene.addHair(makeAsset(40), {.name = "own",
                                      .settings = settings,
                                      .levelOfDetail = exact,
                                      .followHairs = follows,
                                      .collidingHair = CollidingHair::kGuidesAndFollows});
    // It falls asleep as soon as nothing wakes it.
    settings.sleep.speed = 10;
    settings.sleep.time = 0.02f;
    const Result<HairId> worn =
        scene.addHair(makeAsset(9), {.name = "worn",
                                     .settings = settings,
                                     .skinning = SkinningMethod::kDualQuaternions,
                                     .skeleton = skeleton_});
    const Result<ColliderId> mesh =
        scene.addCollider(twoBoxes(), {.name = "mesh", .cellSize = 0.012f, .skeleton = skeleton_});
    EXPECT_TRUE(own && worn && mesh);
    hairs_ = {*own, *worn};
    collider_ = *mesh;
    if (engineInputs) addEngineInputs(settings);
  }
  /// All that its frames use.
  static SceneFeatures features(Solver solver) {
    SceneFeatures features;
    features.settings.clear();
    for (const float globalStiffness : {0.0f, 0.2f}) {
      SimulationSettings settings;
      settings.solver = solver;
      settings.globalStiffness = globalStiffness;
      settings.wind.velocity = {0, 0, 0.5f};
      settings.wind.gustStrength = 0;
      features.settings.push_back(settings);
      settings.contact.stiffness = settings.contact.friction = 0.3f;
      if (solver == Solver::kExact) features.settings.push_back(settings);
    }
    features.collidingFollowHairs = features.levelOfDetail = true;
    features.skinnedHair = features.givenHair = features.originShifts = true;
    features.motion = features.interpolation = true;
    features.transparency = {};
    return features;
  }
  void remove() {
    for (const HairId id : hairs_) EXPECT_TRUE(scene_.removeHair(id));
    EXPECT_TRUE(scene_.removeCollider(collider_));
    EXPECT_TRUE(scene_.removeSkeleton(skeleton_));
    if (palette_ == BufferId::kInvalid) return;
    EXPECT_TRUE(scene_.removeCollider(ground_));
    EXPECT_TRUE(scene_.removeSkeleton(walker_));
    for (const BufferId buffer : {palette_, field_, distances_}) scene_.resources().remove(buffer);
  }

  /// Sets what an application sets before simulate(). Every frame has something else that makes
  /// buffers, history or both: a new origin, a switch of permutations, more capsules, a larger
  /// field, a reset.
  void setInputs(int frame) {
    const auto t = static_cast<float>(frame);
    HairObject& own = scene_.hair(hairs_[0]);
    const bool far = frame >= 3;  // the origin moves
    // It rests in two frames.
    const float turned = frame == 5 || frame == 6 ? 4 : t;
    const AffineTransform bone =
        rigidTransform({0, 0, std::sin(0.03f * turned), std::cos(0.03f * turned)},
                       {far ? 1.7f : 0.0f, 0.01f * turned, 0});
    own.setBones({&bone, 1});
    const float x = far ? 1.7f : 0.0f;
    std::vector<CapsuleCollider> capsules = {{.head = {x - 0.1f, 0.03f + 0.002f * t, -0.1f},
                                              .headRadius = 0.02f,
                                              .tail = {x + 0.4f, 0.03f, 0.1f},
                                              .tailRadius = 0.025f}};
    if (frame >= 4) capsules.push_back(capsules[0]);
    if (frame >= 4) capsules[1].head.y = -0.02f;
    own.setColliders(capsules);
    own.settings.bendLength = frame == 8 ? 0.3f : 0.1f;
    own.settings.globalStiffness = frame >= 2 && frame < 7 ? 0.2f : 0.0f;
    own.settings.globalRange = 1;
    own.settings.subSteps = frame == 6 ? 2 : 1;
    if (own.settings.solver == Solver::kExact) {
      own.settings.contact.friction = frame >= 5 ? 0.3f : 0.0f;
      own.simulatedShare = frame < 2 || frame > 7 ? 1.0f : 0.5f;
    }
    if (frame == 7) own.reset();
    own.simulated = frame != 1 && frame != 2;
    // Simulated, given, and what it was before.
    std::vector<Float3> given(frame == 9 ? size_t{own.guideCount()} * own.verticesPerStrand() : 0);
    for (size_t i = 0; i < given.size(); ++i) given[i] = {1.7f, 0.001f * static_cast<float>(i), 0};
    EXPECT_TRUE(own.setPositions(given));
    own.tracksMotion = frame != 2;
    scene_.hair(hairs_[1]).tracksMotion = frame >= 1;
    own.interpolates = frame >= 3 && frame < 9;
    scene_.hair(hairs_[1]).interpolates = frame >= 2;
    const float shift = frame >= 8 ? 2.0f : 0.0f;
    // First at rest, then one bone alone, then both.
    const float moved = frame == 1 ? 0 : t;
    const AffineTransform pose[2] = {
        rigidTransform({0, 0, 0, 1}, {shift + (frame >= 4 ? 0.004f * moved : 0.0f), 0, 0}),
        rigidTransform({0, 0, 0, 1}, {shift + 0.02f * moved, 0.004f * moved, 0})};
    scene_.skeleton(skeleton_).setBones(pose);
    scene_.collider(collider_).margin = frame == 6 ? 0.002f : 0.001f;
    if (palette_ != BufferId::kInvalid) setEngineInputs(frame);
  }
  static float seconds(int frame) { return frame % 4 == 3 ? 1.0f / 40 : 1.0f / 60; }
  Result<void> simulate(int frame, PassList& list) {
    if (Result<void> done = scene_.simulate(seconds(frame), list); !done) return done;
    if (Result<void> placed = scene_.interpolate(kShare, list); !placed) return placed;
    Light light;
    light.shadow = HairShadow::kDeep;
    light.shadowSize = kShadowSize;
    const Result<uint32_t> maps = scene_.castShadows({&light, 1}, list);
    return maps ? Result<void>() : maps.error();
  }

  /// The same as an object.
  Frame makeFrame(int frame) {
    Result<Frame> made = scene_.simulate(seconds(frame));
    EXPECT_TRUE(made) << made.error().message;
    EXPECT_TRUE(made->interpolate(kShare));
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = kShadowSize};
    EXPECT_TRUE(made->castShadows({&light, 1}));
    return *std::move(made);
  }

  using Results = std::vector<std::vector<std::byte>>;
  /// The layers of texels without hair. \param words of the shadow map
  static void clearUndefined(std::vector<std::byte>& words) {
    constexpr size_t kTexels = size_t{kShadowSize} * kShadowSize;
    const size_t layers = Light().shadowLayers;
    ASSERT_GE(words.size(), kTexels * (1 + layers) * sizeof(uint32_t));
    for (size_t texel = 0; texel < kTexels; ++texel) {
      uint32_t nearest = 0;
      std::memcpy(&nearest, words.data() + texel * sizeof(uint32_t), sizeof(uint32_t));
      const size_t first = (kTexels + texel * layers) * sizeof(uint32_t);
      if (nearest == strand_shadow_view::kNoHair)
        std::fill_n(words.data() + first, layers * sizeof(uint32_t), std::byte{0});
    }
  }
  /// \param read  the bytes of a BufferId
  template <class Read>
  Results readResults(const Read& read) const {
    Results all;
    for (const BufferId buffer : results()) all.push_back(read(buffer));
    clearUndefined(all.back());
    return all;
  }
  /// Buffers with the results of a frame; those of hair(0) come first.
  std::vector<BufferId> results() const {
    std::vector<BufferId> all;
    for (size_t index = 0; index < hairs_.size(); ++index) {
      const std::vector<BufferId> own = resultsOf(index);
      all.insert(all.end(), own.begin(), own.end());
    }
    all.push_back(scene_.sdfKeys());
    all.push_back(scene_.sdfSurface());
    all.push_back(scene_.shadowWords());
    return all;
  }
  std::vector<BufferId> resultsOf(size_t index) const {
    const HairBuffers& buffers = scene_.hair(hairs_[index]).buffers();
    std::vector<BufferId> all;
    for (const BufferId buffer :
         {buffers.positions, buffers.tangents, buffers.contactForces, buffers.followBefore,
          buffers.previousPositions, buffers.drawnPositions, buffers.drawnTangents})
      if (buffer != BufferId::kInvalid) all.push_back(buffer);
    return all;
  }
  double time() const { return scene_.time() - started_; }
  Scene& scene() { return scene_; }
  HairObject& hair(size_t index) { return scene_.hair(hairs_[index]); }
  SdfCollider& collider() { return scene_.collider(collider_); }

 private:
  void addEngineInputs(const SimulationSettings& settings) {
    const auto add = [this](const char* name, const std::vector<float>& floats) {
      return scene_.resources().add(name, floats);
    };
    // A ring of two poses of two bones.
    std::vector<float> bones;
    for (const float x : {0.0f, 0.01f, 0.03f, 0.02f})
      bones.insert(bones.end(), {1, 0, 0, x, 0, 1, 0, -x, 0, 0, 1, 2 * x});
    palette_ = add("palette", bones);
    std::vector<float> field;
    for (int node = 0; node < 8; ++node)
      field.insert(field.end(), {0.5f * static_cast<float>(node), 1, -0.25f, 0.5f});
    field_ = add("field", field);
    // Distances from a plane at 3 cm above node 0.
    distances_ = add("distances", {-0.03f, -0.03f, 0.17f, 0.17f, -0.03f, -0.03f, 0.17f, 0.17f});
    const auto walker = scene_.addSkeleton(
        {.name = "palette", .boneCount = 2, .source = BoneSource::kBuffer, .deviation = 2});
    EXPECT_TRUE(walker);
    walker_ = *walker;
    const auto hair = scene_.addHair(
        makeAsset(12), {.name = "engine's", .settings = settings, .skeleton = walker_});
    const auto ground = scene_.addCollider(
        DenseSdf{.distances = distances_, .grid = {{-0.1f, -0.1f, -0.1f}, 0.2f, {2, 2, 2}}},
        {.name = "ground"});
    EXPECT_TRUE(hair && ground);
    hairs_.push_back(*hair);
    ground_ = *ground;
  }
  void setEngineInputs(int frame) {
    // The placement moves the origin, and the bones are as they were relative to the world.
    AffineTransform placement;
    placement.rows[0].w = frame >= 4 ? 1.8f : 0.0f;
    scene_.skeleton(walker_).setBones({.buffer = palette_, .offset = frame % 3 == 1 ? 24u : 0u},
                                      placement);
    scene_.hair(hairs_[2]).setForceField({.values = frame >= 5 ? field_ : BufferId::kInvalid,
                                          .origin = {-1, -1, -1},
                                          .cellSize = 2,
                                          .nodes = {2, 2, 2}});
    const float height = frame >= 6 ? -0.11f : -0.1f;
    scene_.collider(ground_).setDistances(
        {.distances = distances_, .grid = {{-0.1f, height, -0.1f}, 0.2f, {2, 2, 2}}});
  }

  Scene& scene_;
  double started_;
  SkeletonId skeleton_ = SkeletonId::kInvalid;
  std::vector<HairId> hairs_;
  ColliderId collider_ = ColliderId::kInvalid;
  // Buffers and objects of an engine; kInvalid without.
  BufferId palette_ = BufferId::kInvalid, field_ = BufferId::kInvalid;
  BufferId distances_ = BufferId::kInvalid;
  SkeletonId walker_ = SkeletonId::kInvalid;
  ColliderId ground_ = ColliderId::kInvalid;
};

}  // namespace pelage::test
