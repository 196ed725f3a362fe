// Devices that count as smaller ones: what their tier has runs, with the bits of any other device,
// and what it lacks is refused by name before anything is made.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "pelage/kernels.h"
#include "pelage/list_check.h"
#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

std::unique_ptr<HeadlessDevice> deviceOf(Api api, Tier tier) {
  auto made = createDevice({.api = api, .validation = true, .maxTier = tier});
  if (!made) made = createDevice({.api = api, .maxTier = tier});
  if (!made && made.error().code != ErrorCode::kUnsupported) ADD_FAILURE() << made.error().message;
  return made ? std::move(*made) : nullptr;
}

class Tiers : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    wide_ = deviceOf(GetParam(), Tier::kWide);
    if (wide_ == nullptr)
      PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no " << apiName(GetParam()) << " device";
    ASSERT_EQ(wide_->info().tier, Tier::kWide);
  }
  void TearDown() override {
    if (wide_ != nullptr) {
      EXPECT_EQ(wide_->messageCount(), 0u);
    }
  }
  std::unique_ptr<HeadlessDevice> wide_;
};
INSTANTIATE_TEST_SUITE_P(All, Tiers, testing::ValuesIn(kApis), apiTestName);

struct Run {
  DeliveryScene::Results buffers;
  std::vector<RenderedImage> images;
};

void execute(Scene& scene, HeadlessDevice& device, PassList& list) {
  scene.finish(list);
  expectOk(device.update(scene.resources()));
  expectOk(device.execute(list));
}

View tierView(uint32_t pixels) {
  return cameraView(
      {.eye = {0.05f, 0.04f, 0.4f}, .target = {0.05f, 0.04f, 0}, .fov = 0.6f, .width = pixels});
}

// Draws the scene with each of the methods.
void drawAll(Scene& scene, HeadlessDevice& device, const std::vector<TransparencySettings>& methods,
             const Light& light, Run& run) {
  constexpr RenderTargetDef kTarget = {.width = 48, .height = 48};
  for (const TransparencySettings& settings : methods) {
    std::vector<PassList> lists;
    expectOk(scene.draw(tierView(kTarget.width), {&light, 1}, settings, lists));
    run.images.push_back(imageOf(renderLists(scene, device, lists, kTarget), kTarget));
  }
}

void expectSame(const Run& wide, const Run& small) {
  ASSERT_EQ(wide.buffers.size(), small.buffers.size());
  for (size_t i = 0; i < wide.buffers.size(); ++i)
    EXPECT_TRUE(wide.buffers[i] == small.buffers[i]) << "buffer " << i;
  ASSERT_EQ(wide.images.size(), small.images.size());
  for (size_t m = 0; m < wide.images.size(); ++m) {
    double covered = 0, sum = 0;
    const std::vector<Float4>&a = wide.images[m].pixels, &b = small.images[m].pixels;
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      covered += static_cast<double>(a[i].w);
      sum += std::abs(static_cast<double>(a[i].x - b[i].x)) +
             std::abs(static_cast<double>(a[i].w - b[i].w));
    }
    EXPECT_GT(covered, 20.0) << m;
    EXPECT_LE(sum / static_cast<double>(2 * a.size()), 3e-4) << m;
  }
}

// Classic hair with follow hairs that are stored, wind, and transparency of two kinds.
Run playClassic(HeadlessDevice& device) {
  Run run;
  Scene scene;
  scene.setTier(device.info().tier);
  std::vector<FollowHair> follows;
  for (uint32_t s = 0; s < 20; ++s)
    follows.push_back({.guide = s, .offset = {0.004f, 0, 0.003f, 1}});
  HairDef def = {.followHairs = follows, .storeFollowHairs = true};
  def.settings.solver = Solver::kClassic;
  def.settings.wind.velocity = {1, 0, 0.5f};
  def.settings.globalStiffness = 0.05f;
  def.material.fiberRadius = 0.0015f;
  const Result<HairId> hair = scene.addHair(makeAsset(20, 12), def);
  EXPECT_TRUE(hair) << hair.error().message;
  PassList list;
  for (int frame = 0; frame < 8; ++frame) {
    const AffineTransform bone = rigidTransform({}, {0.002f * static_cast<float>(frame), 0, 0});
    scene.hair(*hair).setBones({&bone, 1});
    expectOk(scene.simulate(1.0f / 60, list));
    execute(scene, device, list);
  }
  const HairBuffers& buffers = scene.hair(*hair).buffers();
  run.buffers = {valueOf(device.read(buffers.positions)), valueOf(device.read(buffers.tangents))};
  drawAll(scene, device,
          {{.method = Transparency::kWindowed, .spillTail = false},
           {.method = Transparency::kShortCut},
           {.method = Transparency::kStochastic}},
          Light{}, run);
  return run;
}

