// Hair in the targets of an engine: stencil beside depth, several colour attachments, with render
// passes and without. It writes the first colour and the depth, and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "pelage/scene.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "support/plain_asset.h"
#include "support/views.h"
#include "vulkan/vulkan_target.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;
using runtime_test::EngineRun;
using vulkan::Runtime;

constexpr uint32_t kSize = VulkanTarget::kSize, kClearedStencil = VulkanTarget::kClearedStencil;
constexpr VkFormat kColor = VulkanTarget::kColor, kBoth = VulkanTarget::kBoth;
using Pixels = std::vector<uint32_t>;

class VulkanTargets : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override {
    VkPhysicalDeviceFeatures features = {};
    features.independentBlend = features.fragmentStoresAndAtomics = VK_TRUE;
    open(features);
    if (engine_ == nullptr) return;
    if (engine_->features().independentBlend == VK_FALSE ||
        engine_->features().fragmentStoresAndAtomics == VK_FALSE)
      GTEST_SKIP() << "the device lacks a feature";
    createRuntime(engine_->runtimeDef());
    scene_.setTier(runtime_->tier());
    HairDef def;
    def.settings.solver = Solver::kClassic;
    def.material.fiberRadius = 0.001f;
    ASSERT_TRUE(scene_.addHair(makeAsset(20), def));
  }
  void TearDown() override { close(); }

  static View view() {
    return cameraView({.eye = {0.1f, 0.04f, 0.4f}, .target = {0.1f, 0.04f, 0}, .width = kSize});
  }

  /// The colour; fails where something else was written.
  Pixels draw(const TargetKind& kind, Transparency method) {
    SCOPED_TRACE(std::string(kind.name) + ", method " +
                 std::to_string(static_cast<uint32_t>(method)));
    const VulkanTarget target(*engine_, kind);
    const Engine::Frame& slot = frames_[0];
    engine_->begin(slot);
    ++frame_;
    runtime_->beginFrame(frame_, frame_ - 1);
    Result<Frame> made = scene_.simulate(0);
    EXPECT_TRUE(made);
    const Light light;
    const Result<uint32_t> drawn = made->draw(view(), {&light, 1}, {.method = method});
    EXPECT_TRUE(drawn) << drawn.error().message;
    vulkan::ViewTarget to;
    to.formats = target.formats();
    to.area = {{0, 0}, {kSize, kSize}};
    to.begin = [&](const FrameStep& step) { target.begin(slot.commands, step.listOfView == 0); };
    to.end = [&](const FrameStep&) { target.end(slot.commands); };
    target.prepare(slot.commands);
    expectOk(runtime_->record(*made, slot.commands, {&to, 1}));
    const std::vector<EngineBuffer> outs = target.copyOut(slot.commands);
    submit(slot);
    engine_->wait(slot);
    runtime_->collect(frame_);
    runtime_->forget(target.renderPass());

    Pixels pixels(size_t{kSize} * kSize);
    std::memcpy(pixels.data(), outs[0].mapped, pixels.size() * sizeof(uint32_t));
    expectUntouched(kind, outs);
    for (const EngineBuffer& out : outs) engine_->destroyBuffer(out);
    return pixels;
  }

  static void expectUntouched(const TargetKind& kind, const std::vector<EngineBuffer>& outs) {
    size_t next = 1;
    for (const VkFormat format : kind.others) {
      if (format == VK_FORMAT_UNDEFINED) continue;
      // 0.2 is 51 of 255.
      const uint32_t expected = format == VK_FORMAT_R32_UINT ? 0x01020304u : 0x33333333u;
      Pixels pixels(size_t{kSize} * kSize);
      std::memcpy(pixels.data(), outs[next].mapped, pixels.size() * sizeof(uint32_t));
      for (size_t i = 0; i < pixels.size(); ++i)
        ASSERT_EQ(pixels[i], expected) << "attachment " << next << ", pixel " << i;
      ++next;
    }
    if (!kind.attachesStencil) return;
    const auto* stencil = static_cast<const uint8_t*>(outs[next].mapped);
    for (size_t i = 0; i < size_t{kSize} * kSize; ++i)
      ASSERT_EQ(stencil[i], kClearedStencil) << "stencil of pixel " << i;
  }

  Scene scene_;
};

