// The pipelines of a scene depend on its features, not on its size: an engine has those of
// listToPrepare() made while it loads (docs/vulkan.md, Pipelines).
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/kernels.h"
#include "pelage/list_check.h"
#include "pelage/scene.h"
#include "pelage/scene_features.h"
#include "pelage/skin_table.h"
#include "scene/scene_lists.h"
#include "support/errors.h"
#include "support/views.h"

namespace pelage::test {
namespace {

struct Features {
  Solver solver = Solver::kExact;
  bool capsule = false;
  bool wind = false;
  bool shadow = false;
  Transparency method = Transparency::kWindowed;
};

// Kernel, permutation, constants and state of every pass, as text.
std::string pipelineOf(const PassList& list, const Pass& pass) {
  std::string text = std::string(pass.kernel->kernel->name) + " " + pass.kernel->key;
  if (pass.pixel != nullptr)
    text += std::string(" + ") + pass.pixel->kernel->name + " " + pass.pixel->key;
  for (const SpecValue& value : list.specValuesOf(pass))
    text += " " + std::to_string(value.id) + "=" + std::to_string(value.bits);
  if (pass.pixel != nullptr) {
    const DrawState& s = pass.state;
    for (const int part : {static_cast<int>(s.topology), static_cast<int>(s.depthCompare),
                           int{s.depthWrite}, static_cast<int>(s.blend), int{s.colorWrite}})
      text += "/" + std::to_string(part);
  }
  return text;
}

std::set<std::string> pipelinesOf(const Features& features, uint32_t strands, uint32_t vertices,
                                  int frames) {
  Scene scene;
  HairDef def;
  def.settings.solver = features.solver;
  if (features.wind) def.settings.wind.velocity = {3, 0, 0};
  const auto hair = scene.addHair(makeAsset(strands, vertices), def);
  EXPECT_TRUE(hair) << hair.error().message;
  const CapsuleCollider capsule = {.head = {0.02f, 0.02f, 0},
                                   .headRadius = 0.01f,
                                   .tail = {0.03f, 0.02f, 0},
                                   .tailRadius = 0.01f};
  if (features.capsule) scene.hair(*hair).setColliders({&capsule, 1});
  const View view = cameraView({.eye = {0.1f, 0.04f, 0.6f}, .target = {0.1f, 0.04f, 0}});
  const Light light = {.shadow = features.shadow ? HairShadow::kDeep : HairShadow::kNone,
                       .shadowSize = 64};
  std::set<std::string> pipelines;
  for (int i = 0; i < frames; ++i) {
    auto frame = scene.simulate(1.0f / 60);
    EXPECT_TRUE(frame) << frame.error().message;
    if (!frame) return {};
    const auto drawn = frame->draw(view, {&light, 1}, {.method = features.method});
    EXPECT_TRUE(drawn) << drawn.error().message;
    const FrameExecutor executor = executorOf([&](const PassList& list) {
      for (const Pass& pass : list.passes) pipelines.insert(pipelineOf(list, pass));
    });
    expectOk(frame->run(executor));
  }
  return pipelines;
}

TEST(PipelinesOfAScene, DependOnItsFeaturesAlone) {
  for (const Features& features :
       {Features{}, Features{.solver = Solver::kClassic}, Features{.capsule = true},
        Features{.solver = Solver::kClassic, .capsule = true, .wind = true},
        Features{.capsule = true, .wind = true, .shadow = true},
        Features{.shadow = true, .method = Transparency::kStochastic},
        Features{.method = Transparency::kShortCut}}) {
    const std::set<std::string> small = pipelinesOf(features, 2, 4, 3);
    EXPECT_GT(small.size(), 3u);
    EXPECT_EQ(pipelinesOf(features, 700, 30, 5), small);
  }
}

std::set<std::string> pipelinesOf(const PassList& list) {
  std::set<std::string> pipelines;
  for (const Pass& pass : list.passes) pipelines.insert(pipelineOf(list, pass));
  return pipelines;
}

// A scene that is switched on feature by feature, larger than the one that was prepared.
class Game {
 public:
  explicit Game(const SceneFeatures& features) : features_(features) {
    scene_.setTier(features.tier);
    for (uint32_t s = 0; s < 40; ++s)
      follows_.push_back({.guide = s, .offset = {0.001f, 0, 0.001f, 1}});
    for (const SimulationSettings& settings : features.settings) {
      HairDef def = {.settings = settings, .levelOfDetail = features.levelOfDetail};
      add(def);
      if (features.followHairs) def.followHairs = follows_;
      if (features.collidingFollowHairs) def.collidingHair = CollidingHair::kGuidesAndFollows;
      add(def);
    }
  }