// Everything: capsules, a mesh, hair against hair, follow hairs that collide, level of detail.
Run playAll(HeadlessDevice& device, Solver solver) {
  Run run;
  Scene scene;
  scene.setTier(device.info().tier);
  DeliveryScene inputs(scene, solver);
  inputs.hair(0).material.fiberRadius = inputs.hair(1).material.fiberRadius = 0.0015f;
  PassList list;
  for (int frame = 0; frame < 3; ++frame) {
    inputs.setInputs(frame);
    expectOk(inputs.simulate(frame, list));
    execute(scene, device, list);
  }
  run.buffers = inputs.readResults([&](BufferId buffer) { return valueOf(device.read(buffer)); });
  drawAll(scene, device,
          {{.method = Transparency::kWindowed},
           {.method = Transparency::kHybrid8},
           {.method = Transparency::kTiles},
           {.method = Transparency::kAlphaTest}},
          {.shadow = HairShadow::kDeep, .shadowSize = 64}, run);
  return run;
}

TEST_P(Tiers, EsRunsClassicHairAndTransparency) {
  const auto device = deviceOf(GetParam(), Tier::kEs);
  ASSERT_NE(device, nullptr);
  EXPECT_EQ(device->info().tier, Tier::kEs);
  expectSame(playClassic(*wide_), playClassic(*device));
  EXPECT_EQ(device->messageCount(), 0u);
}

TEST_P(Tiers, BaseRunsBothSolversContactFieldsAndEveryTransparency) {
  for (const Solver solver : {Solver::kExact, Solver::kClassic}) {
    const auto device = deviceOf(GetParam(), Tier::kBase);
    ASSERT_NE(device, nullptr);
    EXPECT_EQ(device->info().tier, Tier::kBase);
    expectSame(playAll(*wide_, solver), playAll(*device, solver));
    EXPECT_EQ(device->messageCount(), 0u);
    wide_ = deviceOf(GetParam(), Tier::kWide);
  }
}

TEST_P(Tiers, RefuseWhatTheyLackByName) {
  const auto device = deviceOf(GetParam(), Tier::kEs);
  ASSERT_NE(device, nullptr);
  Scene scene;
  scene.setTier(Tier::kEs);
  ASSERT_TRUE(scene.addHair(makeAsset(20, 12), {}));
  PassList list;
  expectOk(scene.simulate(1.0f / 60, list));
  scene.finish(list);
  expectOk(device->update(scene.resources()));
  expectError(device->execute(list), ErrorCode::kUnsupported,
              {"kernel ", "storage buffers", "allows 4"});
  // No pass of the list has run: the scene writes the frame again for a device that can.
  expectOk(scene.simulate(1.0f / 60, list));
  execute(scene, *wide_, list);
}

/// Hair without follow hairs, with them, and with colors: what DrawnFeatures tells apart.
std::vector<DrawnFeatures> drawnKinds() {
  return {{}, {.followHairs = true}, {.attributes = true}};
}

std::vector<TransparencySettings> allMethods() {
  std::vector<TransparencySettings> all;
  for (Transparency m = Transparency::kAlphaTest; m <= Transparency::kTiles;
       m = static_cast<Transparency>(static_cast<uint8_t>(m) + 1))
    all.push_back({.method = m});
  all.push_back({.method = Transparency::kWindowed, .spillTail = false});
  return all;
}

HairId addDrawn(Scene& scene, const DrawnFeatures& kind) {
  HairAsset asset = makeAsset(20, 12);
  if (kind.attributes) asset.vertexColor.assign(asset.positions.size(), {1, 0.5f, 0.5f, 1});
  expectOk(asset.process());
  const std::vector<FollowHair> follows = {{.guide = 3, .offset = {0.004f, 0, 0.003f, 1}}};
  HairDef def;
  def.settings.solver = Solver::kClassic;
  def.material.fiberRadius = 0.0015f;
  if (kind.followHairs) def.followHairs = follows;
  return valueOf(scene.addHair(asset, def));
}

