// The OpenGL and OpenGL ES runtime, on core 4.5 and on ES 3.2. The kernels are written here, in the
// common subset of both languages, so that these tests need nothing but the runtime; that codegen's
// kernels run on it is tested with the kernels.
#include "pelage/gl.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine_context.h"
#include "pelage/headless.h"
#include "support/required_devices.h"
#include "support/test_code.h"
#include "support/texture_list.h"

namespace pelage {
namespace {

using test::eglAddress;
using test::EngineContext;
using test::glFunction;
using ::testing::TestWithParam;
using ::testing::Values;

// A kernel with its tables, from one GLSL text.
struct TestKernel {
  std::string name, glsl, essl;
  std::vector<LayoutEntry> entries;
  LayoutTable layout;
  const LayoutTable* layouts[1];
  std::vector<SpecConstant> constants;
  std::vector<VariantBinding> bindings;
  Kernel kernel;
  KernelVariant variant;

  TestKernel(const TestKernel&) = delete;
  TestKernel(std::string name_, Stage stage, const std::string& body,
             std::vector<LayoutEntry> entries_, std::vector<SpecConstant> constants_ = {},
             uint32_t groupSize = 64)
      : name(std::move(name_)),
        glsl("#version 450\n" + body),
        essl("#version 320 es\nprecision highp float;\nprecision highp int;\n" + body),
        entries(std::move(entries_)),
        layout{"Test", "test", 0, entries},
        layouts{&layout},
        constants(std::move(constants_)) {
    for (size_t i = 0; i < entries.size(); ++i)
      if ((entries[i].stages & stageBit(stage)) != 0)
        bindings.push_back({0, static_cast<uint8_t>(i), entries[i].access,
                            static_cast<uint8_t>(entries[i].glBinding)});
    kernel = {name.c_str(), stage, layouts, constants, {}};
    const bool compute = stage == Stage::kCompute;
    variant = {&kernel, "", bindings, {}, test::freshHash()};
    variant.groupSize[0] = compute ? groupSize : 0;
    variant.groupSize[1] = variant.groupSize[2] = compute ? 1 : 0;
  }

  /// Gives its code to a Runtime or a HeadlessDevice.
  template <class Receiver>
  void addTo(Receiver& receiver) const {
    const KernelCode* const code[] = {
        test::makeCode(kernel, CodeFormat::kGlsl, variant.hash, glsl),
        test::makeCode(kernel, CodeFormat::kEssl, variant.hash, essl)};
    receiver.addCode(code);
  }
};

LayoutEntry storage(const char* name, Access access, uint32_t glBinding,
                    StageMask stages = stageBit(Stage::kCompute)) {
  return {name, "uint", ResourceKind::kStorageBuffer, access, stages, 4, glBinding, glBinding};
}
LayoutEntry uniform(const char* name, uint32_t size, uint32_t glBinding, StageMask stages) {
  return {name, name, ResourceKind::kUniformBuffer, Access::kRead, stages, size, 0, glBinding};
}

struct AccumulateConstants {
  uint32_t count = 0, factor = 1, bias = 0, pad = 0;
};

constexpr char kAccumulate[] = R"(
layout(local_size_x = 64) in;
layout(std140, binding = 0) uniform AccumulateConstants { uint count, factor, bias, pad; };
layout(std430, binding = 0) readonly buffer Source { uint g_source[]; };
layout(std430, binding = 1) buffer Target { uint g_target[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < count) g_target[i] = 3u * g_target[i] + factor * g_source[i] + bias;
}
)";

// target = 3 target + factor source + bias: not commutative, so that order shows.
std::unique_ptr<TestKernel> accumulateKernel() {
  return std::make_unique<TestKernel>(
      "accumulate", Stage::kCompute, kAccumulate,
      std::vector{uniform("AccumulateConstants", 16, 0, stageBit(Stage::kCompute)),
                  storage("g_source", Access::kRead, 0),
                  storage("g_target", Access::kReadWrite, 1)});
}

constexpr StageMask kVertexBit = stageBit(Stage::kVertex);
constexpr StageMask kPixelBit = stageBit(Stage::kPixel);

struct FillConstants {
  Float4 color, offset, instanceStep;
};

// As codegen translates it: y turned over and depth 0..1 mapped to -1..1.
constexpr char kFillVertex[] = R"(
layout(std140, binding = 0) uniform FillConstants { vec4 color, offset, instanceStep; };
layout(std430, binding = 0) readonly buffer Corners { vec4 corners[]; };
void main() {
  gl_Position = corners[gl_VertexID] + offset + instanceStep * float(gl_InstanceID);
  gl_Position.z = 2.0 * gl_Position.z - gl_Position.w;
  gl_Position.y = -gl_Position.y;
}
)";
constexpr char kFillPixel[] = R"(
layout(std140, binding = 0) uniform FillConstants { vec4 color, offset, instanceStep; };
layout(location = 0) out vec4 target;
void main() { target = color; }
)";

// The vertex and the pixel kernel of a draw share their layout table.
struct DrawKernels {
  std::vector<LayoutEntry> entries{uniform("FillConstants", 48, 0, kVertexBit | kPixelBit),
                                   storage("g_corners", Access::kRead, 0, kVertexBit)};
  TestKernel vertex{"fill_vertex", Stage::kVertex, kFillVertex, entries};
  TestKernel pixel{"fill_pixel", Stage::kPixel, kFillPixel, entries};
  DrawKernels() { pixel.layouts[0] = vertex.layouts[0]; }
  template <class Receiver>
  void addTo(Receiver& receiver) const {
    vertex.addTo(receiver);
    pixel.addTo(receiver);
  }
};

std::vector<std::byte> bytesOf(std::span<const uint32_t> values) {
  const auto bytes = std::as_bytes(values);
  return {bytes.begin(), bytes.end()};
}

template <class T>
std::vector<T> valuesOf(const std::vector<std::byte>& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

BufferId addBuffer(ResourceTable& table, const char* name, std::span<const uint32_t> values,
                   BufferUsage usage = BufferUsage::kStorage) {
  return table.add({name, values.size_bytes(), 4, usage, bytesOf(values)});
}
BufferId addZeros(ResourceTable& table, const char* name, uint64_t count,
                  BufferUsage usage = BufferUsage::kStorage) {
  return table.add({name, count * 4, 4, usage, {}});
}
BufferId addCorners(ResourceTable& table, const std::vector<Float4>& corners) {
  const auto bytes = std::as_bytes(std::span(corners));
  return table.add({"corners", bytes.size(), 16, BufferUsage::kStorage,
                    std::vector<std::byte>(bytes.begin(), bytes.end())});
}

std::vector<uint32_t> ramp(size_t count, uint32_t seed) {
  std::vector<uint32_t> values(count);
  std::mt19937 random(seed);
  for (uint32_t& value : values) value = static_cast<uint32_t>(random());
  return values;
}

void addAccumulate(PassList& list, const TestKernel& kernel, BufferId source, BufferId target,
                   uint32_t count, uint32_t factor, uint32_t bias) {
  PassBuilder builder(list);
  const Result<void> added =
      builder.dispatch(kernel.variant, count)
          .bind("g_source", source, uint64_t{count} * 4)
          .bind("g_target", target, uint64_t{count} * 4)
          .constants("AccumulateConstants", AccumulateConstants{count, factor, bias, 0})
          .finish();
  ASSERT_TRUE(added) << added.error().message;
}

void accumulateOnHost(const std::vector<uint32_t>& source, std::vector<uint32_t>& target,
                      uint32_t factor, uint32_t bias) {
  for (size_t i = 0; i < target.size(); ++i) target[i] = 3u * target[i] + factor * source[i] + bias;
}

void addDraw(PassList& list, const DrawKernels& kernels, const DrawState& state, BufferId corners,
             uint32_t cornerCount, const FillConstants& constants, uint32_t elements,
             uint32_t instances = 1, BufferId indices = BufferId::kInvalid) {
  PassBuilder builder(list);
  const Result<void> added =
      builder
          .draw(kernels.vertex.variant, kernels.pixel.variant, state, elements, instances, indices)
          .bind("g_corners", corners, uint64_t{cornerCount} * 16)
          .constants("FillConstants", constants)
          .finish();
  ASSERT_TRUE(added) << added.error().message;
}

// Clip positions, y up.
const std::vector<Float4> kEverything = {{-1, -1, 0, 1}, {3, -1, 0, 1}, {-1, 3, 0, 1}};
const std::vector<Float4> kUpperHalf = {{-1, 0, 0, 1}, {1, 0, 0, 1}, {-1, 1, 0, 1},
                                        {-1, 1, 0, 1}, {1, 0, 0, 1}, {1, 1, 0, 1}};

class GlTest : public TestWithParam<Api> {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessGl({GetParam(), true, -1});
    if (!made) {
      if (made.error().code == ErrorCode::kUnsupported)
        PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
      FAIL() << made.error().message;
    }
    device_ = std::move(*made);
  }
  void TearDown() override {
    if (!device_) return;
    EXPECT_EQ(device_->messageCount(), expectedMessages_);
  }

  void update() {
    const Result<void> updated = device_->update(table_);
    ASSERT_TRUE(updated) << updated.error().message;
  }
  void execute(PassList& list, std::vector<PassTiming>* timings = nullptr) {
    tracker_.resolve(list);
    const Result<void> done = device_->execute(list, timings);
    ASSERT_TRUE(done) << done.error().message;
  }
  RenderedImage render(PassList& list, const RenderTargetDef& target,
                       std::vector<PassTiming>* timings = nullptr) {
    tracker_.resolve(list);
    Result<RenderedImage> image = device_->render(list, target, timings);
    EXPECT_TRUE(image) << image.error().message;
    return image ? std::move(*image) : RenderedImage{};
  }
  std::vector<uint32_t> read(BufferId buffer, uint64_t offset = 0, uint64_t size = 0) {
    Result<std::vector<std::byte>> bytes = device_->read(buffer, offset, size);
    EXPECT_TRUE(bytes) << bytes.error().message;
    return bytes ? valuesOf<uint32_t>(*bytes) : std::vector<uint32_t>{};
  }

  std::unique_ptr<HeadlessDevice> device_;
  ResourceTable table_;
  HazardTracker tracker_;
  uint32_t expectedMessages_ = 0;
};

