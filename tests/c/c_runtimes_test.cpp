// The C interface on the devices of an engine: its runtimes draw the pictures, and leave the
// positions, of those of C++.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "c/c_objects.h"
#include "pelage/scene.h"
#include "support/gpu_fixture.h"
#include "support/plain_asset.h"
#include "support/views.h"
#if PELAGE_TEST_VULKAN
#include "vulkan/vulkan_target.h"
#endif
#if PELAGE_TEST_GL
#include "gl/gl_target.h"
#endif

namespace pelage::test {
namespace {

constexpr uint32_t kPixels = 48;
constexpr uint32_t kFrames = 8;

View viewOfHair() {
  return cameraView({.eye = {0.1f, 0.04f, 0.4f}, .target = {0.1f, 0.04f, 0}, .width = kPixels});
}
pelage_view cViewOfHair() {
  const float eye[3] = {0.1f, 0.04f, 0.4f}, target[3] = {0.1f, 0.04f, 0}, up[3] = {0, 1, 0};
  auto view = made(pelage_view_init);
  view.width = view.height = kPixels;
  expectOk(pelage_view_look_at(&view, eye, target, up, 0.5f, 0.05f, 5));
  return view;
}

// The same hair in each interface: thick enough to be seen.
struct CppHair {
  CppHair() {
    HairDef def;
    def.material.fiberRadius = 0.001f;
    id = *required(scene.addHair(makeAsset(20), def));
  }
  Scene scene;
  HairId id;
};
struct CHair {
  CHair() {
    const HairAsset from = makeAsset(20);
    auto def = made(pelage_asset_def_init);
    def.strand_count = from.strandCount;
    def.vertices_per_strand = from.verticesPerStrand;
    def.positions = &from.positions.data()->x;
    Handle<pelage_asset> asset(pelage_asset_create, &def);
    Handle<pelage_settings> settings(pelage_settings_create);
    const double radius = 0.001;
    expectOk(pelage_settings_set(settings, "material.fiberRadius", &radius, 1));
    auto hairDef = made(pelage_hair_def_init);
    hairDef.settings = settings;
    expectOk(pelage_scene_add_hair(scene, asset, &hairDef, &id));
  }
  pelage_buffer_id positions() const { return infoOf(scene, id).positions; }
  Handle<pelage_scene> scene{pelage_scene_create};
  pelage_id id = 0;
};

// The results of some frames, the last of which is drawn.
struct Outcome {
  std::vector<std::byte> positions;
  std::vector<uint32_t> pixels;
  bool operator==(const Outcome&) const = default;
};

#if PELAGE_TEST_VULKAN
using runtime_test::EngineBuffer;
using runtime_test::EngineRun;

class CVulkan : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override {
    VkPhysicalDeviceFeatures features = {};
    features.fragmentStoresAndAtomics = features.vertexPipelineStoresAndAtomics = VK_TRUE;
    open(features);
    if (engine_ != nullptr) target_.emplace(*engine_, kind_);
  }
  void TearDown() override {
    target_.reset();
    close();
  }

  pelage_vulkan_runtime_def runtimeDef() const {
    const vulkan::RuntimeDef from = engine_->runtimeDef();
    auto def = made(pelage_vulkan_runtime_def_init);
    def.instance = from.instance;
    def.physical_device = from.physicalDevice;
    def.device = from.device;
    def.queue_family = from.queueFamily;
    def.enabled_features = &engine_->features();
    def.get_instance_proc_addr = reinterpret_cast<pelage_function>(from.getInstanceProcAddr);
    def.debug_utils = 1;
    return def;
  }
  pelage_vulkan_target targetOfC() {
    auto to = made(pelage_vulkan_target_init);
    to.color = target_->formats().color;
    to.depth = target_->formats().depth;
    to.render_pass = reinterpret_cast<uint64_t>(target_->formats().renderPass);
    to.width = to.height = kPixels;
    to.user = this;
    to.begin = [](void* user, uint32_t view, uint32_t list) {
      EXPECT_EQ(view, 0u);
      auto& test = *static_cast<CVulkan*>(user);
      test.target_->begin(test.frames_[0].commands, list == 0);
    };
    to.end = [](void* user, uint32_t, uint32_t) {
      auto& test = *static_cast<CVulkan*>(user);
      test.target_->end(test.frames_[0].commands);
    };
    return to;
  }
  // Records a frame into the commands of the engine, and runs them.
  template <class Record>
  std::vector<uint32_t> runFrame(bool drawn, Record record) {
    engine_->begin(frames_[0]);
    if (drawn) target_->prepare(frames_[0].commands);
    record(frames_[0].commands);
    const auto outs = drawn ? target_->copyOut(frames_[0].commands) : std::vector<EngineBuffer>();
    engine_->submit(frames_[0]);
    engine_->wait(frames_[0]);
    if (!drawn) return {};
    std::vector<uint32_t> pixels(size_t{kPixels} * kPixels);
    std::memcpy(pixels.data(), outs[0].mapped, pixels.size() * sizeof(uint32_t));
    engine_->destroyBuffer(outs[0]);
    return pixels;
  }