  void frames(int count) {
    for (int i = 0; i < count; ++i) {
      auto frame = required(scene_.simulate(1.0f / 45));
      const View view = cameraView({.eye = {0.2f, 0.04f, 0.9f},
                                    .target = {0.2f, 0.04f, 0},
                                    .fov = 0.6f,
                                    .width = 50,
                                    .reversedDepth = features_.reversedDepth});
      const Light light = {.shadow = features_.shadows ? HairShadow::kDepth : HairShadow::kNone,
                           .shadowSize = 64};
      for (const TransparencySettings& settings : features_.transparency) {
        const auto drawn = required(frame->draw(view, {&light, 1}, settings));
      }
      for (const HairDepthSettings& settings : features_.depth) {
        ASSERT_TRUE(frame->drawDepth(view, settings));
      }
      const FrameExecutor executor =
          executorOf([this](const PassList& list) { needed_.merge(pipelinesOf(list)); });
      expectOk(frame->run(executor));
    }
  }

  void switchEverythingOn() {
    frames(2);
    if (features_.capsules) {
      const CapsuleCollider capsule = {{0.02f, 0.02f, 0}, 0.01f, {0.03f, 0.02f, 0}, 0.01f};
      for (const HairId id : hairs_) scene_.hair(id).setColliders({&capsule, 1});
      frames(2);
    }
    if (features_.meshColliders) {
      CollisionMesh mesh;
      mesh.positions = {
          {0, 0.03f, -0.02f}, {0.3f, 0.03f, -0.02f}, {0.1f, 0.03f, 0.1f}, {0.1f, 0.2f, 0}};
      mesh.indices = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
      const auto collider = required(scene_.addCollider(mesh, {}));
      frames(2);
      AffineTransform bone;
      bone.rows[1].w = 0.003f;
      scene_.collider(*collider).setBones({&bone, 1});
      frames(2);
    }
    if (features_.levelOfDetail)
      for (const HairId id : hairs_) scene_.hair(id).simulatedShare = 0.6f;
    if (features_.forces) {
      const BufferId forces = scene_.resources().add(
          {.name = "forces", .size = 50 * 12 * sizeof(Float4), .stride = sizeof(Float4)});
      for (const HairId id : hairs_) scene_.hair(id).setForces(forces);
    }
    frames(2);
    switchEngineInputsOn();
    if (features_.skinnedHair) {
      for (const HairId id : hairs_) scene_.hair(id).simulated = false;
      frames(2);
      for (const HairId id : hairs_) scene_.hair(id).simulated = true;
      frames(2);
    }
    if (features_.givenHair) {
      for (const HairId id : hairs_) {
        HairObject& hair = scene_.hair(id);
        const std::vector<Float3> given(size_t{hair.guideCount()} * hair.verticesPerStrand());
        ASSERT_TRUE(hair.setPositions(given));
      }
      frames(2);
      for (const HairId id : hairs_) ASSERT_TRUE(scene_.hair(id).setPositions({}));
      frames(2);
    }
    if (features_.teleports) {
      for (const HairId id : hairs_) ASSERT_TRUE(scene_.teleport(id, {}));
      frames(1);
    }
    if (features_.originShifts) {
      ASSERT_TRUE(scene_.shiftOrigin({7, 0, 0}));
    }
    for (const HairId id : hairs_) scene_.hair(id).reset();
    frames(1);
  }

  // Inputs that an engine has on the GPU.
  void switchEngineInputsOn() {
    const BufferId buffer =
        scene_.resources().add({.name = "engine's", .size = 4096, .stride = sizeof(Float4)});
    if (features_.forceField) {
      for (const HairId id : hairs_)
        scene_.hair(id).setForceField({.values = buffer, .cellSize = 1, .nodes = {3, 3, 3}});
      frames(2);
    }
    if (features_.denseSdfs) {
      ASSERT_TRUE(scene_.addCollider(
          DenseSdf{.distances = buffer, .grid = {.cellSize = 0.1f, .nodes = {8, 8, 8}}}, {}));
      frames(2);
    }
    if (features_.boneBuffers) {
      const auto skeleton = required(scene_.addSkeleton({.source = BoneSource::kBuffer}));
      scene_.skeleton(*skeleton).setBones({.buffer = buffer}, {});
      add({.name = "boned", .settings = features_.settings.front(), .skeleton = *skeleton});
      frames(2);
    }
    if (features_.boneSurfaces) {
      SurfaceRoot root;
      root.corners[1] = 1;
      root.corners[2] = 2;
      root.barycentric = {1, 0, 0};
      root.bind[1].x = root.bind[2].y = 1;
      SkinTable table;
      table.parts.resize(1);
      table.parts[0].vertexCount = 3;
      table.parts[0].triangleCount = 1;
      table.roots = {root};
      const auto skeleton =
          required(scene_.addSkeleton({.source = BoneSource::kSurface, .surface = &table}));
      const VertexBuffer vertices = {.buffer = buffer};
      scene_.skeleton(*skeleton).setVertices({&vertices, 1}, {});
      add({.name = "skinned", .settings = features_.settings.front(), .skeleton = *skeleton});
      frames(2);
    }
    if (features_.strandTextures) {
      HairAsset asset = makeAsset(50, 12);
      asset.strandUv.assign(50, {0.5f, 0.5f});
      add({.name = "textured", .settings = features_.settings.front(), .strandUvs = true}, asset);
      scene_.hair(hairs_.back()).strandTexture = {newTextureId(), 64, 64, 7};
      frames(2);
    }
  }

  std::set<std::string> needed_;