TEST_P(Tiers, SayBeforeAFrameWhatItsDrawsThenDo) {
  for (const Tier tier : kTiers) {
    const auto device = deviceOf(GetParam(), tier);
    ASSERT_NE(device, nullptr);
    Scene scene;
    scene.setTier(device->info().tier);
    size_t drawn = 0, refused = 0;
    for (const DrawnFeatures& kind : drawnKinds()) {
      const HairId hair = addDrawn(scene, kind);
      PassList list;
      expectOk(scene.simulate(1.0f / 60, list));
      execute(scene, *device, list);
      for (const TransparencySettings& settings : allMethods()) {
        SCOPED_TRACE(std::string(tierName(tier)) + ", method " +
                     std::to_string(static_cast<int>(settings.method)) +
                     (kind.followHairs  ? ", follow hairs"
                      : kind.attributes ? ", attributes"
                                        : ""));
        const Result<void> said = device->supports(settings, kind);
        Result<Frame> frame = required(scene.simulate(0));
        const Light light;
        ASSERT_TRUE(frame->draw(tierView(24), {&light, 1}, settings));
        const RenderTargetDef target = {.width = 24, .height = 24};
        const auto images = device->render(*frame, {&target, 1});
        ASSERT_EQ(said.ok(), images.ok()) << (said.ok() ? images.error() : said.error()).message;
        if (said.ok()) {
          ++drawn;
          continue;
        }
        ++refused;
        EXPECT_EQ(said.error().code, ErrorCode::kUnsupported);
        EXPECT_EQ(images.error().code, ErrorCode::kUnsupported);
        for (const char* word : {"kernel", "storage buffers", "4"})
          EXPECT_NE(said.error().message.find(word), std::string::npos) << said.error().message;
      }
      expectOk(scene.removeHair(hair));
    }
    EXPECT_GT(drawn, 0u) << tierName(tier);
    EXPECT_EQ(refused > 0, tier == Tier::kEs) << tierName(tier);
    EXPECT_EQ(device->messageCount(), 0u);
  }
}

TEST_P(Tiers, RefuseMethodsThatAreNone) {
  expectError(wide_->supports({.method = static_cast<Transparency>(99)}),
              ErrorCode::kInvalidArgument, "99");
}

TEST_P(Tiers, SayWhetherAWholeSceneRuns) {
  for (const Tier tier : {Tier::kEs, Tier::kBase}) {
    const auto device = deviceOf(GetParam(), tier);
    ASSERT_NE(device, nullptr);
    for (const Solver solver : {Solver::kClassic, Solver::kExact}) {
      SceneFeatures features;
      features.settings[0].solver = solver;
      features.capsules = features.meshColliders = features.followHairs = features.shadows = false;
      features.transparency = {{.method = Transparency::kStochastic}};
      features.tier = tier;
      const Result<PassList> list = required(listToPrepare(features));
      EXPECT_EQ(device->supports(*list).ok(), tier == Tier::kBase || solver == Solver::kClassic)
          << tierName(tier);
    }
  }
}

TEST(TierLimits, AreCheckedForEachStageAndForBoth) {
  const KernelVariant& exact = simulateExactVariant({});
  EXPECT_TRUE(checkLimits(exact, nullptr, limitsOf(Tier::kBase), "a phone"));
  expectError(checkLimits(exact, nullptr, limitsOf(Tier::kEs), "a phone"), "a phone allows 4");
  const KernelVariant& vertex = strandVertexVariant({.smooth = true});
  const KernelVariant& pixel = ppllBuildVariant({});
  EXPECT_TRUE(checkLimits(vertex, &pixel, limitsOf(Tier::kWide), "a PC"));
  EXPECT_FALSE(checkLimits(vertex, &pixel, limitsOf(Tier::kBase), "a phone"));
  TierLimits few = limitsOf(Tier::kWide);
  few.drawStorageBuffers = 7;
  expectError(checkLimits(vertex, &pixel, few, "a phone"), "together");
  EXPECT_TRUE(checkLimits(strandRecordVertexVariant({.smooth = true}), &pixel, limitsOf(Tier::kEs),
                          "a phone"));
  TierLimits threads = limitsOf(Tier::kWide);
  threads.groupThreads = 31;
  EXPECT_FALSE(checkLimits(exact, nullptr, threads, "a phone"));
}

}  // namespace
}  // namespace pelage::test
