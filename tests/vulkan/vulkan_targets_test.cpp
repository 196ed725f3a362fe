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
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;
using runtime_test::EngineRun;
using runtime_test::tagged;
using Image = runtime_test::EngineImage;
using vulkan::Runtime;

constexpr uint32_t kSize = 48;
constexpr VkFormat kColor = VK_FORMAT_R8G8B8A8_UNORM;
constexpr VkFormat kBoth = VK_FORMAT_D32_SFLOAT_S8_UINT;
constexpr uint32_t kClearedStencil = 7;

/// Targets of an engine.
struct TargetKind {
  const char* name;
  bool dynamic = true;
  VkFormat depth = VK_FORMAT_D32_SFLOAT;  ///< of the image
  bool attachesDepth = true, attachesStencil = false;
  std::vector<VkFormat> others = {};  ///< VK_FORMAT_UNDEFINED: a hole
};

VkImageAspectFlags aspectsOf(VkFormat format) {
  if (format == VK_FORMAT_S8_UINT) return VK_IMAGE_ASPECT_STENCIL_BIT;
  if (format == kBoth) return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
  if (format == VK_FORMAT_D32_SFLOAT) return VK_IMAGE_ASPECT_DEPTH_BIT;
  return VK_IMAGE_ASPECT_COLOR_BIT;
}

VkClearValue clearOf(VkFormat format) {
  VkClearValue clear = {};
  if (aspectsOf(format) != VK_IMAGE_ASPECT_COLOR_BIT) {
    clear.depthStencil = {1, kClearedStencil};
  } else if (format == VK_FORMAT_R32_UINT) {
    clear.color.uint32[0] = 0x01020304;
  } else {
    for (float& value : clear.color.float32) value = 0.2f;
  }
  return clear;
}

/// The images of a target on an engine's device.
class Target {
 public:
  Target(const Engine& engine, const TargetKind& kind) : engine_(engine), kind_(kind) {
    color_ = make(kColor);
    if (kind.attachesDepth || kind.attachesStencil) depth_ = make(kind.depth);
    for (const VkFormat format : kind.others)
      others_.push_back(format != VK_FORMAT_UNDEFINED ? make(format) : Image{});
    if (kind.dynamic) return;
    for (const bool load : {false, true}) passes_[load ? 1 : 0] = makePass(load);
    std::vector<VkImageView> views;
    for (const Image* image : attachments()) views.push_back(image->view);
    auto info = tagged<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
    info.renderPass = passes_[0];
    info.attachmentCount = static_cast<uint32_t>(views.size());
    info.pAttachments = views.data();
    info.width = info.height = kSize;
    info.layers = 1;
    EXPECT_EQ(vkCreateFramebuffer(engine.device(), &info, nullptr, &framebuffer_), VK_SUCCESS);
  }
  ~Target() {
    vkDestroyFramebuffer(engine_.device(), framebuffer_, nullptr);
    for (const VkRenderPass pass : passes_) vkDestroyRenderPass(engine_.device(), pass, nullptr);
    for (const Image* image : attachments()) engine_.destroyImage(*image);
  }
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  vulkan::TargetFormats formats() const {
    vulkan::TargetFormats formats;
    formats.color = kColor;
    formats.depth = kind_.attachesDepth ? kind_.depth : VK_FORMAT_UNDEFINED;
    formats.renderPass = passes_[0];
    if (kind_.dynamic && kind_.attachesStencil) formats.stencil = kind_.depth;
    formats.otherColorCount = static_cast<uint32_t>(kind_.others.size());
    if (kind_.dynamic)
      std::copy(kind_.others.begin(), kind_.others.end(), formats.otherColors.begin());
    return formats;
  }
  VkRenderPass renderPass() const { return passes_[0]; }

  /// Before the first render pass.
  void prepare(VkCommandBuffer commands) const {
    for (const Image* image : attachments()) {
      transition(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, attachmentLayout(*image));
    }
  }
  void begin(VkCommandBuffer commands, bool clears) const {
    auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
    if (kind_.dynamic)
      beginRendering(commands, clears);
    else
      beginPass(commands, clears);
  }
  void end(VkCommandBuffer commands) const {
    if (kind_.dynamic)
      vkCmdEndRendering(commands);
    else
      vkCmdEndRenderPass(commands);
  }
  /// [0] the first color, then the others without holes, and the stencil last where there is one.
  std::vector<EngineBuffer> copyOut(VkCommandBuffer commands) const {
    std::vector<EngineBuffer> outs;
    const auto copy = [&](const Image& image, VkImageAspectFlags aspect) {
      outs.push_back(engine_.createBuffer(VkDeviceSize{kSize} * kSize * 16,
                                          VK_BUFFER_USAGE_TRANSFER_DST_BIT, true));
      std::memset(outs.back().mapped, 0, size_t{kSize} * kSize * 16);
      transition(commands, image, attachmentLayout(image), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
      VkBufferImageCopy region = {};
      region.imageSubresource = {aspect, 0, 0, 1};
      region.imageExtent = {kSize, kSize, 1};
      vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                             outs.back().buffer, 1, &region);
    };
    copy(color_, VK_IMAGE_ASPECT_COLOR_BIT);
    for (const Image& other : others_)
      if (other.image != VK_NULL_HANDLE) copy(other, VK_IMAGE_ASPECT_COLOR_BIT);
    if (kind_.attachesStencil) copy(depth_, VK_IMAGE_ASPECT_STENCIL_BIT);
    return outs;
  }