std::string apiSuffix(const ::testing::TestParamInfo<Api>& info) {
  return info.param == Api::kGles ? "Gles" : "Gl";
}
INSTANTIATE_TEST_SUITE_P(, GlTest, Values(Api::kGl, Api::kGles), apiSuffix);

TEST_P(GlTest, NamesItsDeviceAndVersion) {
  const DeviceInfo& info = device_->info();
  EXPECT_EQ(info.api, GetParam());
  EXPECT_FALSE(info.name.empty());
  EXPECT_FALSE(info.driver.empty());
  EXPECT_NE(info.version.find(GetParam() == Api::kGles ? "OpenGL ES 3.2" : "4."), std::string::npos)
      << info.version;
  EXPECT_GE(info.maxSamples, 4u);
  RecordProperty("device", info.name + ", " + info.driver + ", " + info.version);
}

TEST_P(GlTest, GivesAnErrorForADeviceThatIsNotThere) {
  const auto device = createHeadlessGl({GetParam(), false, 1000});
  ASSERT_FALSE(device);
  EXPECT_EQ(device.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(device.error().message.find("1000"), std::string::npos) << device.error().message;
}

TEST_P(GlTest, FillsBuffersWithInitialDataOrZeros) {
  const std::vector<uint32_t> initial = ramp(1000, 1);
  const BufferId filled = addBuffer(table_, "filled", initial);
  // Memory that was used before, so that the zeros below are not there by luck.
  constexpr size_t kCount = (3u << 20) / 4 + 5;  // more than one piece of the runtime's zeros
  for (int i = 0; i < 8; ++i) addBuffer(table_, "dirt", std::vector<uint32_t>(kCount, 0xdeadbeefu));
  update();
  for (uint32_t id = 1; id < table_.end(); id += 2) table_.remove(table_.at(id));
  update();
  const BufferId zeros = addZeros(table_, "zeros", kCount);
  update();
  EXPECT_EQ(read(filled), initial);
  EXPECT_EQ(read(filled, 400, 8), (std::vector<uint32_t>{initial[100], initial[101]}));
  const std::vector<uint32_t> words = read(zeros);
  EXPECT_EQ(words.size(), kCount);
  EXPECT_TRUE(std::all_of(words.begin(), words.end(), [](uint32_t word) { return word == 0; }));
}

TEST_P(GlTest, ForgetsRemovedBuffersAndKeepsTheOthers) {
  const BufferId first = addBuffer(table_, "first", ramp(10, 1));
  const BufferId second = addBuffer(table_, "second", ramp(10, 2));
  update();
  table_.remove(first);
  const BufferId third = addBuffer(table_, "third", ramp(10, 3));
  update();
  EXPECT_FALSE(device_->read(first));
  EXPECT_EQ(read(second), ramp(10, 2));
  EXPECT_EQ(read(third), ramp(10, 3));
}

TEST_P(GlTest, RunsChainedDispatchesInOrder) {
  constexpr uint32_t kCount = 10007;
  const auto kernel = accumulateKernel();
  kernel->addTo(*device_);
  std::vector<uint32_t> a = ramp(kCount, 1), b = ramp(kCount, 2);
  const BufferId bufferA = addBuffer(table_, "a", a);
  const BufferId bufferB = addBuffer(table_, "b", b);
  update();
  PassList list;
  for (uint32_t pass = 0; pass < 20; ++pass) {
    addAccumulate(list, *kernel, bufferA, bufferB, kCount, pass + 1, 7);
    addAccumulate(list, *kernel, bufferB, bufferA, kCount, 5, pass);
    accumulateOnHost(a, b, pass + 1, 7);
    accumulateOnHost(b, a, 5, pass);
  }
  execute(list);
  EXPECT_EQ(read(bufferA), a);
  EXPECT_EQ(read(bufferB), b);
}

TEST_P(GlTest, SeesTheUploadsOfEveryFrame) {
  constexpr uint32_t kCount = 513;
  const auto kernel = accumulateKernel();
  kernel->addTo(*device_);
  const BufferUsage usage = BufferUsage::kStorage | BufferUsage::kUpload;
  std::vector<uint32_t> whole(kCount), target(kCount), part = ramp(kCount, 9);
  const BufferId wholeBuffer = addZeros(table_, "whole", kCount, usage);
  const BufferId partBuffer = addBuffer(table_, "part", part, usage);
  const BufferId targetBuffer = addZeros(table_, "target", kCount);
  update();
  PassList list;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    list.clear();
    const size_t first = size_t{31} * frame;
    whole = ramp(kCount, frame);
    addUpload(list, wholeBuffer, std::as_bytes(std::span(whole)));
    const std::vector<uint32_t> piece = ramp(17, 100 + frame);
    std::copy(piece.begin(), piece.end(), part.begin() + static_cast<std::ptrdiff_t>(first));
    addUpload(list, partBuffer, std::as_bytes(std::span(piece)), first * 4);
    addAccumulate(list, *kernel, wholeBuffer, targetBuffer, kCount, 3, frame);
    addAccumulate(list, *kernel, partBuffer, targetBuffer, kCount, 11, frame);
    // The uploaded buffer is written by a kernel too, and uploaded again in the next frame.
    addAccumulate(list, *kernel, targetBuffer, partBuffer, kCount, 1, 0);
    execute(list);
    accumulateOnHost(whole, target, 3, frame);
    accumulateOnHost(part, target, 11, frame);
    accumulateOnHost(target, part, 1, 0);
  }
  EXPECT_EQ(read(targetBuffer), target);
  EXPECT_EQ(read(partBuffer), part);
}

TEST_P(GlTest, DispatchesIndirectlyWithArgumentsThatAKernelWrote) {
  TestKernel arguments("write_arguments", Stage::kCompute, R"(
layout(local_size_x = 1) in;
layout(std430, binding = 0) writeonly buffer Arguments { uint g_arguments[]; };
void main() { g_arguments[1] = 3u; g_arguments[2] = 1u; g_arguments[3] = 1u; }
)",
                       {storage("g_arguments", Access::kWrite, 0)}, {}, 1);
  arguments.addTo(*device_);
  const auto kernel = accumulateKernel();
  kernel->addTo(*device_);
  const BufferId argumentBuffer =
      addZeros(table_, "arguments", 4, BufferUsage::kStorage | BufferUsage::kIndirect);
  const BufferId ones = addBuffer(table_, "ones", std::vector<uint32_t>(256, 1));
  const BufferId target = addZeros(table_, "target", 256);
  update();
  PassList list;
  PassBuilder builder(list);
  ASSERT_TRUE(
      builder.dispatch(arguments.variant, 1).bind("g_arguments", argumentBuffer, 16).finish());
  addAccumulate(list, *kernel, ones, target, 256, 1, 0);
  Pass& pass = list.passes.back();
  pass.kind = PassKind::kDispatchIndirect;
  pass.indirect = argumentBuffer;
  pass.indirectOffset = 4;
  execute(list);
  std::vector<uint32_t> expected(256, 0);
  std::fill_n(expected.begin(), 3 * 64, 1u);
  EXPECT_EQ(read(target), expected);
}

constexpr char kSpecialised[] = R"(
#ifndef SPIRV_CROSS_CONSTANT_ID_0
#define SPIRV_CROSS_CONSTANT_ID_0 2u
#endif
const uint kUint = SPIRV_CROSS_CONSTANT_ID_0;
#ifndef SPIRV_CROSS_CONSTANT_ID_1
#define SPIRV_CROSS_CONSTANT_ID_1 -3
#endif
const int kInt = SPIRV_CROSS_CONSTANT_ID_1;
#ifndef SPIRV_CROSS_CONSTANT_ID_10
#define SPIRV_CROSS_CONSTANT_ID_10 false
#endif
const bool kBool = SPIRV_CROSS_CONSTANT_ID_10;
#ifndef SPIRV_CROSS_CONSTANT_ID_3
#define SPIRV_CROSS_CONSTANT_ID_3 0.5
#endif
const float kFloat = SPIRV_CROSS_CONSTANT_ID_3;
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Target { uint g_target[]; };
shared uint table[kUint];
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < kUint) table[i] = i;
  barrier();
  if (i != 0u) return;
  g_target[0] = table[kUint - 1u] + 1u;
  g_target[1] = uint(kInt);
  g_target[2] = kBool ? 1u : 0u;
  g_target[3] = floatBitsToUint(kFloat);
}
)";

TEST_P(GlTest, SetsSpecConstantsOfEveryTypeToTheBit) {
  TestKernel kernel("specialised", Stage::kCompute, kSpecialised,
                    {storage("g_target", Access::kWrite, 0)},
                    {{"kUint", 0, 2},
                     {"kInt", 1, static_cast<uint32_t>(-3)},
                     {"kBool", 10, 0},
                     {"kFloat", 3, 0x3f000000u}});
  kernel.addTo(*device_);
  const BufferId target = addZeros(table_, "target", 4);
  update();
  const auto run = [&](std::vector<SpecValue> values) {
    PassList list;
    PassBuilder builder(list);
    EXPECT_TRUE(
        builder.dispatch(kernel.variant, 64).bind("g_target", target, 16).spec(values).finish());
    execute(list);
    return read(target);
  };
  const auto minusThree = static_cast<uint32_t>(-3);
  EXPECT_EQ(run({}), (std::vector<uint32_t>{2, minusThree, 0, 0x3f000000u}));
  const uint32_t pi = std::bit_cast<uint32_t>(3.14159274f);
  EXPECT_EQ(run({{0, 31}, {1, 0x80000000u}, {10, 1}, {3, pi}}),
            (std::vector<uint32_t>{31, 0x80000000u, 1, pi}));
  const uint32_t infinity = std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity());
  // A value of a constant that the kernel does not have is somebody else's.
  EXPECT_EQ(run({{3, infinity}, {99, 5}}), (std::vector<uint32_t>{2, minusThree, 0, infinity}));
  EXPECT_EQ(run({}), (std::vector<uint32_t>{2, minusThree, 0, 0x3f000000u}));
}

