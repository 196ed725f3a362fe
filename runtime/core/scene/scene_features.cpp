// Plays a small scene with all features of a program, and keeps its passes.
#include "pelage/scene_features.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "pelage/scene.h"
#include "pelage/skin_table.h"

namespace pelage {
namespace {

constexpr uint32_t kStrands = 2, kVertices = 4;

Result<HairAsset> smallGroom(bool attributes) {
  HairAsset asset;
  asset.strandCount = kStrands;
  asset.verticesPerStrand = kVertices;
  for (uint32_t s = 0; s < kStrands; ++s) {
    for (uint32_t v = 0; v < kVertices; ++v) {
      const float t = 0.01f * static_cast<float>(v);
      asset.positions.push_back({0.01f * static_cast<float>(s) + t * t, t, 0, v < 2 ? 0.0f : 1.0f});
    }
  }
  if (attributes) {
    asset.strandThickness.assign(kStrands, 1);
    asset.strandUv.assign(kStrands, {0.5f, 0.5f});
    asset.vertexColor.assign(asset.positions.size(), {1, 1, 1, 1});
  }
  if (Result<void> processed = asset.process(); !processed) return processed.error();
  return asset;
}

// Two tetrahedra around the tips, each with a bone.
CollisionMesh smallMesh() {
  CollisionMesh mesh;
  for (const uint32_t bone : {0u, 1u}) {
    const float x = 0.1f * static_cast<float>(bone);
    for (const Float3 p : {Float3{-0.02f, 0.02f, -0.02f}, Float3{0.04f, 0.02f, -0.02f},
                           Float3{0.01f, 0.02f, 0.04f}, Float3{0.01f, 0.05f, 0}}) {
      mesh.positions.push_back({p.x + x, p.y, p.z});
      mesh.influences.push_back({{bone, 0, 0, 0}, {1, 0, 0, 0}});
    }
    for (const uint32_t corner : {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0})
      mesh.indices.push_back(4 * bone + corner);
  }
  return mesh;
}

// A triangle with both roots.
SkinTable smallSurface() {
  SurfaceRoot root;
  root.corners[1] = 1;
  root.corners[2] = 2;
  root.barycentric = {1, 0, 0};
  root.bind[1].x = root.bind[2].z = 0.01f;
  SkinTable table;
  table.parts.resize(1);
  table.parts[0].vertexCount = 3;
  table.parts[0].triangleCount = 1;
  table.roots.assign(kStrands, root);
  return table;
}

View smallView(bool reversedDepth) {
  View view;
  view.width = view.height = 8;
  view.eye = {0, 0.02f, 0.5f};
  view.worldToClip = lookAt(view.eye, {0, 0.02f, 0}, {0, 1, 0}, 0.5f, 1, 0.05f, 5, reversedDepth);
  view.reversedDepth = reversedDepth;
  return view;
}

// Kernels, constants and state: what a pipeline is made from.
std::string pipelineOf(const PassList& list, const Pass& pass) {
  std::string key;
  const auto add = [&key](uint64_t value) {
    for (int shift = 0; shift < 64; shift += 8)
      key += static_cast<char>(value >> static_cast<unsigned>(shift) & 0xffu);
  };
  add(pass.kernel->hash);
  add(pass.pixel != nullptr ? pass.pixel->hash : 0);
  const DrawState& s = pass.state;
  for (const auto part : {static_cast<uint64_t>(s.topology), static_cast<uint64_t>(s.depthCompare),
                          static_cast<uint64_t>(s.depthWrite), static_cast<uint64_t>(s.blend),
                          static_cast<uint64_t>(s.colorWrite)})
    add(pass.pixel != nullptr ? part : 0);
  for (const SpecValue& value : list.specValuesOf(pass)) {
    add(value.id);
    add(value.bits);
  }
  return key;
}

// The first pass of each pipeline of lists.
class KeptPasses {
 public:
  void take(const PassList& list) {
    for (Pass pass : list.passes) {
      if (!known_.insert(pipelineOf(list, pass)).second) continue;
      const auto bindings = list.bindingsOf(pass);
      const auto values = list.specValuesOf(pass);
      pass.firstBinding = static_cast<uint32_t>(all_.bindings.size());
      pass.firstSpecValue = static_cast<uint32_t>(all_.specValues.size());
      pass.firstBarrier = pass.barrierCount = 0;
      all_.bindings.insert(all_.bindings.end(), bindings.begin(), bindings.end());
      all_.specValues.insert(all_.specValues.end(), values.begin(), values.end());
      all_.passes.push_back(pass);
    }
  }