  const TargetKind kind_ = {.name = "color and depth", .dynamic = false};
  std::optional<VulkanTarget> target_;
};

TEST_F(CVulkan, HasThePictureAndThePositionsOfCpp) {
  Outcome cpp, c;
  {
    CppHair hair;
    createRuntime(engine_->runtimeDef());
    for (uint32_t i = 1; i <= kFrames; ++i) {
      cpp.pixels = runFrame(i == kFrames, [&](VkCommandBuffer commands) {
        runtime_->beginFrame(i, i - 1);
        Result<Frame> frame = required(hair.scene.simulate(kDt));
        vulkan::ViewTarget to;
        to.formats = target_->formats();
        to.area = {{0, 0}, {kPixels, kPixels}};
        to.begin = [&](const FrameStep& step) { target_->begin(commands, step.listOfView == 0); };
        to.end = [&](const FrameStep&) { target_->end(commands); };
        const Light light;
        if (i == kFrames) {
          EXPECT_TRUE(frame->draw(viewOfHair(), {&light, 1}));
        }
        expectOk(runtime_->record(*frame, commands, {&to, i == kFrames ? 1u : 0u}));
        runtime_->submitted();
      });
    }
    cpp.positions = read(hair.scene.hair(hair.id).buffers().positions);
  }
  {
    CHair hair;
    const pelage_vulkan_runtime_def def = runtimeDef();
    Handle<pelage_vulkan_runtime> runtime(pelage_vulkan_runtime_create, &def);
    expectOk(pelage_scene_set_tier_of(hair.scene, static_cast<pelage_vulkan_runtime*>(runtime)));
    const pelage_view view = cViewOfHair();
    const pelage_vulkan_target to = targetOfC();
    for (uint32_t i = 1; i <= kFrames; ++i) {
      c.pixels = runFrame(i == kFrames, [&](VkCommandBuffer commands) {
        expectOk(pelage_vulkan_begin_frame(runtime, i, i - 1));
        Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(hair.scene),
                                   kDt);
        if (i == kFrames) expectOk(pelage_frame_draw(frame, &view, nullptr, nullptr));
        expectOk(pelage_vulkan_record(runtime, frame, commands, &to, i == kFrames ? 1 : 0));
        expectOk(pelage_vulkan_submitted(runtime));
      });
    }
    expectOk(pelage_vulkan_collect(runtime, kFrames));
    uint64_t buffer = 0, offset = 0, size = 0;
    expectOk(pelage_vulkan_buffer(runtime, hair.positions(), &buffer, &offset, &size));
    vulkan::BufferRange range;
    range.buffer = reinterpret_cast<VkBuffer>(buffer);
    range.offset = offset;
    range.size = size;
    c.positions = engine_->read(range, copies_);
  }
  EXPECT_GT(std::count_if(cpp.pixels.begin(), cpp.pixels.end(), [](uint32_t p) { return p != 0; }),
            100);
  EXPECT_TRUE(cpp == c);
}