TEST_P(GlTest, PutsTheTopRowFirst) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  const BufferId corners = addCorners(table_, kUpperHalf);
  update();
  PassList list;
  addDraw(list, kernels, {}, corners, 6, {{1, 0.25f, 8, 1}, {0, 0, 0.5f, 0}, {}}, 6);
  const RenderedImage image = render(list, {.width = 5, .height = 6, .clearColor = {0, 0, 2, 0}});
  ASSERT_EQ(image.pixels.size(), 30u);
  for (size_t i = 0; i < 30; ++i) {
    const Float4 expected = i < 15 ? Float4{1, 0.25f, 8, 1} : Float4{0, 0, 2, 0};
    EXPECT_EQ(image.pixels[i], expected) << "pixel " << i;
  }
}

TEST_P(GlTest, KeepsTheNearestOfSeveralDrawsInStandardAndReversedDepth) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  const BufferId corners = addCorners(table_, kEverything);
  const BufferId upper = addCorners(table_, kUpperHalf);
  update();
  for (const bool reversed : {false, true}) {
    PassList list;
    const DrawState state{.depthCompare = reversed ? DepthCompare::kGreater : DepthCompare::kLess};
    addDraw(list, kernels, state, corners, 3, {{1, 0, 0, 1}, {0, 0, 0.5f, 0}, {}}, 3);
    addDraw(list, kernels, state, upper, 6, {{0, 1, 0, 1}, {0, 0, 0.25f, 0}, {}}, 6);
    addDraw(list, kernels, state, upper, 6, {{0, 0, 1, 1}, {0, 0, 0.75f, 0}, {}}, 6);
    const RenderedImage image =
        render(list, {.width = 4, .height = 4, .clearDepth = reversed ? 0.0f : 1.0f});
    ASSERT_EQ(image.pixels.size(), 16u);
    EXPECT_EQ(image.pixels[0], reversed ? (Float4{0, 0, 1, 1}) : (Float4{0, 1, 0, 1}));
    EXPECT_EQ(image.pixels[15], (Float4{1, 0, 0, 1}));
  }
}

TEST_P(GlTest, WritesDepthWithoutTestingItAndTestsItWithoutWriting) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  const BufferId corners = addCorners(table_, kEverything);
  update();
  PassList list;
  // Far, but it always passes and writes; so the one in between fails against the near one before.
  const auto draw = [&](DepthCompare compare, bool write, float depth, Float4 color) {
    addDraw(list, kernels, {.depthCompare = compare, .depthWrite = write}, corners, 3,
            {color, {0, 0, depth, 0}, {}}, 3);
  };
  draw(DepthCompare::kLess, true, 0.2f, {1, 0, 0, 1});
  draw(DepthCompare::kAlways, true, 0.8f, {0, 1, 0, 1});
  draw(DepthCompare::kLess, false, 0.5f, {0, 0, 1, 1});      // passes: 0.8 is there now
  draw(DepthCompare::kLess, true, 0.6f, {1, 1, 1, 1});       // passes: 0.5 was not written
  draw(DepthCompare::kLessEqual, true, 0.7f, {9, 9, 9, 9});  // fails
  const RenderedImage image = render(list, {.width = 1, .height = 1});
  ASSERT_EQ(image.pixels.size(), 1u);
  EXPECT_EQ(image.pixels[0], (Float4{1, 1, 1, 1}));
}

TEST_P(GlTest, BlendsPremultipliedAlphaInTheOrderOfTheDraws) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  const BufferId corners = addCorners(table_, kEverything);
  update();
  PassList list;
  const DrawState state{.depthCompare = DepthCompare::kAlways,
                        .depthWrite = false,
                        .blend = BlendMode::kPremultipliedAlpha};
  addDraw(list, kernels, state, corners, 3, {{0.5f, 0, 0, 0.5f}, {}, {}}, 3);
  addDraw(list, kernels, state, corners, 3, {{0, 0.25f, 0, 0.75f}, {}, {}}, 3);
  const RenderedImage image = render(list, {.width = 2, .height = 2, .clearColor = {0, 0, 4, 1}});
  ASSERT_EQ(image.pixels.size(), 4u);
  EXPECT_EQ(image.pixels[3], (Float4{0.125f, 0.25f, 0.5f, 1}));
}

TEST_P(GlTest, DrawsIndexedInstances) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  // A quad of one pixel in the top left corner of 4 x 4; each instance one pixel further right.
  const std::vector<Float4> quad = {
      {-1, 0.5f, 0, 1}, {-0.5f, 0.5f, 0, 1}, {-1, 1, 0, 1}, {-0.5f, 1, 0, 1}};
  const std::vector<uint32_t> indices = {0, 1, 2, 2, 1, 3};
  const BufferId corners = addCorners(table_, quad);
  const BufferId indexBuffer = addBuffer(table_, "indices", indices, BufferUsage::kIndex);
  update();
  PassList list;
  addDraw(list, kernels, {}, corners, 4, {{1, 1, 1, 1}, {0, -0.5f, 0, 0}, {0.5f, 0, 0, 0}}, 6, 3,
          indexBuffer);
  const RenderedImage image = render(list, {.width = 4, .height = 4});
  ASSERT_EQ(image.pixels.size(), 16u);
  for (size_t i = 0; i < 16; ++i)
    EXPECT_EQ(image.pixels[i].x, i >= 4 && i < 7 ? 1.0f : 0.0f) << "pixel " << i;
}

TEST_P(GlTest, AveragesTheLinearValuesOfFourSamples) {
  const DrawKernels kernels;
  kernels.addTo(*device_);
  // A slanted edge: pixels on it have one to three covered samples of four.
  const std::vector<Float4> corners = {{-1, -1, 0, 1}, {1, -1, 0, 1}, {-1, 1, 0, 1}};
  const BufferId buffer = addCorners(table_, corners);
  update();
  PassList list;
  addDraw(list, kernels, {}, buffer, 3, {{8, 1, 0, 1}, {0.01f, 0.02f, 0, 0}, {}}, 3);
  const RenderedImage image =
      render(list, {.width = 16, .height = 16, .samples = 4, .clearColor = {0, 1, 0, 0}});
  ASSERT_EQ(image.pixels.size(), 256u);
  std::map<float, int> levels;
  for (const Float4& pixel : image.pixels) {
    EXPECT_EQ(pixel.y, 1.0f);
    EXPECT_EQ(pixel.x, 8 * pixel.w);
    ++levels[pixel.w];
  }
  EXPECT_GT(levels[0.0f], 50);
  EXPECT_GT(levels[1.0f], 50);
  EXPECT_GT(levels[0.25f] + levels[0.5f] + levels[0.75f], 8);
  EXPECT_EQ(levels.size(), 5u) << "other values than quarters";
}

TEST_P(GlTest, DrawsWhatADispatchOfTheSameListWrote) {
  TestKernel compute("make_corners", Stage::kCompute, R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Corners { vec4 corners[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < 3u) corners[i] = vec4(i == 1u ? 3.0 : -1.0, i == 2u ? 3.0 : -1.0, 0.5, 1.0);
}
)",
                     {storage("g_corners", Access::kWrite, 0)});
  compute.addTo(*device_);
  const DrawKernels kernels;
  kernels.addTo(*device_);
  const BufferId corners = addZeros(table_, "corners", 12);
  update();
  PassList list;
  addDraw(list, kernels, {}, corners, 3, {{0.5f, 0, 0, 1}, {}, {}}, 3);
  PassBuilder builder(list);
  ASSERT_TRUE(builder.dispatch(compute.variant, 3).bind("g_corners", corners, 48).finish());
  std::vector<PassTiming> timings;
  const RenderedImage image = render(list, {.width = 3, .height = 3}, &timings);
  ASSERT_EQ(image.pixels.size(), 9u);
  for (const Float4& pixel : image.pixels) EXPECT_EQ(pixel, (Float4{0.5f, 0, 0, 1}));
  ASSERT_EQ(timings.size(), 2u);
  EXPECT_STREQ(timings[0].name, "make_corners");
  EXPECT_STREQ(timings[1].name, "fill_pixel");
}

TEST_P(GlTest, TimesEachPass) {
  TestKernel slow("slow", Stage::kCompute, R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Target { uint g_target[]; };
void main() {
  uint x = g_target[gl_GlobalInvocationID.x];
  for (uint i = 0u; i < 20000u; ++i) x = x * 1664525u + 1013904223u;
  g_target[gl_GlobalInvocationID.x] = x;
}
)",
                  {storage("g_target", Access::kReadWrite, 0)});
  slow.addTo(*device_);
  const auto fast = accumulateKernel();
  fast->addTo(*device_);
  const BufferId target = addZeros(table_, "target", 6400);
  const BufferId source = addZeros(table_, "source", 64);
  update();
  PassList list;
  PassBuilder builder(list);
  addAccumulate(list, *fast, source, target, 64, 1, 1);
  ASSERT_TRUE(builder.dispatch(slow.variant, 6400).bind("g_target", target, 25600).finish());
  addAccumulate(list, *fast, source, target, 64, 1, 1);
  std::vector<PassTiming> timings;
  execute(list, nullptr);  // compiles
  execute(list, &timings);
  ASSERT_EQ(timings.size(), 3u);
  EXPECT_STREQ(timings[0].name, "accumulate");
  EXPECT_STREQ(timings[1].name, "slow");
  for (const PassTiming& timing : timings) {
    EXPECT_TRUE(std::isfinite(timing.milliseconds));
    EXPECT_TRUE(timing.milliseconds >= 0 || timing.milliseconds == -1) << timing.milliseconds;
  }
  if (timings[1].milliseconds >= 0) {
    EXPECT_GT(timings[1].milliseconds, timings[0].milliseconds);
    EXPECT_GT(timings[1].milliseconds, timings[2].milliseconds);
    EXPECT_GT(timings[1].milliseconds, 0);
  }
}