 private:
  // In the order of a render pass.
  std::vector<const Image*> attachments() const {
    std::vector<const Image*> all = {&color_};
    for (const Image& other : others_)
      if (other.image != VK_NULL_HANDLE) all.push_back(&other);
    if (depth_.image != VK_NULL_HANDLE) all.push_back(&depth_);
    return all;
  }
  static VkImageLayout attachmentLayout(const Image& image) {
    return image.aspects == VK_IMAGE_ASPECT_COLOR_BIT
               ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
               : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  }
  static void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from,
                         VkImageLayout to) {
    auto barrier = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.image;
    barrier.subresourceRange = {image.aspects, 0, 1, 0, 1};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &barrier);
  }

  Image make(VkFormat format) const {
    return engine_.createImage(format, aspectsOf(format), kSize);
  }

  VkRenderPass makePass(bool load) const {
    std::vector<VkAttachmentDescription> descriptions;
    std::vector<VkAttachmentReference> colors;
    VkAttachmentReference depth = {VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_UNDEFINED};
    for (const Image* image : attachments()) {
      const VkImageLayout layout = attachmentLayout(*image);
      const VkAttachmentReference reference = {static_cast<uint32_t>(descriptions.size()), layout};
      if (image == &depth_)
        depth = reference;
      else
        colors.push_back(reference);
      VkAttachmentDescription description = {};
      description.format = image->format;
      description.samples = VK_SAMPLE_COUNT_1_BIT;
      description.loadOp = load ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
      description.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
      description.stencilLoadOp = description.loadOp;
      description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE;
      description.initialLayout = description.finalLayout = layout;
      descriptions.push_back(description);
    }
    VkSubpassDescription subpass = {};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    subpass.pColorAttachments = colors.data();
    subpass.pDepthStencilAttachment = &depth;
    auto info = tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    info.attachmentCount = static_cast<uint32_t>(descriptions.size());
    info.pAttachments = descriptions.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    VkRenderPass pass = VK_NULL_HANDLE;
    EXPECT_EQ(vkCreateRenderPass(engine_.device(), &info, nullptr, &pass), VK_SUCCESS);
    return pass;
  }

  void beginPass(VkCommandBuffer commands, bool clears) const {
    std::vector<VkClearValue> values;
    for (const Image* image : attachments())
      values.push_back(image == &color_ ? VkClearValue{} : clearOf(image->format));
    auto info = tagged<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    info.renderPass = passes_[clears ? 0 : 1];
    info.framebuffer = framebuffer_;
    info.renderArea.extent = {kSize, kSize};
    info.clearValueCount = static_cast<uint32_t>(values.size());
    info.pClearValues = values.data();
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
  }

  void beginRendering(VkCommandBuffer commands, bool clears) const {
    const auto attach = [&](const Image& image) {
      auto info = tagged<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
      info.imageView = image.view;
      if (image.view == VK_NULL_HANDLE) return info;
      info.imageLayout = attachmentLayout(image);
      info.loadOp = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
      info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
      if (&image != &color_) info.clearValue = clearOf(image.format);
      return info;
    };
    std::vector<VkRenderingAttachmentInfo> colors = {attach(color_)};
    for (const Image& other : others_) colors.push_back(attach(other));
    const VkRenderingAttachmentInfo depth = attach(depth_);
    auto info = tagged<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
    info.renderArea.extent = {kSize, kSize};
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    info.pColorAttachments = colors.data();
    if (kind_.attachesDepth) info.pDepthAttachment = &depth;
    if (kind_.attachesStencil) info.pStencilAttachment = &depth;
    vkCmdBeginRendering(commands, &info);
  }

  const Engine& engine_;
  const TargetKind& kind_;
  Image color_, depth_;
  std::vector<Image> others_;
  VkRenderPass passes_[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
  VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
};

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
    const Target target(*engine_, kind);
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