  // Passes that do not draw come first.
  PassList list() && {
    std::stable_partition(all_.passes.begin(), all_.passes.end(),
                          [](const Pass& pass) { return !isDraw(pass.kind); });
    return std::move(all_);
  }

 private:
  PassList all_;
  std::set<std::string> known_;
};

// Hair of all kinds that a program has, and buffers for it.
class SmallScene {
 public:
  explicit SmallScene(const SceneFeatures& features) : features_(features) {
    scene_.setTier(features.tier);
  }

  Result<void> fill() {
    if (Result<void> added = addHair(); !added) return added;
    addBuffers();
    return addFollowers();
  }

  Scene& scene() { return scene_; }
  const std::vector<HairId>& hairs() const { return hairs_; }
  BufferId forces() const { return forces_; }
  BufferId depth() const { return depth_; }

 private:
  Result<void> addHair() {
    const std::vector<FollowHair> follows = {{.guide = 0, .offset = {0.001f, 0, 0, 1}}};
    const std::vector<Float4> texel = {{1, 1, 1, 1}};
    for (const SimulationSettings& settings : features_.settings) {
      for (const bool attributes : {false, true}) {
        if (attributes && !features_.attributes && !features_.strandTextures) continue;
        const Result<HairAsset> asset = smallGroom(attributes);
        if (!asset) return asset.error();
        HairDef def = {.name = "prepared", .settings = settings};
        if (attributes) def.baseTexture = {1, 1, texel};
        def.strandUvs = attributes && features_.strandTextures;
        if (Result<void> added = addKinds(*asset, def, follows); !added) return added;
      }
    }
    return {};
  }

  // With each kind of follow hairs, and without.
  Result<void> addKinds(const HairAsset& asset, HairDef def, std::span<const FollowHair> follows) {
    if (Result<void> added = add(asset, def); !added) return added;
    if (features_.levelOfDetail && def.settings.solver == Solver::kExact) {
      def.levelOfDetail = true;
      if (Result<void> added = add(asset, def); !added) return added;
      scene_.hair(hairs_.back()).simulatedShare = 0.5f;
    }
    def.followHairs = follows;
    if (features_.followHairs)
      if (Result<void> added = add(asset, def); !added) return added;
    def.storeFollowHairs = true;
    if (features_.storedFollowHairs)
      if (Result<void> added = add(asset, def); !added) return added;
    def.collidingHair = CollidingHair::kGuidesAndFollows;
    return features_.collidingFollowHairs ? add(asset, def) : Result<void>();
  }

  Result<void> add(const HairAsset& asset, const HairDef& def) {
    Result<HairId> added = scene_.addHair(asset, def);
    if (!added) return added.error();
    hairs_.push_back(*added);
    scene_.hair(*added).tracksMotion = features_.motion;
    scene_.hair(*added).interpolates = features_.interpolation;
    if (def.strandUvs) scene_.hair(*added).strandTexture = {newTextureId(), 1, 1};
    return {};
  }

  void addBuffers() {
    const auto buffer = [this](const char* name, uint64_t elements) {
      return scene_.resources().add(
          {.name = name, .size = elements * sizeof(Float4), .stride = sizeof(Float4)});
    };
    forces_ = buffer("forces", uint64_t{kStrands} * kVertices);
    depth_ = buffer("depth", 16);
  }