// One list each that is wrong in one way; the message has to name what it is about.
TEST_P(GlTest, RefusesWrongListsAndNamesPassAndResource) {
  const auto kernel = accumulateKernel();
  kernel->addTo(*device_);
  const BufferId source = addBuffer(table_, "groom/source", ramp(256, 1));
  const BufferId target = addBuffer(table_, "groom/target", ramp(256, 2));
  const BufferId removed = addZeros(table_, "removed", 256);
  update();
  table_.remove(removed);
  update();
  const std::vector<uint32_t> before = read(target);

  const std::array<uint32_t, 2> twoWords{};
  struct Case {
    const char* what;
    std::function<void(PassList&)> spoil;
    std::vector<const char*> words;
  };
  const std::vector<Case> cases = {
      {"unknown buffer",
       [](PassList& list) { list.bindings[1].buffer = static_cast<BufferId>(77); },
       {"accumulate", "g_source", "77"}},
      {"removed buffer",
       [&](PassList& list) { list.bindings[2].buffer = removed; },
       {"accumulate", "g_target"}},
      {"range behind the end",
       [](PassList& list) { list.bindings[1].size += 4; },
       {"accumulate", "g_source", "groom/source", "1024"}},
      {"range that overflows",
       [](PassList& list) { list.bindings[1].offset = ~uint64_t{255}; },
       {"accumulate", "g_source", "groom/source"}},
      {"empty range", [](PassList& list) { list.bindings[1].size = 0; }, {"g_source"}},
      {"short constants",
       [](PassList& list) { list.bindings[0].size = 12; },
       {"accumulate", "AccumulateConstants", "16"}},
      {"misplaced constants",
       [](PassList& list) { list.bindings[0].offset = 16; },
       {"AccumulateConstants"}},
      {"no groups", [](PassList& list) { list.passes[0].groups[1] = 0; }, {"accumulate", "axis y"}},
      {"too many groups",
       [](PassList& list) { list.passes[0].groups[2] = 0x80000000u; },
       {"accumulate", "axis z", "2147483648"}},
      {"binding left out",
       [](PassList& list) { list.passes[0].bindingCount = 2; },
       {"accumulate", "g_target"}},
      {"binding of no layout",
       [](PassList& list) { list.bindings[1].set = 3; },
       {"accumulate", "set 3"}},
      {"bindings outside of the list",
       [](PassList& list) { list.passes[0].bindingCount = 9; },
       {"accumulate"}},
      {"upload behind the end",
       [&](PassList& list) { addUpload(list, source, std::as_bytes(std::span(twoWords)), 1020); },
       {"upload", "groom/source", "1020"}},
      {"upload without data",
       [&](PassList& list) {
         list.uploads.push_back({source, 0, 0, 4});
       },
       {"upload", "groom/source"}},
      {"upload into nothing",
       [&](PassList& list) {
         list.uploads.push_back({removed, 0, 0, 0});
       },
       {"upload", "update()"}},
      {"indirect arguments behind the end",
       [&](PassList& list) {
         list.passes[0].kind = PassKind::kDispatchIndirect;
         list.passes[0].indirect = source;
         list.passes[0].indirectOffset = 1016;
       },
       {"accumulate", "indirect", "groom/source"}},
      {"a draw of a compute kernel",
       [](PassList& list) {
         list.passes[0].pixel = list.passes[0].kernel;
         list.passes[0].kind = PassKind::kDraw;
       },
       {"accumulate", "stage"}},
  };
  for (const Case& wrong : cases) {
    PassList list;
    addAccumulate(list, *kernel, source, target, 256, 1, 1);
    wrong.spoil(list);
    Result<void> result;
    if (list.passes[0].kind == PassKind::kDraw) {
      const auto image = device_->render(list, {.width = 1, .height = 1});
      if (!image) result = image.error();
    } else {
      result = device_->execute(list);
    }
    ASSERT_FALSE(result) << wrong.what;
    for (const char* word : wrong.words)
      EXPECT_NE(result.error().message.find(word), std::string::npos)
          << wrong.what << ": '" << word << "' is not in: " << result.error().message;
  }
  // Nothing of a refused list has run.
  EXPECT_EQ(read(target), before);
}

TEST_P(GlTest, RefusesTargetsThatItCannotDrawTo) {
  PassList list;
  EXPECT_FALSE(device_->render(list, {.width = 0, .height = 4}));
  EXPECT_FALSE(device_->render(list, {.width = 4, .height = 16385}));
  EXPECT_FALSE(device_->render(list, {.width = 4, .height = 4, .samples = 3}));
  EXPECT_FALSE(device_->render(list, {.width = 4, .height = 4, .samples = 16}));
}

TEST_P(GlTest, DrawsWithTheSampleCountsThatItNamesAndNoOthers) {
  const PassList list;
  for (const uint32_t samples : {1u, 2u, 4u, 8u}) {
    const auto image = device_->render(list, {.width = 4, .height = 4, .samples = samples});
    ASSERT_EQ(image.ok(), (device_->info().sampleCounts & samples) != 0) << samples;
    if (image) continue;
    EXPECT_EQ(image.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(image.error().message.find(device_->info().name), std::string::npos);
  }
}

TEST_P(GlTest, RefusesKernelsThatAreOverTheLimits) {
  const BufferId target = addZeros(table_, "target", 64);
  update();
  TestKernel wide("wide", Stage::kCompute, kAccumulate, {storage("g_target", Access::kWrite, 0)},
                  {}, 1u << 20);
  wide.addTo(*device_);
  TestKernel far("far", Stage::kCompute, kAccumulate, {storage("g_target", Access::kWrite, 200)});
  far.addTo(*device_);
  for (const auto& [kernel, word] :
       {std::pair{&wide, "GL_MAX_COMPUTE_WORK_GROUP_SIZE"}, std::pair{&far, "GL binding 200"}}) {
    PassList list;
    PassBuilder builder(list);
    ASSERT_TRUE(builder.dispatch(kernel->variant, 64).bind("g_target", target, 256).finish());
    const Result<void> result = device_->execute(list);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
    EXPECT_NE(result.error().message.find(device_->info().name), std::string::npos);
  }
}

TEST_P(GlTest, GivesBackTheDriversLogOfABrokenKernel) {
  TestKernel broken("broken", Stage::kCompute, R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Target { uint g_target[]; };
void main() { g_target[0] = not_a_variable; }
)",
                    {storage("g_target", Access::kWrite, 0)});
  broken.addTo(*device_);
  broken.variant.key = "wind=1";
  const BufferId target = addZeros(table_, "target", 64);
  update();
  PassList list;
  PassBuilder builder(list);
  ASSERT_TRUE(builder.dispatch(broken.variant, 64).bind("g_target", target, 256).finish());
  const Result<void> result = device_->execute(list);
  ASSERT_FALSE(result);
  for (const char* word : {"broken [wind=1]", "not_a_variable", device_->info().name.c_str()})
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
  expectedMessages_ = device_->messageCount();  // some drivers count it, some do not
}

TEST_P(GlTest, NamesTheBufferThatDoesNotFitAndCountsTheDriversError) {
  const BufferId good = addBuffer(table_, "good", ramp(10, 1));
  table_.add({"groom/huge", uint64_t{1} << 50, 4, BufferUsage::kStorage, {}});
  const Result<void> updated = device_->update(table_);
  ASSERT_FALSE(updated);
  EXPECT_EQ(updated.error().code, ErrorCode::kOutOfMemory);
  for (const char* word : {"groom/huge", "1125899906842624", "GL_OUT_OF_MEMORY"})
    EXPECT_NE(updated.error().message.find(word), std::string::npos) << updated.error().message;
  EXPECT_EQ(read(good), ramp(10, 1));  // what fitted is there
  // It is an error in the driver's debug output too, so the counter is not deaf.
  EXPECT_GE(device_->messageCount(), 1u);
  expectedMessages_ = device_->messageCount();
}

TEST_P(GlTest, SaysThatAKernelHasNoSourceForTheApi) {
  const auto kernel = accumulateKernel();
  const KernelCode* const otherApi[] = {test::makeCode(
      kernel->kernel, GetParam() == Api::kGles ? CodeFormat::kGlsl : CodeFormat::kEssl,
      kernel->variant.hash, kernel->glsl)};
  device_->addCode(otherApi);
  const BufferId buffer = addZeros(table_, "buffer", 64);
  const BufferId other = addZeros(table_, "other", 64);
  update();
  PassList list;
  addAccumulate(list, *kernel, buffer, other, 64, 1, 1);
  const Result<void> result = device_->execute(list);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find(GetParam() == Api::kGles ? "ESSL" : "GLSL"),
            std::string::npos);
}

TEST(GlDevices, WorkAlternatelyInOneProcess) {
  std::vector<std::unique_ptr<HeadlessDevice>> devices;
  for (const Api api : {Api::kGl, Api::kGles, Api::kGl}) {
    auto device = createHeadlessGl({api, true, -1});
    if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
    devices.push_back(std::move(*device));
  }
  const auto kernel = accumulateKernel();
  for (const auto& device : devices) kernel->addTo(*device);
  ResourceTable table;
  std::vector<uint32_t> source = ramp(100, 1), target = ramp(100, 2);
  const BufferId sourceBuffer = addBuffer(table, "source", source);
  const BufferId targetBuffer = addBuffer(table, "target", target);
  for (const auto& device : devices) ASSERT_TRUE(device->update(table));
  HazardTracker tracker;
  for (uint32_t frame = 0; frame < 4; ++frame) {
    PassList list;
    addAccumulate(list, *kernel, sourceBuffer, targetBuffer, 100, 2, frame);
    for (const auto& device : devices) {
      // A list runs once.
      PassList copy = list;
      tracker.resolve(copy);
      ASSERT_TRUE(device->execute(copy));
    }
    accumulateOnHost(source, target, 2, frame);
  }
  devices.erase(devices.begin() + 1);  // the others outlive it
  for (const auto& device : devices) {
    const auto bytes = device->read(targetBuffer);
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(valuesOf<uint32_t>(*bytes), target);
    EXPECT_EQ(device->messageCount(), 0u);
  }
}

// ---------------------------------------------------------------------------------------------
// The runtime on a context of an "engine", which is this test.

class GlRuntimeTest : public TestWithParam<Api> {
 protected:
  void SetUp() override {
    context_ = std::make_unique<EngineContext>(GetParam());
    if (!context_->current()) PELAGE_SKIP_WITHOUT_DEVICE() << "no OpenGL context through EGL";
  }
  void TearDown() override {
    if (!context_->current()) return;
    EXPECT_EQ(glGetError_(), GLenum{GL_NO_ERROR});
  }

  gl::Runtime makeRuntime(gl::ProgramCache cache = {}, bool debug = true) {
    gl::RuntimeDef def;
    def.getProcAddress = eglAddress;
    def.programCache = std::move(cache);
    def.debug = debug;
    Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
    EXPECT_TRUE(runtime) << runtime.error().message;
    return std::move(*runtime);
  }