std::vector<TargetKind> targetKinds() {
  constexpr VkFormat kWords = VK_FORMAT_R32_UINT, kNone = VK_FORMAT_UNDEFINED;
  return {
      {.name = "depth of a combined image", .depth = kBoth},
      {.name = "depth and stencil", .depth = kBoth, .attachesStencil = true},
      {.name = "two colors", .others = {kColor}},
      {.name = "four colors, one an integer, one not there",
       .depth = kBoth,
       .attachesStencil = true,
       .others = {kWords, kNone, kColor}},
      {.name = "eight colors", .others = std::vector<VkFormat>(vulkan::kMaxOtherColors, kColor)},
      {.name = "render pass", .dynamic = false},
      {.name = "render pass with stencil",
       .dynamic = false,
       .depth = kBoth,
       .attachesStencil = true},
      {.name = "render pass with three colors and stencil",
       .dynamic = false,
       .depth = kBoth,
       .attachesStencil = true,
       .others = {kWords, kColor}},
  };
}

TEST_F(VulkanTargets, HairWritesTheFirstColorAndTheDepthAlone) {
  if (!engine_->dynamicRendering()) GTEST_SKIP() << "the device is older than Vulkan 1.3";
  for (const Transparency method :
       {Transparency::kStochastic, Transparency::kWindowed, Transparency::kShortCut}) {
    const Pixels expected = draw({.name = "one color and depth"}, method);
    size_t covered = 0;
    for (const uint32_t pixel : expected) covered += pixel != 0 ? 1u : 0u;
    ASSERT_GT(covered, 100u);
    const bool lists = method == Transparency::kWindowed;
    for (const TargetKind& kind : targetKinds()) {
      // Drivers make pipelines for each target: the others have the richest of each way.
      if (lists || kind.others.size() == 3 || (!kind.dynamic && !kind.others.empty())) {
        EXPECT_EQ(draw(kind, method), expected) << kind.name;
      }
    }
    // Lists are not tested against a depth that is not there.
    if (!lists) continue;
    EXPECT_EQ(draw({.name = "stencil alone",
                    .depth = VK_FORMAT_S8_UINT,
                    .attachesDepth = false,
                    .attachesStencil = true},
                   method),
              expected);
    EXPECT_EQ(draw({.name = "color alone", .attachesDepth = false}, method), expected);
  }
}

TEST_F(VulkanTargets, FormatsThatFitNothingAreRefusedByName) {
  const View camera = view();
  const Light light;
  PassList list;
  expectOk(scene_.simulate(1.0f / 60, list));
  list.clear();
  expectOk(scene_.draw(camera, light, list));
  struct Wrong {
    const char* word;
    std::function<void(vulkan::TargetFormats&)> make;
  };
  const Wrong wrongs[] = {
      {"otherColorCount is 8", [](vulkan::TargetFormats& f) { f.otherColorCount = 8; }},
      {"otherColorCount is 4294967295", [](vulkan::TargetFormats& f) { f.otherColorCount = ~0u; }},
      {"TargetFormats::depth", [](vulkan::TargetFormats& f) { f.depth = kColor; }},
      {"TargetFormats::depth", [](vulkan::TargetFormats& f) { f.depth = VK_FORMAT_S8_UINT; }},
      {"TargetFormats::stencil", [](vulkan::TargetFormats& f) { f.stencil = f.depth; }},
      {"one image",
       [](vulkan::TargetFormats& f) {
         f.depth = VK_FORMAT_D32_SFLOAT;
         f.stencil = VK_FORMAT_S8_UINT;
       }},
  };
  for (const Wrong& wrong : wrongs) {
    vulkan::TargetFormats formats;
    wrong.make(formats);
    expectError(runtime_->prepare(list, &formats), {wrong.word, "strand_pixel"});
  }
  // A device without independentBlend.
  vulkan::RuntimeDef def = engine_->runtimeDef();
  def.enabledFeatures.independentBlend = VK_FALSE;
  Result<Runtime> small = required(Runtime::create(def));
  vulkan::TargetFormats two;
  two.otherColorCount = 1;
  two.otherColors = {kColor};
  expectError(small->prepare(list, &two), ErrorCode::kUnsupported, "independentBlend");
}