TEST_F(CVulkan, IsRefusedWhereCppAssertsOrRefuses) {
  pelage_vulkan_runtime* none = nullptr;
  auto empty = made(pelage_vulkan_runtime_def_init);
  expectInvalid(pelage_vulkan_runtime_create(&empty, &none), "");
  EXPECT_EQ(none, nullptr);
  CHair hair;
  const pelage_vulkan_runtime_def def = runtimeDef();
  Handle<pelage_vulkan_runtime> runtime(pelage_vulkan_runtime_create, &def);
  Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(hair.scene), kDt);
  engine_->begin(frames_[0]);
  VkCommandBuffer commands = frames_[0].commands;
  expectInvalid(pelage_vulkan_record(runtime, frame, commands, nullptr, 0),
                "begin_frame() comes first");
  expectInvalid(pelage_vulkan_begin_frame(runtime, 0, 0), "numbers rise");
  expectInvalid(pelage_vulkan_begin_frame(runtime, 2, 2), "numbers rise");
  expectInvalid(pelage_vulkan_collect(runtime, 1), "has not begun");
  expectOk(pelage_vulkan_begin_frame(runtime, 2, 0));
  expectInvalid(pelage_vulkan_begin_frame(runtime, 2, 0), "behind frame 2");
  expectInvalid(pelage_vulkan_record(runtime, frame, nullptr, nullptr, 0), "command buffer");
  pelage_vulkan_target to = targetOfC();
  expectInvalid(pelage_vulkan_record(runtime, frame, commands, nullptr, 1), "'targets' is NULL");
  expectInvalid(pelage_vulkan_record(runtime, frame, commands, &to, 1), "0 views");
  const pelage_view view = cViewOfHair();
  expectOk(pelage_frame_draw(frame, &view, nullptr, nullptr));
  to.end = nullptr;
  expectInvalid(pelage_vulkan_record(runtime, frame, commands, &to, 1), "ViewTarget::end");
  to.struct_size = 8;
  expectInvalid(pelage_vulkan_record(runtime, frame, commands, &to, 1), "pelage_vulkan_target");
  uint64_t buffer = 0, offset = 0, size = 0;
  expectInvalid(pelage_vulkan_buffer(runtime, hair.positions(), &buffer, &offset, &size),
                "no buffer");
  expectInvalid(pelage_vulkan_register_buffer(runtime, hair.positions(), 0, 0), "0");
  expectInvalid(pelage_vulkan_register_buffer(runtime, hair.positions(), 1, 2), "multiple of 4");
  to = targetOfC();
  expectOk(pelage_vulkan_record(runtime, frame, commands, &to, 1));
  expectInvalid(pelage_vulkan_register_buffer(runtime, hair.positions(), 1, 0), "has a buffer");
  float number = 0;
  expectInvalid(pelage_read(runtime, hair.positions(), 0, &number, 4),
                "is a pelage_vulkan_runtime");
  expectOk(pelage_vulkan_abandon_frame(runtime));
  engine_->discard(frames_[0]);
}

// A buffer of the engine in place of one of the runtime's.
TEST_F(CVulkan, TakesABufferOfTheEngine) {
  CHair hair;
  const pelage_vulkan_runtime_def def = runtimeDef();
  Handle<pelage_vulkan_runtime> runtime(pelage_vulkan_runtime_create, &def);
  const EngineBuffer own = engine_->createBuffer(
      20 * 8 * sizeof(Float4),
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
  const auto handle = reinterpret_cast<uint64_t>(own.buffer);
  expectOk(pelage_vulkan_register_buffer(runtime, hair.positions(), handle, 0));
  runFrame(false, [&](VkCommandBuffer commands) {
    expectOk(pelage_vulkan_begin_frame(runtime, 1, 0));
    Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(hair.scene), kDt);
    expectOk(pelage_vulkan_record(runtime, frame, commands, nullptr, 0));
    expectOk(pelage_vulkan_submitted(runtime));
  });
  uint64_t buffer = 0, offset = 1, size = 0;
  expectOk(pelage_vulkan_buffer(runtime, hair.positions(), &buffer, &offset, &size));
  EXPECT_EQ(buffer, handle);
  EXPECT_EQ(offset, 0u);
  EXPECT_EQ(static_cast<const Float4*>(own.mapped)[0].x, makeAsset(20).positions[0].x);
  EXPECT_GT(static_cast<const Float4*>(own.mapped)[9].y, 0.005f);
  runtime.destroy();
  engine_->destroyBuffer(own);
}
#endif

#if PELAGE_TEST_GL
class CGl : public GlContextTest {
 protected:
  static pelage_function address(const char* name) {
    return reinterpret_cast<pelage_function>(eglGetProcAddress(name));
  }
  static pelage_gl_runtime_def runtimeDef() {
    auto def = made(pelage_gl_runtime_def_init);
    def.get_proc_address = address;
    def.debug = 1;
    return def;
  }
};
INSTANTIATE_TEST_SUITE_P(All, CGl, testing::Values(Api::kGl, Api::kGles), apiTestName);