  std::unique_ptr<EngineContext> context_;
  PFNGLGETERRORPROC glGetError_ = glFunction<PFNGLGETERRORPROC>("glGetError");
};
INSTANTIATE_TEST_SUITE_P(, GlRuntimeTest, Values(Api::kGl, Api::kGles), apiSuffix);

// What a driver would say that has less; getProcAddress below hands these out.
std::string g_fakeVersion;
std::map<GLenum, GLint> g_fakeIntegers;
std::string g_missingFunction;

const GLubyte* APIENTRY fakeGetString(GLenum name) {
  if (name == GL_VERSION && !g_fakeVersion.empty())
    return reinterpret_cast<const GLubyte*>(g_fakeVersion.c_str());
  return glFunction<PFNGLGETSTRINGPROC>("glGetString")(name);
}
void APIENTRY fakeGetIntegerv(GLenum name, GLint* value) {
  const auto fake = g_fakeIntegers.find(name);
  if (fake != g_fakeIntegers.end()) {
    *value = fake->second;
  } else {
    glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv")(name, value);
  }
}
// What the runtime did in this order: 'l' links a program, 'q' asks for the outcome.
std::string g_programCalls;
void APIENTRY notedLink(GLuint program) {
  g_programCalls += 'l';
  glFunction<PFNGLLINKPROGRAMPROC>("glLinkProgram")(program);
}
void APIENTRY notedQuery(GLuint program, GLenum name, GLint* value) {
  if (name == GL_LINK_STATUS) g_programCalls += 'q';
  glFunction<PFNGLGETPROGRAMIVPROC>("glGetProgramiv")(program, name, value);
}
// As GL says it: once.
GLenum g_resetStatus = GL_NO_ERROR;
GLenum APIENTRY fakeResetStatus() { return std::exchange(g_resetStatus, GLenum{GL_NO_ERROR}); }
void* fakeAddress(const char* name) {
  if (std::strcmp(name, "glGetGraphicsResetStatus") == 0)
    return reinterpret_cast<void*>(&fakeResetStatus);
  if (g_missingFunction == name) return nullptr;
  if (std::strcmp(name, "glLinkProgram") == 0) return reinterpret_cast<void*>(&notedLink);
  if (std::strcmp(name, "glGetProgramiv") == 0) return reinterpret_cast<void*>(&notedQuery);
  if (std::strcmp(name, "glGetString") == 0) return reinterpret_cast<void*>(&fakeGetString);
  if (std::strcmp(name, "glGetIntegerv") == 0) return reinterpret_cast<void*>(&fakeGetIntegerv);
  return eglAddress(name);
}

class GlLackingTest : public GlRuntimeTest {
 protected:
  void SetUp() override {
    g_fakeVersion.clear();
    g_fakeIntegers.clear();
    g_missingFunction.clear();
    g_resetStatus = GL_NO_ERROR;
    GlRuntimeTest::SetUp();
  }
  static void expectRefusal(const std::vector<std::string>& words) {
    gl::RuntimeDef def;
    def.getProcAddress = fakeAddress;
    const Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
    ASSERT_FALSE(runtime);
    EXPECT_EQ(runtime.error().code, ErrorCode::kUnsupported);
    for (const std::string& word : words)
      EXPECT_NE(runtime.error().message.find(word), std::string::npos) << runtime.error().message;
  }
};
INSTANTIATE_TEST_SUITE_P(, GlLackingTest, Values(Api::kGl, Api::kGles), apiSuffix);

TEST_P(GlLackingTest, BeginsAllProgramsOfAListBeforeItWaitsForOne) {
  g_programCalls.clear();
  gl::RuntimeDef def;
  def.getProcAddress = fakeAddress;
  Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
  ASSERT_TRUE(runtime) << runtime.error().message;
  const auto first = accumulateKernel();
  const auto second = accumulateKernel();
  const DrawKernels draws;
  first->addTo(*runtime);
  second->addTo(*runtime);
  draws.addTo(*runtime);
  ResourceTable table;
  const BufferId buffer = addZeros(table, "buffer", 64);
  const BufferId other = addZeros(table, "other", 64);
  const BufferId corners = addCorners(table, kEverything);
  ASSERT_TRUE(runtime->update(table));
  PassList list;
  addAccumulate(list, *first, buffer, other, 64, 1, 1);
  addAccumulate(list, *second, buffer, other, 64, 1, 1);
  addAccumulate(list, *first, buffer, other, 64, 1, 1);
  addDraw(list, draws, {}, corners, 3, {}, 3);
  ASSERT_TRUE(runtime->prepare(list));
  EXPECT_EQ(g_programCalls, "lllqqq");
  EXPECT_EQ(runtime->statistics().programsCompiled, 3u);
  const std::vector<PipelineTime> times = runtime->pipelineTimes();
  ASSERT_EQ(times.size(), 3u);
  EXPECT_EQ(times[2].name, "fill_vertex + fill_pixel");
  for (const PipelineTime& time : times) EXPECT_GT(time.milliseconds, 0);
  ASSERT_TRUE(runtime->prepare(list));
  EXPECT_EQ(g_programCalls, "lllqqq");
}

TEST_P(GlLackingTest, KeepsTheOtherProgramsOfAListWithABrokenKernel) {
  g_programCalls.clear();
  gl::RuntimeDef def;
  def.getProcAddress = fakeAddress;
  Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
  ASSERT_TRUE(runtime) << runtime.error().message;
  TestKernel broken("broken", Stage::kCompute,
                    "layout(local_size_x = 64) in;\nvoid main() { x; }\n",
                    {storage("g_target", Access::kWrite, 0)});
  broken.addTo(*runtime);
  const auto kernel = accumulateKernel();
  kernel->addTo(*runtime);
  ResourceTable table;
  const BufferId buffer = addZeros(table, "buffer", 64);
  const BufferId other = addZeros(table, "other", 64);
  ASSERT_TRUE(runtime->update(table));
  PassList list;
  PassBuilder builder(list);
  ASSERT_TRUE(builder.dispatch(broken.variant, 64).bind("g_target", buffer, 256).finish());
  addAccumulate(list, *kernel, buffer, other, 64, 1, 1);
  for (int round = 0; round < 2; ++round) {
    const Result<void> failed = runtime->prepare(list);
    ASSERT_FALSE(failed);
    EXPECT_NE(failed.error().message.find("broken"), std::string::npos) << failed.error().message;
  }
  PassList good;
  addAccumulate(good, *kernel, buffer, other, 64, 1, 1);
  const size_t links =
      static_cast<size_t>(std::count(g_programCalls.begin(), g_programCalls.end(), 'l'));
  ASSERT_TRUE(runtime->prepare(good));
  EXPECT_EQ(std::count(g_programCalls.begin(), g_programCalls.end(), 'l'),
            static_cast<std::ptrdiff_t>(links));
  EXPECT_EQ(runtime->statistics().programsCompiled, 1u);
}

TEST_P(GlLackingTest, SaysThatTheContextIsLostAndKeepsSayingSo) {
  for (const auto& [status, name] :
       {std::pair(GLenum{GL_GUILTY_CONTEXT_RESET}, "GL_GUILTY_CONTEXT_RESET"),
        std::pair(GLenum{GL_INNOCENT_CONTEXT_RESET}, "GL_INNOCENT_CONTEXT_RESET"),
        std::pair(GLenum{GL_UNKNOWN_CONTEXT_RESET}, "GL_UNKNOWN_CONTEXT_RESET")}) {
    gl::RuntimeDef def;
    def.getProcAddress = fakeAddress;
    Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
    ASSERT_TRUE(runtime) << runtime.error().message;
    const auto kernel = accumulateKernel();
    kernel->addTo(*runtime);
    ResourceTable table;
    const BufferId buffer = addZeros(table, "buffer", 64);
    const BufferId other = addZeros(table, "other", 64);
    ASSERT_TRUE(runtime->update(table));
    PassList list;
    addAccumulate(list, *kernel, buffer, other, 64, 1, 1);
    const auto expectLost = [&](const auto& result, const char* call) {
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, ErrorCode::kDeviceLost);
      for (const char* word : {call, name, "Scene::recover()"})
        EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
    };
    g_resetStatus = status;
    expectLost(runtime->record(list), "record()");
    expectLost(runtime->recordDraws(list, {0, 0, 8, 8}), "recordDraws()");
    expectLost(runtime->update(table), "update()");
    expectLost(runtime->read(buffer), "read()");
  }
}

TEST_P(GlLackingTest, NamesTheVersionThatIsTooOld) {
  const bool es = GetParam() == Api::kGles;
  g_fakeVersion = es ? "OpenGL ES 3.1 Toaster 1.0" : "4.4 (Core Profile) Toaster 1.0";
  expectRefusal({g_fakeVersion, es ? "ES 3.2" : "4.5"});
}

TEST_P(GlLackingTest, NamesTheFunctionThatIsMissing) {
  g_missingFunction = "glDispatchCompute";
  expectRefusal({"glDispatchCompute"});
}

TEST_P(GlLackingTest, NamesTheLimitThatIsTooLow) {
  g_fakeIntegers[GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS] = 0;
  expectRefusal({"GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS = 0"});
  g_fakeIntegers = {{GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, 512}};
  expectRefusal({"GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT = 512"});
}

TEST_P(GlLackingTest, RefusesADrawWhoseVertexStageHasNoStorageBuffers) {
  g_fakeIntegers[GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS] = 0;
  gl::RuntimeDef def;
  def.getProcAddress = fakeAddress;
  Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
  ASSERT_TRUE(runtime) << runtime.error().message;  // compute alone still works
  const DrawKernels kernels;
  kernels.addTo(*runtime);
  ResourceTable table;
  const BufferId corners = addCorners(table, kEverything);
  ASSERT_TRUE(runtime->update(table));
  PassList list;
  addDraw(list, kernels, {}, corners, 3, {}, 3);
  const Result<void> result = runtime->prepare(list);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
  for (const char* word : {"fill_vertex", "g_corners", "GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS"})
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
}