TEST_F(VulkanTargets, AMethodWithoutItsFeatureIsKnownBeforeAFrame) {
  vulkan::RuntimeDef def = engine_->runtimeDef();
  def.enabledFeatures.fragmentStoresAndAtomics = VK_FALSE;
  Result<Runtime> made = required(Runtime::create(def));
  const vulkan::TargetFormats formats;
  for (uint8_t i = 0; i <= static_cast<uint8_t>(Transparency::kTiles); ++i) {
    const TransparencySettings settings = {.method = static_cast<Transparency>(i)};
    EXPECT_TRUE(runtime_->supports(settings)) << int{i};
    const Result<void> said = made->supports(settings);
    const Result<PassList> list = required(listToDraw(settings, {}, made->tier()));
    const Result<void> prepared = made->prepare(*list, &formats);
    ASSERT_EQ(said.ok(), prepared.ok()) << int{i};
    const bool stores = settings.method != Transparency::kAlphaTest &&
                        settings.method != Transparency::kStochastic &&
                        settings.method != Transparency::kTiles;
    EXPECT_EQ(said.ok(), !stores) << int{i};
    if (said.ok()) continue;
    EXPECT_EQ(said.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(said.error().message, prepared.error().message);
    EXPECT_NE(said.error().message.find("fragmentStoresAndAtomics"), std::string::npos)
        << said.error().message;
  }
}

// The one that runs: nothing was recorded before it is refused.
TEST_F(VulkanTargets, AnAreaThatIsNotTheViewsIsRefusedBeforeARenderPassBegins) {
  engine_->begin(frames_[0]);
  runtime_->beginFrame(1, 0);
  Result<Frame> made = required(scene_.simulate(1.0f / 60));
  const Light light;
  ASSERT_TRUE(made->draw(view(), {&light, 1}));
  vulkan::ViewTarget to;
  to.area = {{0, 0}, {kSize + 1, kSize}};
  to.begin = [](const FrameStep&) { ADD_FAILURE() << "a render pass has begun"; };
  expectError(runtime_->record(*made, frames_[0].commands, {&to, 1}),
              {"view 0", "49 x 48", "48 x 48"});
  engine_->discard(frames_[0]);
}

TEST_F(VulkanTargets, BuffersThatATrimTookAreSaidToBeGoneWithIt) {
  engine_->begin(frames_[0]);
  runtime_->beginFrame(1, 0);
  Result<Frame> made = required(scene_.simulate(1.0f / 60));
  const Light light;
  ASSERT_TRUE(made->draw(view(), {&light, 1}, {.method = Transparency::kWindowed}));
  expectOk(made->finish());
  scene_.trim();
  vulkan::ViewTarget to;
  to.area = {{0, 0}, {kSize, kSize}};
  to.begin = to.end = [](const FrameStep&) { ADD_FAILURE() << "a render pass"; };
  expectError(runtime_->record(*made, frames_[0].commands, {&to, 1}),
              "Scene::trim() freed its buffers");
  engine_->discard(frames_[0]);
}

TEST_F(VulkanTargets, OtherSamplesThanTheViewsAndMissingCallbacksAreRefused) {
  engine_->begin(frames_[0]);
  runtime_->beginFrame(1, 0);
  Result<Frame> made = required(scene_.simulate(1.0f / 60));
  const Light light;
  View smooth = view();
  smooth.samples = 4;
  ASSERT_TRUE(made->draw(smooth, {&light, 1}));
  vulkan::ViewTarget to;
  to.area = {{0, 0}, {kSize, kSize}};
  const auto expectRefused = [&](std::initializer_list<std::string_view> words) {
    expectError(runtime_->record(*made, frames_[0].commands, {&to, 1}), words);
  };
  expectRefused({"view 0", "ViewTarget::begin"});
  to.begin = [](const FrameStep&) { ADD_FAILURE() << "a render pass has begun"; };
  expectRefused({"view 0", "ViewTarget::end"});
  to.end = to.begin;
  expectRefused({"view 0", "1 sample", "View::samples is 4"});
  // The call for each list says the same.
  for (const FrameStep& step : made->steps()) {
    if (step.view == FrameStep::kNoView) continue;
    expectError(runtime_->recordDraws(*step.list, frames_[0].commands, to.formats, to.area),
                "View::samples is 4");
  }
  engine_->discard(frames_[0]);
}

}  // namespace
}  // namespace pelage::test