  // Hair whose bones are on the GPU.
  Result<void> addFollowers() {
    const Result<HairAsset> asset = smallGroom(false);
    if (!asset) return asset.error();
    const auto add = [&](const SkeletonDef& def) -> Result<SkeletonPose*> {
      const Result<SkeletonId> skeleton = scene_.addSkeleton(def);
      if (!skeleton) return skeleton.error();
      HairDef hair = {.name = "prepared", .skeleton = *skeleton};
      if (!features_.settings.empty()) hair.settings = features_.settings.front();
      if (Result<void> added = this->add(*asset, hair); !added) return added.error();
      return &scene_.skeleton(*skeleton);
    };
    if (features_.boneBuffers) {
      const Result<SkeletonPose*> added = add({.source = BoneSource::kBuffer});
      if (!added) return added.error();
      (*added)->setBones({.buffer = forces_}, {});
    }
    if (features_.boneSurfaces) {
      const SkinTable table = smallSurface();
      const Result<SkeletonPose*> added = add({.source = BoneSource::kSurface, .surface = &table});
      if (!added) return added.error();
      const VertexBuffer vertices = {.buffer = forces_};
      (*added)->setVertices({&vertices, 1}, {});
    }
    return {};
  }

  const SceneFeatures& features_;
  Scene scene_;
  std::vector<HairId> hairs_;
  BufferId forces_ = BufferId::kInvalid, depth_ = BufferId::kInvalid;
};

// Plays a small scene with all features of a program, and keeps its passes.
class ScenePlayer {
 public:
  /// \param viewsOnly  keeps the passes of views, and drops those that move hair
  explicit ScenePlayer(const SceneFeatures& features, bool viewsOnly = false)
      : features_(features), viewsOnly_(viewsOnly), small_(features) {}

  Result<PassList> play() {
    if (Result<void> filled = small_.fill(); !filled) return filled.error();
    for (const bool forces : {false, true}) {
      if (forces && !features_.forces) continue;
      for (const HairId id : small_.hairs())
        small_.scene().hair(id).setForces(forces ? small_.forces() : BufferId::kInvalid);
      if (Result<void> ran = playColliders(); !ran) return ran.error();
    }
    if (features_.denseSdfs) {
      if (Result<void> ran = playDenseSdf(); !ran) return ran.error();
    }
    if (features_.forceField) {
      for (const HairId id : small_.hairs())
        small_.scene().hair(id).setForceField(
            {.values = small_.forces(), .cellSize = 1, .nodes = {2, 2, 2}});
      if (Result<void> ran = playColliders(); !ran) return ran.error();
      for (const HairId id : small_.hairs()) small_.scene().hair(id).setForceField({});
    }
    if (Result<void> ran = playWithoutSolver(); !ran) return ran.error();
    if (Result<void> ran = playMoves(); !ran) return ran.error();
    return std::move(kept_).list();
  }

 private:
  // Hair that bones or given positions place.
  Result<void> playWithoutSolver() {
    if (features_.skinnedHair) {
      for (const bool simulated : {false, true}) {
        for (const HairId id : small_.hairs()) small_.scene().hair(id).simulated = simulated;
        if (Result<void> ran = frames(); !ran) return ran;
      }
    }
    if (features_.givenHair) {
      for (const bool given : {true, false}) {
        const std::vector<Float3> positions(given ? size_t{kStrands} * kVertices : 0);
        for (const HairId id : small_.hairs())
          if (Result<void> set = small_.scene().hair(id).setPositions(positions); !set) return set;
        if (Result<void> ran = frames(); !ran) return ran;
      }
    }
    return {};
  }

  Result<void> playMoves() {
    if (features_.originShifts) {
      if (Result<void> moved = small_.scene().shiftOrigin({1, 0, 0}); !moved) return moved;
      if (Result<void> ran = frames(); !ran) return ran;
    }
    if (features_.teleports) {
      for (const HairId id : small_.hairs())
        if (Result<void> moved = small_.scene().teleport(id, {}); !moved) return moved;
      if (Result<void> ran = frames(); !ran) return ran;
    }
    return {};
  }

  void setCapsules(bool on) {
    const CapsuleCollider capsule = {.head = {0.01f, 0.02f, 0},
                                     .headRadius = 0.005f,
                                     .tail = {0, 0.02f, 0},
                                     .tailRadius = 0.005f};
    for (const HairId id : small_.hairs())
      small_.scene().hair(id).setColliders({&capsule, on ? 1u : 0u});
  }