TEST(GlRuntime, SaysThatNoContextIsCurrent) {
  gl::RuntimeDef def;
  EXPECT_FALSE(gl::Runtime::create(def));
  def.getProcAddress = [](const char*) -> void* { return nullptr; };
  const Result<gl::Runtime> runtime = gl::Runtime::create(def);
  ASSERT_FALSE(runtime);
  EXPECT_NE(runtime.error().message.find("glGetString"), std::string::npos);
}

TEST_P(GlRuntimeTest, UsesABufferOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const auto kernel = accumulateKernel();
  kernel->addTo(runtime);
  ResourceTable table;
  const std::vector<uint32_t> source = ramp(64, 5);
  const BufferId sourceBuffer = addBuffer(table, "source", source);
  const BufferId shared = addZeros(table, "shared", 64);

  const auto bindBuffer = glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer");
  GLuint own = 0;
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(1, &own);
  EXPECT_FALSE(runtime.registerBuffer(shared, own + 1000));
  bindBuffer(GL_COPY_WRITE_BUFFER, own);
  const auto bufferData = glFunction<PFNGLBUFFERDATAPROC>("glBufferData");
  bufferData(GL_COPY_WRITE_BUFFER, 128, nullptr, GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  const Result<void> small = runtime.update(table);
  ASSERT_FALSE(small);
  EXPECT_NE(small.error().message.find("shared"), std::string::npos) << small.error().message;

  const std::vector<uint32_t> start = ramp(64, 6);
  bindBuffer(GL_COPY_WRITE_BUFFER, own);
  bufferData(GL_COPY_WRITE_BUFFER, 256, start.data(), GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  const Result<void> updated = runtime.update(table);
  ASSERT_TRUE(updated) << updated.error().message;
  EXPECT_EQ(runtime.bufferName(shared), own);
  EXPECT_EQ(runtime.statistics().bufferBytes, 256u);  // only the source is the runtime's

  PassList list;
  addAccumulate(list, *kernel, sourceBuffer, shared, 64, 2, 1);
  HazardTracker().resolve(list);
  const Result<void> recorded = runtime.record(list);
  ASSERT_TRUE(recorded) << recorded.error().message;
  std::vector<uint32_t> expected = start;
  accumulateOnHost(source, expected, 2, 1);
  const auto bytes = runtime.read(shared);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(valuesOf<uint32_t>(*bytes), expected);

  table.remove(shared);
  ASSERT_TRUE(runtime.update(table));
  EXPECT_EQ(runtime.bufferName(shared), 0u);
  EXPECT_TRUE(glFunction<PFNGLISBUFFERPROC>("glIsBuffer")(own));  // still the engine's
}

TEST_P(GlRuntimeTest, ReportsInDebugModeWhatTheDriverRefused) {
  gl::Runtime runtime = makeRuntime();
  ResourceTable table;
  const BufferId shared = addZeros(table, "shared", 64);
  GLuint own = 0;
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(1, &own);
  glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer")(GL_COPY_READ_BUFFER, own);
  glFunction<PFNGLBUFFERDATAPROC>("glBufferData")(GL_COPY_READ_BUFFER, 256, nullptr,
                                                  GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  ASSERT_TRUE(runtime.update(table));
  // The engine has forgotten that it has the buffer mapped.
  ASSERT_NE(glFunction<PFNGLMAPBUFFERRANGEPROC>("glMapBufferRange")(GL_COPY_READ_BUFFER, 0, 256,
                                                                    GL_MAP_READ_BIT),
            nullptr);
  PassList list;
  const std::vector<uint32_t> data = ramp(64, 1);
  addUpload(list, shared, std::as_bytes(std::span(data)));
  HazardTracker().resolve(list);
  const Result<void> recorded = runtime.record(list);
  ASSERT_FALSE(recorded);
  EXPECT_EQ(recorded.error().code, ErrorCode::kDevice);
  EXPECT_NE(recorded.error().message.find("GL_INVALID_OPERATION"), std::string::npos)
      << recorded.error().message;
}

TEST_P(GlRuntimeTest, MakesAProgramOnceForEachSetOfSpecValues) {
  gl::Runtime runtime = makeRuntime();
  TestKernel kernel("specialised", Stage::kCompute, kSpecialised,
                    {storage("g_target", Access::kWrite, 0)}, {{"kUint", 0, 2}});
  kernel.addTo(runtime);
  ResourceTable table;
  const BufferId target = addZeros(table, "target", 4);
  ASSERT_TRUE(runtime.update(table));
  for (int round = 0; round < 2; ++round) {
    for (const uint32_t value : {4u, 5u}) {
      PassList list;
      PassBuilder builder(list);
      const std::vector<SpecValue> values = {{0, value}, {77, value}};
      ASSERT_TRUE(
          builder.dispatch(kernel.variant, 1).bind("g_target", target, 16).spec(values).finish());
      HazardTracker().resolve(list);
      ASSERT_TRUE(runtime.record(list));
    }
  }
  EXPECT_EQ(runtime.statistics().programsCompiled, 2u);
}

class CacheDirectory {
 public:
  CacheDirectory() {
    path_ = std::filesystem::temp_directory_path() /
            ("pelage-gl-test-" + std::to_string(std::random_device{}()));
  }
  ~CacheDirectory() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  CacheDirectory(const CacheDirectory&) = delete;
  CacheDirectory& operator=(const CacheDirectory&) = delete;
  std::string path() const { return path_.string(); }
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(path_, error))
      files.push_back(entry.path());
    return files;
  }

 private:
  std::filesystem::path path_;
};

TEST_P(GlRuntimeTest, LoadsProgramsFromTheCacheAndCompilesWhatIsCorrupt) {
  if (!makeRuntime().limits().programBinaries) GTEST_SKIP() << "the driver has no program binaries";
  const auto kernel = accumulateKernel();
  const CacheDirectory directory;
  // Runs the kernel with a new runtime, checks the numbers, and says where its program came from.
  const auto run = [&](gl::ProgramCache cache) {
    gl::Runtime runtime = makeRuntime(std::move(cache));
    kernel->addTo(runtime);
    ResourceTable table;
    std::vector<uint32_t> source = ramp(64, 5), target = ramp(64, 6);
    const BufferId sourceBuffer = addBuffer(table, "source", source);
    const BufferId targetBuffer = addBuffer(table, "target", target);
    EXPECT_TRUE(runtime.update(table));
    PassList list;
    addAccumulate(list, *kernel, sourceBuffer, targetBuffer, 64, 2, 1);
    HazardTracker().resolve(list);
    const Result<void> recorded = runtime.record(list);
    EXPECT_TRUE(recorded) << recorded.error().message;
    accumulateOnHost(source, target, 2, 1);
    const auto bytes = runtime.read(targetBuffer);
    EXPECT_TRUE(bytes);
    EXPECT_EQ(valuesOf<uint32_t>(bytes ? *bytes : std::vector<std::byte>{}), target);
    return std::pair{runtime.statistics().programsCompiled, runtime.statistics().programsLoaded};
  };
  const std::pair compiled{1u, 0u}, loaded{0u, 1u};
  const auto fromDirectory = [&] { return run(gl::directoryProgramCache(directory.path())); };

  EXPECT_EQ(fromDirectory(), compiled);
  ASSERT_EQ(directory.files().size(), 1u);
  EXPECT_EQ(fromDirectory(), loaded);

  const std::filesystem::path file = directory.files()[0];
  const auto size = std::filesystem::file_size(file);
  {  // one bit in the middle
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(size / 2));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(size / 2));
    stream.put(static_cast<char>(byte ^ 1));
  }
  EXPECT_EQ(fromDirectory(), compiled);
  EXPECT_EQ(fromDirectory(), loaded);  // and the good one is back
  std::filesystem::resize_file(file, size / 3);
  EXPECT_EQ(fromDirectory(), compiled);
  std::filesystem::resize_file(file, 0);
  EXPECT_EQ(fromDirectory(), compiled);
  EXPECT_EQ(fromDirectory(), loaded);

  // Another kernel, another entry.
  kernel->glsl += "\n";
  kernel->essl += "\n";
  kernel->variant.hash = test::freshHash();
  EXPECT_EQ(fromDirectory(), compiled);
  EXPECT_EQ(directory.files().size(), 2u);
}

TEST_P(GlRuntimeTest, CompilesWhatTheDriverRefusesToLoad) {
  if (!makeRuntime().limits().programBinaries) GTEST_SKIP() << "the driver has no program binaries";
  const auto kernel = accumulateKernel();
  ResourceTable table;
  const BufferId buffer = addZeros(table, "buffer", 64);
  const BufferId other = addZeros(table, "other", 64);
  PassList list;
  addAccumulate(list, *kernel, buffer, other, 64, 1, 1);

  // The runtime's own header, intact, in front of bytes that no driver takes: as after an update
  // of the driver that left its version strings as they were.
  std::map<uint64_t, std::vector<std::byte>> stored;
  gl::ProgramCache cache;
  cache.store = [&stored](uint64_t key, std::span<const std::byte> bytes) {
    stored[key].assign(bytes.begin(), bytes.end());
  };
  cache.load = [&stored](uint64_t key) { return stored[key]; };
  {
    gl::Runtime runtime = makeRuntime(cache);
    kernel->addTo(runtime);
    ASSERT_TRUE(runtime.update(table));
    HazardTracker().resolve(list);
    ASSERT_TRUE(runtime.record(list));
  }
  ASSERT_EQ(stored.size(), 1u);
  std::vector<std::byte>& bytes = stored.begin()->second;
  constexpr size_t kHeader = 32, kPayloadHash = 16;
  ASSERT_GT(bytes.size(), kHeader);
  std::fill(bytes.begin() + kHeader, bytes.end(), std::byte{0x5a});
  uint64_t hash = 0xcbf29ce484222325ull;
  for (size_t i = kHeader; i < bytes.size(); ++i)
    hash = (hash ^ static_cast<uint64_t>(bytes[i])) * 0x100000001b3ull;
  std::memcpy(bytes.data() + kPayloadHash, &hash, sizeof(hash));

  gl::Runtime runtime = makeRuntime(cache);
  kernel->addTo(runtime);
  ASSERT_TRUE(runtime.update(table));
  HazardTracker().resolve(list);
  const Result<void> recorded = runtime.record(list);
  ASSERT_TRUE(recorded) << recorded.error().message;
  EXPECT_EQ(runtime.statistics().programsCompiled, 1u);
  EXPECT_EQ(runtime.statistics().programsLoaded, 0u);
}