 private:
  void add(const HairDef& def) { add(def, makeAsset(50, 12)); }
  void add(const HairDef& def, const HairAsset& asset) {
    const auto added = required(scene_.addHair(asset, def));
    hairs_.push_back(*added);
    scene_.hair(*added).tracksMotion = features_.motion;
  }
  const SceneFeatures& features_;
  Scene scene_;
  std::vector<FollowHair> follows_;
  std::vector<HairId> hairs_;
};

SimulationSettings settingsOf(Solver solver, bool hairContact = false) {
  SimulationSettings settings;
  settings.solver = solver;
  if (hairContact) {
    settings.contact.stiffness = settings.contact.friction = 0.3f;
    settings.globalStiffness = 0.1f;
  }
  return settings;
}

TEST(ListToPrepare, HasEveryPipelineThatIsSwitchedOnLater) {
  const std::vector<TransparencySettings> methods = {
      {.method = Transparency::kAlphaTest}, {.method = Transparency::kStochastic},
      {.method = Transparency::kWindowed},  {.method = Transparency::kWindowed, .spillTail = false},
      {.method = Transparency::kHybrid16},  {.method = Transparency::kShortCut},
      {.method = Transparency::kTiles}};
  const std::vector<HairDepthSettings> depths = {{.color = HairDepthColor::kNone},
                                                 {.color = HairDepthColor::kDepth},
                                                 {.color = HairDepthColor::kMotion}};
  const std::vector<SceneFeatures> games = {
      {},
      {.settings = {settingsOf(Solver::kClassic)}, .meshColliders = false, .forces = true},
      {.settings = {settingsOf(Solver::kExact, true), settingsOf(Solver::kClassic, true)},
       .forces = true,
       .denseSdfs = true,
       .forceField = true,
       .boneBuffers = true,
       .boneSurfaces = true,
       .collidingFollowHairs = true,
       .strandTextures = true,
       .skinnedHair = true,
       .givenHair = true,
       .originShifts = true,
       .teleports = true,
       .motion = true,
       .transparency = methods,
       .depth = depths,
       .reversedDepth = true},
      {.capsules = false,
       .levelOfDetail = true,
       .motion = true,
       .shadows = false,
       .transparency = methods,
       .depth = depths,
       .tier = Tier::kBase},
  };
  for (size_t i = 0; i < games.size(); ++i) {
    const Result<PassList> list = required(listToPrepare(games[i]));
    EXPECT_TRUE(checkPasses(*list));
    const std::set<std::string> prepared = pipelinesOf(*list);
    EXPECT_EQ(prepared.size(), list->passes.size()) << "a pipeline is there twice";
    Game game(games[i]);
    game.switchEverythingOn();
    EXPECT_GT(game.needed_.size(), 8u);
    for (const std::string& pipeline : game.needed_)
      EXPECT_TRUE(prepared.contains(pipeline)) << "game " << i << ": " << pipeline;
  }
}

TEST(ListToPrepare, LeavesOutWhatIsNotWanted) {
  const auto count = [](const SceneFeatures& features, const char* kernel) {
    const Result<PassList> list = listToPrepare(features);
    EXPECT_TRUE(list) << list.error().message;
    size_t found = 0;
    for (const Pass& pass : list->passes)
      found += std::string_view(pass.kernel->kernel->name).find(kernel) != std::string_view::npos;
    return found;
  };
  EXPECT_GT(count({}, "strand_shadow"), 0u);
  EXPECT_EQ(count({.shadows = false}, "strand_shadow"), 0u);
  EXPECT_EQ(count({}, "opaque_shadow"), 0u);
  EXPECT_EQ(count({.opaqueShadows = true}, "copy_opaque_shadow"), 1u);
  EXPECT_GT(count({}, "find_contacts"), 0u);
  EXPECT_EQ(count({.capsules = false, .meshColliders = false}, "find_contacts"), 0u);
  EXPECT_EQ(count({.transparency = {}}, "strand_vertex"), 0u);
  EXPECT_EQ(count({.tier = Tier::kBase}, "strand_vertex"), 0u);
  EXPECT_EQ(count({}, "simulate_classic"), 0u);
  EXPECT_EQ(count({}, "skin_exact_strands"), 0u);
  EXPECT_EQ(count({.skinnedHair = true}, "skin_exact_strands"), 1u);
  EXPECT_EQ(count({}, "keep_positions"), 0u);
  EXPECT_EQ(count({}, "motion"), 0u);
  EXPECT_EQ(count({.motion = true}, "keep_positions"), 1u);
  EXPECT_EQ(count({}, "interpolate_strands"), 0u);
  EXPECT_EQ(count({.interpolation = true}, "interpolate_strands"), 1u);
  EXPECT_EQ(count({.givenHair = true}, "interpolate_strands"), 1u);
  EXPECT_EQ(count({.interpolation = true}, "interpolate_roots"), 1u);
}

TEST(ListToPrepare, RefusesSettingsThatAreOutOfRange) {
  SimulationSettings settings;
  settings.subSteps = 0;
  expectError(listToPrepare({.settings = {settings}}), "subSteps");
}

}  // namespace
}  // namespace pelage::test