  // Nothing in reach, capsules, a mesh, and both.
  Result<void> playColliders() {
    for (const bool mesh : {false, true}) {
      if (mesh && !features_.meshColliders) continue;
      for (const bool capsules : {false, true}) {
        if (capsules && !features_.capsules) continue;
        setCapsules(capsules);
        if (Result<void> ran = mesh ? playMesh() : frames(); !ran) return ran;
      }
    }
    setCapsules(false);
    return {};
  }

  // It is built as a whole, then what has moved of it, then as a whole.
  Result<void> playMesh() {
    const Result<ColliderId> added = small_.scene().addCollider(
        smallMesh(), {.name = "prepared mesh", .cellSize = 0.01f, .boneCount = 2});
    if (!added) return added.error();
    for (const auto& [first, second] :
         {std::pair(0.0f, 0.0f), std::pair(0.002f, 0.0f), std::pair(0.004f, 0.004f)}) {
      AffineTransform bones[2];
      bones[0].rows[0].w = first;
      bones[1].rows[0].w = second;
      small_.scene().collider(*added).setBones(bones);
      if (Result<void> ran = frames(); !ran) return ran;
    }
    return small_.scene().removeCollider(*added);
  }

  Result<void> playDenseSdf() {
    const Result<ColliderId> added = small_.scene().addCollider(
        DenseSdf{.distances = small_.depth(), .grid = {.cellSize = 0.1f, .nodes = {2, 2, 2}}},
        {.name = "prepared SDF"});
    if (!added) return added.error();
    if (Result<void> ran = frames(); !ran) return ran;
    return small_.scene().removeCollider(*added);
  }

  Result<void> frames() {
    for (int i = 0; i < 2; ++i) {
      auto frame = small_.scene().simulate(1.0f / 60);
      if (!frame) return frame.error();
      if (features_.interpolation)
        if (Result<void> placed = frame->interpolate(0.5f); !placed) return placed;
      const View view = smallView(features_.reversedDepth);
      for (const bool shadows : {false, true}) {
        if (shadows && !features_.shadows) continue;
        Light light = {.shadow = shadows ? HairShadow::kDeep : HairShadow::kNone,
                       .shadowSize = 8,
                       .shadowLayers = 2};
        if (features_.opaqueShadows)
          light.opaque = {.depth = small_.depth(), .width = 2, .height = 2};
        // For an engine that draws hair by itself.
        if (features_.transparency.empty() && shadows) {
          const auto cast = frame->castShadows({&light, 1});
          if (!cast) return cast.error();
        }
        for (TransparencySettings settings : features_.transparency) {
          if (settings.opaqueDepth != BufferId::kInvalid) settings.opaqueDepth = small_.depth();
          const auto drawn = frame->draw(view, {&light, 1}, settings);
          if (!drawn) return drawn.error();
        }
      }
      for (const HairDepthSettings& settings : features_.depth) {
        const auto drawn = frame->drawDepth(view, settings);
        if (!drawn) return drawn.error();
      }
      const FrameExecutor executor = {.update = [](const ResourceTable&) { return Result<void>(); },
                                      .record =
                                          [this](const FrameStep& step) {
                                            if (!viewsOnly_ || step.view != FrameStep::kNoView)
                                              kept_.take(*step.list);
                                            setDelivered(step.list->run);
                                            return Result<void>();
                                          },
                                      .draw = [](const FrameStep&) { return Result<void>(); }};
      if (Result<void> ran = frame->run(executor); !ran) return ran;
    }
    return {};
  }

  const SceneFeatures& features_;
  const bool viewsOnly_;
  SmallScene small_;
  KeptPasses kept_;
};

}  // namespace

Result<PassList> listToPrepare(const SceneFeatures& features) {
  return ScenePlayer(features).play();
}

Result<PassList> listToDraw(const TransparencySettings& settings, const DrawnFeatures& hair,
                            Tier tier) {
  const SceneFeatures features = {.capsules = false,
                                  .meshColliders = false,
                                  .followHairs = hair.followHairs,
                                  .attributes = hair.attributes,
                                  .strandTextures = hair.strandTextures,
                                  .shadows = false,
                                  .transparency = {settings},
                                  .tier = tier};
  return ScenePlayer(features, true).play();
}

}  // namespace pelage