TEST_P(GlRuntimeTest, ReportsHowTheDriverLaysBlocksOut) {
  gl::Runtime runtime = makeRuntime();
  TestKernel kernel("blocks", Stage::kCompute, R"(
struct Root { vec4 rotation; vec4 position; uint bone; uint pad0; uint pad1; uint pad2; };
layout(local_size_x = 64) in;
layout(std140, binding = 2) uniform Constants {
  vec4 gravity;
  uint count;
  float step;
  float table[3];
};
layout(std430, binding = 5) buffer Roots { Root roots[]; };
layout(std430, binding = 1) readonly buffer Lengths { float lengths[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  roots[i].position += gravity * step * lengths[i] * table[int(roots[i].bone)];
  roots[i].rotation = vec4(0.0);
}
)",
                    {});
  kernel.addTo(runtime);
  const Result<std::vector<gl::DriverBlock>> reflected = runtime.reflectProgram(kernel.variant);
  ASSERT_TRUE(reflected) << reflected.error().message;
  ASSERT_EQ(reflected->size(), 3u);
  const auto member = [](const gl::DriverBlock& block, const char* name) {
    for (const gl::DriverMember& m : block.members)
      if (m.name.find(name) != std::string::npos) return m;
    ADD_FAILURE() << "no member " << name;
    return gl::DriverMember{};
  };
  const gl::DriverBlock& constants = (*reflected)[0];
  EXPECT_EQ(constants.kind, ResourceKind::kUniformBuffer);
  EXPECT_EQ(constants.binding, 2u);
  EXPECT_EQ(constants.dataSize, 80u);  // 16 + 4 + 4, then 3 elements of 16 at 32
  EXPECT_EQ(member(constants, "gravity").offset, 0u);
  EXPECT_EQ(member(constants, "gravity").type, GLenum{GL_FLOAT_VEC4});
  EXPECT_EQ(member(constants, "count").offset, 16u);
  EXPECT_EQ(member(constants, "step").offset, 20u);
  EXPECT_EQ(member(constants, "table").offset, 32u);
  EXPECT_EQ(member(constants, "table").arraySize, 3u);
  EXPECT_EQ(member(constants, "table").arrayStride, 16u);
  const gl::DriverBlock& lengths = (*reflected)[1];
  EXPECT_EQ(lengths.kind, ResourceKind::kStorageBuffer);
  EXPECT_EQ(lengths.binding, 1u);
  EXPECT_EQ(member(lengths, "lengths").arrayStride, 4u);
  const gl::DriverBlock& roots = (*reflected)[2];
  EXPECT_EQ(roots.binding, 5u);
  EXPECT_EQ(member(roots, "rotation").offset, 0u);
  EXPECT_EQ(member(roots, "position").offset, 16u);
  EXPECT_EQ(member(roots, "bone").offset, 32u);
  EXPECT_EQ(member(roots, "bone").topLevelArrayStride, 48u);
  EXPECT_EQ(member(roots, "bone").topLevelArraySize, 0u);

  const DrawKernels draws;
  draws.addTo(runtime);
  for (const TestKernel* stage : {&draws.vertex, &draws.pixel}) {
    const auto blocks = runtime.reflectProgram(stage->variant);
    ASSERT_TRUE(blocks) << blocks.error().message;
    ASSERT_FALSE(blocks->empty());
    EXPECT_EQ((*blocks)[0].dataSize, 48u);
  }
}

TEST_P(GlRuntimeTest, HandsOutTheSlotsOfALayout) {
  gl::Runtime runtime = makeRuntime();
  const auto kernel = accumulateKernel();
  kernel->addTo(runtime);
  const Result<const gl::Layout*> layout = runtime.createLayout(kernel->layout);
  ASSERT_TRUE(layout);
  ASSERT_EQ((*layout)->slots.size(), 3u);
  EXPECT_EQ((*layout)->slots[0].target, GLenum{GL_UNIFORM_BUFFER});
  EXPECT_EQ((*layout)->slots[2].target, GLenum{GL_SHADER_STORAGE_BUFFER});
  EXPECT_EQ((*layout)->slots[2].binding, 0u) << "each permutation numbers its storage buffers";
  const Result<const gl::Layout*> again = runtime.createLayout(kernel->layout);
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, *layout);
}

TEST_P(GlRuntimeTest, KeepsSeveralTimersInFlight) {
  gl::Runtime runtime = makeRuntime();
  const auto kernel = accumulateKernel();
  kernel->addTo(runtime);
  ResourceTable table;
  const BufferId buffer = addZeros(table, "buffer", 64);
  const BufferId other = addZeros(table, "other", 64);
  ASSERT_TRUE(runtime.update(table));
  PassList list;
  addAccumulate(list, *kernel, buffer, other, 64, 1, 1);
  addAccumulate(list, *kernel, other, buffer, 64, 1, 1);
  std::vector<gl::PassTimer> timers;
  timers.reserve(3);
  for (int i = 0; i < 3; ++i) timers.emplace_back(runtime);
  for (int frame = 0; frame < 9; ++frame) {
    gl::PassTimer& timer = timers[static_cast<size_t>(frame % 3)];
    EXPECT_EQ(timer.read().size(), frame < 3 ? 0u : 2u);
    EXPECT_TRUE(timer.ready());
    HazardTracker().resolve(list);
    ASSERT_TRUE(runtime.record(list, &timer));
  }
}

// Every piece of state that the guard promises, by its query.
std::vector<int64_t> snapshot(Api api) {
  const auto getInteger = glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv");
  const auto getIndexed = glFunction<PFNGLGETINTEGER64I_VPROC>("glGetInteger64i_v");
  const auto getIndexed32 = glFunction<PFNGLGETINTEGERI_VPROC>("glGetIntegeri_v");
  const auto getBooleans = glFunction<PFNGLGETBOOLEANI_VPROC>("glGetBooleani_v");
  const auto isEnabled = glFunction<PFNGLISENABLEDPROC>("glIsEnabled");
  const auto isEnabledIndexed = glFunction<PFNGLISENABLEDIPROC>("glIsEnabledi");
  const auto getFloat = glFunction<PFNGLGETFLOATVPROC>("glGetFloatv");
  std::vector<int64_t> state;
  for (const GLenum name : {GL_CURRENT_PROGRAM, GL_VERTEX_ARRAY_BINDING, GL_UNIFORM_BUFFER_BINDING,
                            GL_SHADER_STORAGE_BUFFER_BINDING, GL_COPY_READ_BUFFER_BINDING,
                            GL_COPY_WRITE_BUFFER_BINDING, GL_DISPATCH_INDIRECT_BUFFER_BINDING,
                            GL_DRAW_INDIRECT_BUFFER_BINDING, GL_DEPTH_FUNC, GL_DEPTH_WRITEMASK}) {
    GLint value = 0;
    getInteger(static_cast<GLenum>(name), &value);
    state.push_back(value);
  }
  for (GLuint i = 0; i < gl::kMaxBindings; ++i) {
    for (const GLenum name : {GL_UNIFORM_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_BINDING}) {
      GLint value = 0;
      getIndexed32(name, i, &value);
      state.push_back(value);
    }
    for (const GLenum name : {GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE,
                              GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE}) {
      GLint64 value = 0;
      getIndexed(name, i, &value);
      state.push_back(value);
    }
  }
  GLfloat range[2] = {};
  getFloat(GL_DEPTH_RANGE, range);
  for (const GLfloat value : range) state.push_back(std::bit_cast<int32_t>(value));
  GLfloat viewport[4] = {};
  getFloat(GL_VIEWPORT, viewport);
  for (const GLfloat value : viewport) state.push_back(std::bit_cast<int32_t>(value));
  for (const GLenum name :
       {GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_CULL_FACE, GL_STENCIL_TEST, GL_POLYGON_OFFSET_FILL,
        GL_RASTERIZER_DISCARD, GL_SAMPLE_COVERAGE, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_MASK,
        GL_PRIMITIVE_RESTART_FIXED_INDEX})
    state.push_back(isEnabled(name));
  for (GLuint i = 0; i < 4; ++i) {
    state.push_back(isEnabledIndexed(GL_BLEND, i));
    GLboolean mask[4] = {};
    getBooleans(GL_COLOR_WRITEMASK, i, mask);
    for (const GLboolean value : mask) state.push_back(value);
    for (const GLenum name : {GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA, GL_BLEND_SRC_RGB,
                              GL_BLEND_SRC_ALPHA, GL_BLEND_DST_RGB, GL_BLEND_DST_ALPHA}) {
      GLint value = 0;
      getIndexed32(name, i, &value);
      state.push_back(value);
    }
  }
  if (api == Api::kGl) {
    for (const GLenum name : {GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE, GL_POLYGON_MODE}) {
      GLint value[2] = {};
      getInteger(name, value);
      state.push_back(value[0]);
    }
    state.push_back(isEnabled(GL_PRIMITIVE_RESTART));
  }
  return state;
}