TEST_P(CGl, HasThePictureAndThePositionsOfCpp) {
  const GlTarget target(kPixels, kPixels);
  std::vector<float> pixels[2];
  std::vector<std::byte> positions;
  {
    CppHair hair;
    gl::RuntimeDef def;
    def.getProcAddress = eglAddress;
    Result<gl::Runtime> runtime = required(gl::Runtime::create(std::move(def)));
    hair.scene.setTier(runtime->tier());
    for (uint32_t i = 1; i <= kFrames; ++i) {
      Result<Frame> frame = required(hair.scene.simulate(kDt));
      const gl::ViewTarget to = {
          target.area(), [&](const FrameStep& step) { target.begin(step.listOfView == 0); }};
      const Light light;
      if (i == kFrames) {
        ASSERT_TRUE(frame->draw(viewOfHair(), {&light, 1}));
      }
      expectOk(runtime->record(*frame, {&to, i == kFrames ? 1u : 0u}));
    }
    pixels[0] = target.pixels();
    positions = *required(runtime->read(hair.scene.hair(hair.id).buffers().positions));
    target.begin(true);
  }
  CHair hair;
  const pelage_gl_runtime_def def = runtimeDef();
  Handle<pelage_gl_runtime> runtime(pelage_gl_runtime_create, &def);
  expectOk(pelage_scene_set_tier_of(hair.scene, static_cast<pelage_gl_runtime*>(runtime)));
  auto to = made(pelage_gl_target_init);
  to.width = to.height = kPixels;
  to.user = const_cast<GlTarget*>(&target);
  to.begin = [](void* user, uint32_t, uint32_t list) {
    static_cast<const GlTarget*>(user)->begin(list == 0);
  };
  const pelage_view view = cViewOfHair();
  for (uint32_t i = 1; i <= kFrames; ++i) {
    Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(hair.scene), kDt);
    if (i == kFrames) expectOk(pelage_frame_draw(frame, &view, nullptr, nullptr));
    expectOk(pelage_gl_record(runtime, frame, &to, i == kFrames ? 1 : 0, i % 2));
  }
  pixels[1] = target.pixels();
  EXPECT_GT(std::count_if(pixels[0].begin(), pixels[0].end(), [](float v) { return v > 0; }), 300);
  EXPECT_EQ(pixels[0], pixels[1]);
  std::vector<std::byte> read(positions.size());
  expectOk(pelage_read(runtime, hair.positions(), 0, read.data(), read.size()));
  EXPECT_EQ(positions, read);
  uint32_t name = 0;
  expectOk(pelage_gl_buffer(runtime, hair.positions(), &name));
  EXPECT_NE(name, 0u);
}

TEST_P(CGl, IsRefusedWhereCppAssertsOrRefuses) {
  pelage_gl_runtime* none = nullptr;
  auto empty = made(pelage_gl_runtime_def_init);
  expectInvalid(pelage_gl_runtime_create(&empty, &none), "get_proc_address");
  const pelage_gl_runtime_def def = runtimeDef();
  Handle<pelage_gl_runtime> runtime(pelage_gl_runtime_create, &def);
  CHair hair;
  Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(hair.scene), kDt);
  auto to = made(pelage_gl_target_init);
  expectInvalid(pelage_gl_record(runtime, frame, &to, 1, 0), "0 views");
  expectInvalid(pelage_gl_register_buffer(runtime, 0, 1), "id");
  expectInvalid(pelage_gl_register_buffer(runtime, hair.positions(), 4711), "4711");
  uint32_t name = 5;
  expectInvalid(pelage_gl_buffer(runtime, hair.positions(), &name), "no buffer");
  EXPECT_EQ(name, 0u);
  expectOk(pelage_gl_record(runtime, frame, nullptr, 0, 0));
  float numbers[4] = {};
  expectInvalid(pelage_read(runtime, hair.positions(), 1 << 20, numbers, 16), "");
  expectInvalid(pelage_read(runtime, 77, 0, numbers, 16), "");
  expectInvalid(pelage_read(runtime, hair.positions(), 0, numbers, 0), "no room");
}
#endif

}  // namespace
}  // namespace pelage::test