TEST_P(GlRuntimeTest, GuardsTheStateOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const auto kernel = accumulateKernel();
  kernel->addTo(runtime);
  const DrawKernels draws;
  draws.addTo(runtime);
  ResourceTable table;
  const BufferUsage upload = BufferUsage::kStorage | BufferUsage::kUpload;
  const BufferId buffer = addZeros(table, "buffer", 64, upload);
  const BufferId other =
      addZeros(table, "other", 64, BufferUsage::kStorage | BufferUsage::kIndirect);
  const BufferId zeros = addZeros(table, "zeros", 4, BufferUsage::kIndirect);
  const BufferId corners = addCorners(table, kEverything);
  ASSERT_TRUE(runtime.update(table));
  PassList list;
  const std::vector<uint32_t> groups(64, 1);
  addUpload(list, other, std::as_bytes(std::span(groups)));
  addAccumulate(list, *kernel, buffer, other, 64, 1, 0);
  addAccumulate(list, *kernel, other, buffer, 64, 1, 0);
  list.passes.back().kind = PassKind::kDispatchIndirect;
  list.passes.back().indirect = other;
  addDraw(list, draws, {.depthCompare = DepthCompare::kGreater, .depthWrite = false}, corners, 3,
          {}, 3);
  list.passes.back().kind = PassKind::kDrawIndirect;
  list.passes.back().indirect = zeros;  // draws nothing
  HazardTracker tracker;
  tracker.resolve(list);

  // An 8 x 8 target of the engine's.
  GLuint renderbuffer = 0, framebuffer = 0;
  glFunction<PFNGLGENRENDERBUFFERSPROC>("glGenRenderbuffers")(1, &renderbuffer);
  glFunction<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer")(GL_RENDERBUFFER, renderbuffer);
  glFunction<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage")(GL_RENDERBUFFER, GL_RGBA8, 8,
                                                                    8);
  glFunction<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers")(1, &framebuffer);
  glFunction<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer")(GL_FRAMEBUFFER, framebuffer);
  glFunction<PFNGLFRAMEBUFFERRENDERBUFFERPROC>("glFramebufferRenderbuffer")(
      GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffer);

  // Everything unlike GL's defaults and unlike what pelage sets.
  GLuint buffers[3] = {};
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(3, buffers);
  const auto bindBuffer = glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer");
  for (const GLuint name : buffers) {
    bindBuffer(GL_COPY_WRITE_BUFFER, name);
    glFunction<PFNGLBUFFERDATAPROC>("glBufferData")(GL_COPY_WRITE_BUFFER, 4096, nullptr,
                                                    GL_STATIC_DRAW);
  }
  GLuint vertexArray = 0;
  glFunction<PFNGLGENVERTEXARRAYSPROC>("glGenVertexArrays")(1, &vertexArray);
  glFunction<PFNGLBINDVERTEXARRAYPROC>("glBindVertexArray")(vertexArray);
  for (GLuint i = 0; i < 3; ++i) {
    const auto bindBase = glFunction<PFNGLBINDBUFFERBASEPROC>("glBindBufferBase");
    const auto bindRange = glFunction<PFNGLBINDBUFFERRANGEPROC>("glBindBufferRange");
    bindBase(GL_UNIFORM_BUFFER, 2 * i, buffers[i]);
    bindRange(GL_UNIFORM_BUFFER, 2 * i + 1, buffers[i], GLintptr{256} * i, 512);
    bindRange(GL_SHADER_STORAGE_BUFFER, 2 * i, buffers[i], GLintptr{256} * i, 256);
    bindBase(GL_SHADER_STORAGE_BUFFER, 2 * i + 1, buffers[i]);
  }
  bindBuffer(GL_UNIFORM_BUFFER, buffers[1]);
  bindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[2]);
  bindBuffer(GL_COPY_READ_BUFFER, buffers[0]);
  bindBuffer(GL_COPY_WRITE_BUFFER, buffers[1]);
  bindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffers[2]);
  bindBuffer(GL_DRAW_INDIRECT_BUFFER, buffers[0]);
  const auto enable = glFunction<PFNGLENABLEPROC>("glEnable");
  for (const GLenum name :
       {GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_CULL_FACE, GL_STENCIL_TEST, GL_POLYGON_OFFSET_FILL,
        GL_RASTERIZER_DISCARD, GL_SAMPLE_COVERAGE, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_MASK,
        GL_PRIMITIVE_RESTART_FIXED_INDEX})
    enable(name);
  glFunction<PFNGLVIEWPORTPROC>("glViewport")(1, 2, 3, 4);
  glFunction<PFNGLDEPTHRANGEFPROC>("glDepthRangef")(0.25f, 0.75f);
  glFunction<PFNGLDEPTHFUNCPROC>("glDepthFunc")(GL_NOTEQUAL);
  glFunction<PFNGLDEPTHMASKPROC>("glDepthMask")(GL_TRUE);
  glFunction<PFNGLENABLEIPROC>("glEnablei")(GL_BLEND, 2);
  glFunction<PFNGLCOLORMASKIPROC>("glColorMaski")(1, GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
  glFunction<PFNGLBLENDEQUATIONSEPARATEIPROC>("glBlendEquationSeparatei")(1, GL_FUNC_SUBTRACT,
                                                                          GL_FUNC_REVERSE_SUBTRACT);
  glFunction<PFNGLBLENDFUNCSEPARATEIPROC>("glBlendFuncSeparatei")(0, GL_DST_COLOR, GL_ZERO,
                                                                  GL_DST_ALPHA, GL_ONE);
  if (GetParam() == Api::kGl) {
    glFunction<PFNGLCLIPCONTROLPROC>("glClipControl")(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    glFunction<PFNGLPOLYGONMODEPROC>("glPolygonMode")(GL_FRONT_AND_BACK, GL_LINE);
    enable(GL_PRIMITIVE_RESTART);
  }
  ASSERT_EQ(glGetError_(), GLenum{GL_NO_ERROR});

  const std::vector<int64_t> before = snapshot(GetParam());
  {
    const gl::StateGuard guard(runtime);
    HazardTracker().resolve(list);
    ASSERT_TRUE(runtime.record(list));
    const Result<void> drawn = runtime.recordDraws(list, {0, 0, 8, 8});
    ASSERT_TRUE(drawn) << drawn.error().message;
    ASSERT_TRUE(runtime.read(buffer));
    EXPECT_NE(snapshot(GetParam()), before);  // otherwise this test would show nothing
  }
  EXPECT_EQ(snapshot(GetParam()), before);
}

TEST_P(GlRuntimeTest, KnowsTexturesUntilTheyAreForgotten) {
  gl::Runtime runtime = makeRuntime();
  const TextureId texture = newTextureId();
  const auto saysUnknown = [&] {
    PassList list = test::listWithTexture(texture);
    const Result<void> recorded = runtime.record(list);
    if (recorded) return false;
    return recorded.error().message.find("'g_picture': the runtime does not know the texture") !=
           std::string::npos;
  };
  EXPECT_TRUE(saysUnknown());
  runtime.registerTexture(texture, {.target = GL_TEXTURE_2D_ARRAY, .name = 1});
  EXPECT_FALSE(saysUnknown());
  runtime.registerTexture(newTextureId(), {});
  EXPECT_FALSE(saysUnknown());
  runtime.registerTexture(texture, {.target = GL_TEXTURE_2D_ARRAY});
  EXPECT_TRUE(saysUnknown());
}

// What lists with textures change, which is what units have of the targets that are registered.
TEST_P(GlRuntimeTest, GuardsTexturesAndSamplersOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const auto activate = glFunction<PFNGLACTIVETEXTUREPROC>("glActiveTexture");
  const auto bindTexture = glFunction<PFNGLBINDTEXTUREPROC>("glBindTexture");
  const auto bindSampler = glFunction<PFNGLBINDSAMPLERPROC>("glBindSampler");
  const auto getInteger = glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv");
  GLuint textures[3] = {}, sampler = 0;
  glFunction<PFNGLGENTEXTURESPROC>("glGenTextures")(3, textures);
  glFunction<PFNGLGENSAMPLERSPROC>("glGenSamplers")(1, &sampler);
  const auto state = [&] {
    std::vector<GLint> values;
    GLint active = 0;
    getInteger(GL_ACTIVE_TEXTURE, &active);
    values.push_back(active);
    for (GLuint unit = 0; unit < gl::kMaxTextures; ++unit) {
      activate(GL_TEXTURE0 + unit);
      for (const GLenum name :
           {GL_TEXTURE_BINDING_2D_ARRAY, GL_TEXTURE_BINDING_CUBE_MAP, GL_SAMPLER_BINDING})
        getInteger(name, &values.emplace_back(0));
    }
    activate(static_cast<GLenum>(active));
    return values;
  };
  activate(GL_TEXTURE3);
  bindTexture(GL_TEXTURE_2D_ARRAY, textures[0]);
  bindTexture(GL_TEXTURE_CUBE_MAP, textures[1]);
  bindSampler(0, sampler);
  bindSampler(3, sampler);
  const std::vector<GLint> before = state();
  for (const GLenum target : {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_CUBE_MAP})
    runtime.registerTexture(newTextureId(), {.target = target, .name = textures[2]});
  {
    const gl::StateGuard guard(runtime);
    activate(GL_TEXTURE0);
    bindTexture(GL_TEXTURE_2D_ARRAY, textures[2]);
    bindSampler(0, 0);
    activate(GL_TEXTURE3);
    bindTexture(GL_TEXTURE_2D_ARRAY, 0);
    bindTexture(GL_TEXTURE_CUBE_MAP, 0);
    activate(GL_TEXTURE5);
    EXPECT_NE(state(), before);
  }
  EXPECT_EQ(state(), before);
  EXPECT_EQ(glGetError_(), GLenum{GL_NO_ERROR});
}

TEST(GlBarriers, AskForExactlyTheBitsThatGlNeeds) {
  const StageMask compute = stageBit(Stage::kCompute);
  const auto bits = [](Barrier barrier) { return gl::memoryBarrierBits({&barrier, 1}); };
  EXPECT_EQ(gl::memoryBarrierBits({}), 0u);
  // Shader to shader, in every direction.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kRead,
                  .beforeStages = compute,
                  .afterStages = kVertexBit}),
            uint32_t{GL_SHADER_STORAGE_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kRead,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterStages = compute}),
            uint32_t{GL_SHADER_STORAGE_BARRIER_BIT});
  // GL orders what the host writes before what follows.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kRead,
                  .afterStages = compute,
                  .beforeUpload = true}),
            0u);
  EXPECT_EQ(bits({.before = Access::kRead,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterUpload = true}),
            0u);
  // What a shader wrote is seen by the rest of GL after a barrier only.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterUpload = true}),
            uint32_t{GL_BUFFER_UPDATE_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterIndirect = true}),
            uint32_t{GL_COMMAND_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterIndex = true}),
            uint32_t{GL_ELEMENT_ARRAY_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterVertex = true}),
            uint32_t{GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT});
  const Barrier both[] = {{.before = Access::kWrite, .beforeStages = compute, .afterIndex = true},
                          {.before = Access::kWrite,
                           .after = Access::kRead,
                           .beforeStages = compute,
                           .afterStages = kVertexBit}};
  EXPECT_EQ(gl::memoryBarrierBits(both),
            uint32_t{GL_ELEMENT_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT});
}

}  // namespace
}  // namespace pelage
