// The Vulkan runtime through the headless device, under validation with synchronisation validation.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>

#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "runtime_test/gpu_structs.h"
#include "runtime_test/kernels.h"
#include "runtime_test/spirv.h"
#include "support/required_devices.h"
#include "support/test_code.h"

namespace {

using namespace pelage;
using runtime_test::AccumulateConstants;
using runtime_test::FillConstants;

constexpr uint32_t kCount = 1000;  // no multiple of the group size
constexpr uint64_t kBytes = kCount * sizeof(uint32_t);

std::vector<std::byte> bytesOf(const std::vector<uint32_t>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

std::vector<uint32_t> ramp(uint32_t first, uint32_t count = kCount) {
  std::vector<uint32_t> values(count);
  std::iota(values.begin(), values.end(), first);
  return values;
}

// What accumulate does, on the host.
void accumulateOnHost(std::vector<uint32_t>& target, const std::vector<uint32_t>& source,
                      uint32_t factor, uint32_t bias, bool doubled = false) {
  for (size_t i = 0; i < target.size(); ++i)
    target[i] = 3 * target[i] + factor * (doubled ? 2 * source[i] : source[i]) + bias;
}

class VulkanHeadless : public testing::Test {
 protected:
  // Every test has a device of its own. One more stays open, so that the loader does not unload the
  // driver in between: NVIDIA's 580 refused to be loaded again after some thirty times.
  static void SetUpTestSuite() {
    if (Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan({}); made)
      openDriver() = *std::move(made);
  }
  static void TearDownTestSuite() { openDriver().reset(); }
  static std::unique_ptr<HeadlessDevice>& openDriver() {
    static std::unique_ptr<HeadlessDevice> device;
    return device;
  }

  void SetUp() override {
    HeadlessDef def;
    def.validation = true;
    Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan(def);
    if (!made) {
      if (made.error().code == ErrorCode::kUnsupported)
        PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
      FAIL() << made.error().message;
    }
    device_ = *std::move(made);
    device_->addCode(runtime_test::allSpirv());
  }

  void TearDown() override {
    if (device_ != nullptr && !expectsMessages_) {
      EXPECT_EQ(device_->messageCount(), 0u);
    }
  }

  BufferId add(const char* name, const std::vector<uint32_t>& values,
               BufferUsage usage = BufferUsage::kStorage | BufferUsage::kUpload) {
    return table_.add({name, values.size() * 4, 4, usage, bytesOf(values)});
  }
  BufferId addZeros(const char* name, uint32_t count, BufferUsage usage = BufferUsage::kStorage) {
    return table_.add({name, count * uint64_t{4}, 4, usage, {}});
  }
  void update() {
    const Result<void> done = device_->update(table_);
    ASSERT_TRUE(done) << done.error().message;
  }
  void addAccumulate(PassList& list, BufferId source, BufferId target, uint32_t factor,
                     uint32_t bias, bool doubled = false) {
    const Result<void> added =
        PassBuilder(list)
            .dispatch(runtime_test::accumulateVariant({.doubled = doubled}), kCount)
            .bind("g_source", source, kBytes)
            .bind("g_target", target, kBytes)
            .constants("AccumulateConstants", AccumulateConstants{kCount, factor, bias, 0})
            .finish();
    ASSERT_TRUE(added) << added.error().message;
  }
  void execute(PassList& list, std::vector<PassTiming>* timings = nullptr) {
    tracker_.resolve(list);
    const Result<void> done = device_->execute(list, timings);
    ASSERT_TRUE(done) << done.error().message;
  }
  std::vector<uint32_t> read(BufferId id) {
    Result<std::vector<std::byte>> bytes = device_->read(id);
    if (!bytes) {
      ADD_FAILURE() << bytes.error().message;
      return {};
    }
    std::vector<uint32_t> values(bytes->size() / 4);
    std::memcpy(values.data(), bytes->data(), bytes->size());
    return values;
  }
  std::string errorOf(PassList& list) {
    tracker_.resolve(list);
    const Result<void> done = device_->execute(list);
    EXPECT_FALSE(done);
    return done ? std::string() : done.error().message;
  }

  std::unique_ptr<HeadlessDevice> device_;
  ResourceTable table_;
  HazardTracker tracker_;
  bool expectsMessages_ = false;
};

TEST_F(VulkanHeadless, NamesTheDeviceAndItsDriver) {
  const DeviceInfo& info = device_->info();
  EXPECT_EQ(info.api, Api::kVulkan);
  EXPECT_FALSE(info.name.empty());
  EXPECT_FALSE(info.driver.empty());
  EXPECT_EQ(info.version.substr(0, 2), "1.");
  EXPECT_GE(info.maxSamples, 4u);  // every Vulkan device draws with 4 samples
}

TEST_F(VulkanHeadless, DrawsWithTheSampleCountsThatItNamesAndNoOthers) {
  const PassList list;
  for (const uint32_t samples : {1u, 2u, 4u, 8u}) {
    const auto image = device_->render(list, {.width = 4, .height = 4, .samples = samples});
    ASSERT_EQ(image.ok(), (device_->info().sampleCounts & samples) != 0) << samples;
    if (image) continue;
    EXPECT_EQ(image.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(image.error().message.find(device_->info().name), std::string::npos);
  }
}

TEST_F(VulkanHeadless, FillsBuffersWithTheirInitialDataOrZeros) {
  const BufferId data = add("data", ramp(7));
  const BufferId zeros = addZeros("zeros", kCount);
  update();
  EXPECT_EQ(read(data), ramp(7));
  EXPECT_EQ(read(zeros), std::vector<uint32_t>(kCount, 0));
}

TEST_F(VulkanHeadless, RunsAChainOfDependentDispatchesWithTheNumbersOfTheHost) {
  std::vector<uint32_t> a = ramp(1);
  std::vector<uint32_t> b = ramp(50000);
  const BufferId bufferA = add("a", a);
  const BufferId bufferB = add("b", b);
  update();
  PassList list;
  for (uint32_t i = 0; i < 8; ++i) {
    const bool even = i % 2 == 0;
    addAccumulate(list, even ? bufferA : bufferB, even ? bufferB : bufferA, i + 2, i, i % 3 == 0);
    accumulateOnHost(even ? b : a, even ? a : b, i + 2, i, i % 3 == 0);
  }
  execute(list);
  // The same list once more: the hazards between lists count as well.
  for (uint32_t i = 0; i < 8; ++i) {
    const bool even = i % 2 == 0;
    accumulateOnHost(even ? b : a, even ? a : b, i + 2, i, i % 3 == 0);
  }
  execute(list);
  EXPECT_EQ(read(bufferA), a);
  EXPECT_EQ(read(bufferB), b);
}

TEST_F(VulkanHeadless, LetsReadersFinishBeforeABufferIsWritten) {
  // Nothing is written before it is read here: only the wait matters.
  std::vector<uint32_t> a = ramp(1);
  std::vector<uint32_t> b = ramp(2);
  const BufferId bufferA = add("a", a);
  const BufferId bufferB = add("b", b);
  const BufferId bufferC = add("c", ramp(3));
  update();
  PassList list;
  addAccumulate(list, bufferA, bufferB, 2, 3);
  addAccumulate(list, bufferC, bufferA, 5, 7);
  accumulateOnHost(b, a, 2, 3);
  accumulateOnHost(a, ramp(3), 5, 7);
  execute(list);
  ASSERT_EQ(list.barriers.size(), 1u);
  EXPECT_FALSE(writes(list.barriers[0].before));
  EXPECT_EQ(read(bufferA), a);
  EXPECT_EQ(read(bufferB), b);
}

TEST_F(VulkanHeadless, SynchronisationValidationComplainsWhenTheBarriersAreTakenAway) {
  const BufferId a = add("a", ramp(1));
  const BufferId b = add("b", ramp(2));
  update();
  PassList list;
  addAccumulate(list, a, b, 2, 3);
  addAccumulate(list, b, a, 2, 3);
  tracker_.resolve(list);
  ASSERT_GT(list.barriers.size(), 0u);
  for (Pass& pass : list.passes) pass.barrierCount = 0;
  expectsMessages_ = true;
  testing::internal::CaptureStderr();
  const Result<void> done = device_->execute(list);
  const std::string messages = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_GT(device_->messageCount(), 0u);
  EXPECT_NE(messages.find("SYNC-HAZARD"), std::string::npos) << messages;
}

TEST_F(VulkanHeadless, ReadsOfABufferThatIsDeclaredForWritingNeedNoBarrier) {
  const BufferId shared = add("shared", ramp(11));
  const BufferId first = addZeros("first", kCount);
  const BufferId second = addZeros("second", kCount);
  update();
  PassList list;
  for (const BufferId out : {first, second}) {
    ASSERT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::copyTargetVariant(), kCount)
                    .bind("g_target", shared, kBytes)
                    .bind("g_arguments", out, kBytes)
                    .constants("AccumulateConstants", AccumulateConstants{kCount, 0, 0, 0})
                    .finish());
  }
  tracker_.resolve(list);
  EXPECT_EQ(list.barriers.size(), 0u);
  execute(list);
  EXPECT_EQ(read(first), ramp(11));
  EXPECT_EQ(read(second), ramp(11));
}

TEST_F(VulkanHeadless, TakesTheGroupsOfAnIndirectDispatchFromABufferThatAPassWrote) {
  std::vector<uint32_t> target(kCount, 5);
  const BufferId source = add("source", ramp(0));
  const BufferId result = add("result", target);
  const BufferId arguments =
      addZeros("arguments", 4, BufferUsage::kStorage | BufferUsage::kIndirect);
  update();
  const AccumulateConstants constants{kCount, 2, 1, 0};
  PassList list;
  for (int round = 0; round < 2; ++round) {  // the second one writes what the first has read
    ASSERT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::writeArgumentsVariant(), 1)
                    .bind("g_arguments", arguments, 16)
                    .constants("AccumulateConstants", constants)
                    .finish());
    addAccumulate(list, source, result, 2, 1);
    Pass& pass = list.passes.back();
    pass.kind = PassKind::kDispatchIndirect;
    pass.indirect = arguments;
    accumulateOnHost(target, ramp(0), 2, 1);
  }
  execute(list);
  EXPECT_EQ(read(result), target);
}

TEST_F(VulkanHeadless, SetsSpecializationConstantsAndKeepsTheirDefaults) {
  const BufferId source = add("source", ramp(1));
  const BufferId plain = addZeros("plain", kCount);
  const BufferId set = addZeros("set", kCount);
  const BufferId setAgain = addZeros("setAgain", kCount);
  update();
  PassList list;
  const auto addPass = [&](BufferId target, const std::vector<SpecValue>& values) {
    ASSERT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::multiplyBySpecVariant(), kCount)
                    .bind("g_source", source, kBytes)
                    .bind("g_target", target, kBytes)
                    .constants("AccumulateConstants", AccumulateConstants{kCount, 0, 9, 0})
                    .spec(values)
                    .finish());
  };
  addPass(plain, {});
  const auto seven =
      runtime_test::MultiplyBySpecSpecialization{.kFactor = 7, .kAddBias = true}.values();
  addPass(set, {seven.begin(), seven.end()});
  const auto eight = runtime_test::MultiplyBySpecSpecialization{.kFactor = 8}.values();
  addPass(setAgain, {eight.begin(), eight.end()});
  execute(list);
  std::vector<uint32_t> expected[3];
  for (uint32_t i = 1; i <= kCount; ++i) {
    expected[0].push_back(2 * i);
    expected[1].push_back(7 * i + 9);
    expected[2].push_back(8 * i);
  }
  EXPECT_EQ(read(plain), expected[0]);
  EXPECT_EQ(read(set), expected[1]);
  EXPECT_EQ(read(setAgain), expected[2]);
}

TEST_F(VulkanHeadless, UploadsInTheOrderOfTheListBeforeTheFirstPass) {
  std::vector<uint32_t> source = ramp(0);
  std::vector<uint32_t> target(kCount, 1);
  const BufferId sourceBuffer = add("source", source);
  const BufferId targetBuffer = add("target", target);
  update();
  for (uint32_t frame = 0; frame < 3; ++frame) {
    PassList list;
    const std::vector<uint32_t> whole = ramp(100 * frame);
    const std::vector<uint32_t> part(10, 77 + frame);
    addUpload(list, sourceBuffer, std::as_bytes(std::span(whole)));
    addUpload(list, sourceBuffer, std::as_bytes(std::span(part)), 80);  // over the first
    source = whole;
    std::copy(part.begin(), part.end(), source.begin() + 20);
    addAccumulate(list, sourceBuffer, targetBuffer, 5, frame);
    accumulateOnHost(target, source, 5, frame);
    execute(list);
  }
  EXPECT_EQ(read(sourceBuffer), source);
  EXPECT_EQ(read(targetBuffer), target);
}

TEST_F(VulkanHeadless, KeepsConstantsOfPassesApart) {
  std::vector<BufferId> targets;
  const BufferId source = add("source", ramp(1));
  constexpr uint32_t kPasses = 300;  // more constants than one chunk of them holds
  for (uint32_t i = 0; i < kPasses; ++i) targets.push_back(addZeros("target", kCount));
  update();
  PassList list;
  for (uint32_t i = 0; i < kPasses; ++i) addAccumulate(list, source, targets[i], i, 1000 * i);
  execute(list);
  for (uint32_t i = 0; i < kPasses; ++i) {
    std::vector<uint32_t> expected(kCount, 0);
    accumulateOnHost(expected, ramp(1), i, 1000 * i);
    ASSERT_EQ(read(targets[i]), expected) << "pass " << i;
  }
}

TEST_F(VulkanHeadless, RunsAPassThatUsesNoConstantsOfItsLayout) {
  const BufferId marked = add("marked", ramp(100));
  update();
  PassList list;
  ASSERT_TRUE(PassBuilder(list)
                  .dispatch(runtime_test::markVariant(), 1)
                  .bind("g_arguments", marked, kBytes)
                  .finish());
  EXPECT_TRUE(list.constants.empty());
  execute(list);
  std::vector<uint32_t> expected = ramp(100);
  expected[0] = 42;
  EXPECT_EQ(read(marked), expected);
}

TEST_F(VulkanHeadless, ReusesDescriptorsAndMemoryAsBuffersComeAndGo) {
  const BufferId source = add("source", ramp(3));
  for (uint32_t round = 0; round < 100; ++round) {
    const BufferId target = add("target", std::vector<uint32_t>(kCount, round));
    update();
    PassList list;
    addAccumulate(list, source, target, round, 1);
    execute(list);
    std::vector<uint32_t> expected(kCount, round);
    accumulateOnHost(expected, ramp(3), round, 1);
    ASSERT_EQ(read(target), expected) << "round " << round;
    table_.remove(target);
    tracker_.forget(target);
  }
  update();
}

TEST_F(VulkanHeadless, MeasuresEveryPass) {
  const BufferId a = add("a", ramp(1));
  const BufferId b = add("b", ramp(2));
  update();
  PassList list;
  for (int i = 0; i < 300; ++i) addAccumulate(list, a, b, 2, 3);  // more than one query pool holds
  std::vector<PassTiming> timings;
  execute(list, &timings);
  ASSERT_EQ(timings.size(), 300u);
  double sum = 0;
  for (const PassTiming& timing : timings) {
    EXPECT_STREQ(timing.name, "accumulate");
    EXPECT_GE(timing.milliseconds, 0);
    EXPECT_LT(timing.milliseconds, 10000);
    sum += timing.milliseconds;
  }
  EXPECT_GT(sum, 0);
}

TEST_F(VulkanHeadless, ReadsPartsOfABuffer) {
  const BufferId a = add("a", ramp(0));
  update();
  Result<std::vector<std::byte>> part = device_->read(a, 40, 8);
  ASSERT_TRUE(part) << part.error().message;
  uint32_t values[2];
  ASSERT_EQ(part->size(), sizeof(values));
  std::memcpy(values, part->data(), sizeof(values));
  EXPECT_EQ(values[0], 10u);
  EXPECT_EQ(values[1], 11u);
  Result<std::vector<std::byte>> rest = device_->read(a, kBytes - 4);
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->size(), 4u);
  const Result<std::vector<std::byte>> beyond = device_->read(a, kBytes - 4, 8);
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().message.find("3996 to 4004"), std::string::npos)
      << beyond.error().message;
}

// Draws.

class VulkanDraw : public VulkanHeadless {
 protected:
  // A triangle that covers the half-plane below the line through the two points at its top.
  static std::vector<uint32_t> floats(const std::vector<float>& values) {
    std::vector<uint32_t> bits(values.size());
    std::memcpy(bits.data(), values.data(), values.size() * 4);
    return bits;
  }
  // Two triangles over x0..x1, y0..y1 in clip space at a depth.
  BufferId addQuad(float x0, float y0, float x1, float y1, float depth) {
    return add("quad", floats({x0, y0, depth, 1, x1, y0, depth, 1, x1, y1, depth, 1,  //
                               x0, y0, depth, 1, x1, y1, depth, 1, x0, y1, depth, 1}));
  }
  void addDraw(PassList& list, BufferId corners, Float4 color, const DrawState& state = {},
               uint32_t count = 6, BufferId indices = BufferId::kInvalid) {
    const Result<void> added = PassBuilder(list)
                                   .draw(runtime_test::fillVertexVariant(),
                                         runtime_test::fillPixelVariant(), state, count, 1, indices)
                                   .bind("g_corners", corners, table_.find(corners)->size)
                                   .constants("FillConstants", FillConstants{color, {}})
                                   .finish();
    ASSERT_TRUE(added) << added.error().message;
  }
  RenderedImage render(PassList& list, const RenderTargetDef& target,
                       std::vector<PassTiming>* timings = nullptr) {
    tracker_.resolve(list);
    Result<RenderedImage> image = device_->render(list, target, timings);
    if (!image) {
      ADD_FAILURE() << image.error().message;
      return {target.width, target.height,
              std::vector<Float4>(size_t{target.width} * target.height)};
    }
    return *std::move(image);
  }
};

constexpr Float4 kRed = {1, 0, 0, 1};
constexpr Float4 kGreen = {0, 1, 0, 1};
constexpr Float4 kClear = {0.25f, 0.5f, 0.75f, 0.5f};

TEST_F(VulkanDraw, PutsPositiveClipYIntoTheTopRows) {
  const BufferId top = addQuad(-1, 0, 0, 1, 0.5f);
  update();
  PassList list;
  addDraw(list, top, kRed);
  const RenderedImage image =
      render(list, {.width = 8, .height = 6, .clearColor = kClear, .clearDepth = 1});
  for (uint32_t y = 0; y < 6; ++y)
    for (uint32_t x = 0; x < 8; ++x)
      EXPECT_EQ(image.pixels[y * 8 + x], y < 3 && x < 4 ? kRed : kClear) << x << ", " << y;
}

TEST_F(VulkanDraw, KeepsTheNearerSurfaceWhateverTheOrder) {
  const BufferId nearer = addQuad(-1, -1, 1, 1, 0.25f);
  const BufferId farther = addQuad(-1, -1, 1, 1, 0.75f);
  update();
  for (const bool nearFirst : {false, true}) {
    PassList list;
    addDraw(list, nearFirst ? nearer : farther, nearFirst ? kRed : kGreen);
    addDraw(list, nearFirst ? farther : nearer, nearFirst ? kGreen : kRed);
    const RenderedImage image = render(list, {.width = 4, .height = 4});
    EXPECT_EQ(image.pixels[5], kRed) << nearFirst;

    // The same with reversed depth: the larger value is the nearer one.
    PassList reversed;
    const DrawState greater = {.depthCompare = DepthCompare::kGreater};
    addDraw(reversed, nearFirst ? nearer : farther, nearFirst ? kRed : kGreen, greater);
    addDraw(reversed, nearFirst ? farther : nearer, nearFirst ? kGreen : kRed, greater);
    const RenderedImage turned = render(reversed, {.width = 4, .height = 4, .clearDepth = 0});
    EXPECT_EQ(turned.pixels[5], kGreen) << nearFirst;
  }
}

TEST_F(VulkanDraw, BlendsPremultipliedColours) {
  const BufferId quad = addQuad(-1, -1, 1, 1, 0.5f);
  update();
  PassList list;
  addDraw(list, quad, {0.25f, 0, 0, 0.5f},
          {.depthCompare = DepthCompare::kAlways,
           .depthWrite = false,
           .blend = BlendMode::kPremultipliedAlpha});
  const RenderedImage image = render(list, {.width = 2, .height = 2, .clearColor = kClear});
  // source + (1 - 0.5) kClear
  EXPECT_EQ(image.pixels[0], (Float4{0.375f, 0.25f, 0.375f, 0.75f}));
}

TEST_F(VulkanDraw, AveragesTheSamplesOfAPixel) {
  // Everything below a line that rises slowly from left to right.
  const BufferId corners =
      add("slope", floats({-1, -0.5f, 0.5f, 1, 1, 0.5f, 0.5f, 1, 1,  -1, 0.5f, 1,
                           -1, -0.5f, 0.5f, 1, 1, -1,   0.5f, 1, -1, -1, 0.5f, 1}));
  update();
  constexpr uint32_t kSize = 32;
  PassList list;
  addDraw(list, corners, {1, 1, 1, 1});
  const auto sum = [](const RenderedImage& image) {
    double all = 0;
    for (const Float4& pixel : image.pixels) all += pixel.x;
    return all;
  };
  const RenderedImage one = render(list, {.width = kSize, .height = kSize});
  const RenderedImage four = render(list, {.width = kSize, .height = kSize, .samples = 4});
  uint32_t partial = 0;
  for (const Float4& pixel : one.pixels) EXPECT_TRUE(pixel.x == 0 || pixel.x == 1);
  for (const Float4& pixel : four.pixels) {
    EXPECT_EQ(pixel.x * 4, std::round(pixel.x * 4));
    if (pixel.x > 0 && pixel.x < 1) ++partial;
  }
  EXPECT_GE(partial, kSize / 2);
  // Half of the square lies below the line.
  EXPECT_NEAR(sum(four), kSize * kSize * 0.5, kSize * 0.25);
}

TEST_F(VulkanDraw, DrawsIndexedTrianglesThatAPassHasMoved) {
  // The dispatch triples zeros and adds nothing; the draw reads positions and indices after it.
  const BufferId corners =
      add("corners", floats({-1, -1, 0.5f, 1, 1, -1, 0.5f, 1, 1, 1, 0.5f, 1, -1, 1, 0.5f, 1}));
  const BufferId indices =
      add("indices", {0, 1, 2, 0, 2, 3}, BufferUsage::kStorage | BufferUsage::kIndex);
  const BufferId zeros = addZeros("zeros", 6);
  update();
  PassList list;
  // indices = 1 * zeros + indices * 3 would break them: write them to where they are by hand.
  ASSERT_TRUE(PassBuilder(list)
                  .dispatch(runtime_test::accumulateVariant(), 6)
                  .bind("g_source", indices, 24)
                  .bind("g_target", zeros, 24)
                  .constants("AccumulateConstants", AccumulateConstants{6, 1, 0, 0})
                  .finish());
  ASSERT_TRUE(PassBuilder(list)
                  .dispatch(runtime_test::multiplyBySpecVariant(), 6)
                  .bind("g_source", zeros, 24)
                  .bind("g_target", indices, 24)
                  .constants("AccumulateConstants", AccumulateConstants{6, 0, 0, 0})
                  .spec(std::vector<SpecValue>{{0, 1}})
                  .finish());
  addDraw(list, corners, kGreen, {}, 6, indices);
  std::vector<PassTiming> timings;
  const RenderedImage image = render(list, {.width = 3, .height = 3}, &timings);
  for (const Float4& pixel : image.pixels) EXPECT_EQ(pixel, kGreen);
  EXPECT_GE(list.drawBarriers.size(), 1u);
  ASSERT_EQ(timings.size(), 3u);
  EXPECT_STREQ(timings[2].name, "fill_pixel");
  for (const PassTiming& timing : timings) EXPECT_GE(timing.milliseconds, 0);
}

TEST_F(VulkanDraw, RefusesATargetThatNoDeviceHas) {
  PassList list;
  for (const RenderTargetDef& target :
       {RenderTargetDef{.width = 0, .height = 4}, RenderTargetDef{.width = 4, .height = 16385},
        RenderTargetDef{.width = 4, .height = 4, .samples = 3},
        RenderTargetDef{.width = 4, .height = 4, .samples = 16}}) {
    const Result<RenderedImage> image = device_->render(list, target);
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::kInvalidArgument) << image.error().message;
  }
}

// Bad input: an error that names pass and resource, and a device that still works.

class VulkanErrors : public VulkanHeadless {
 protected:
  static std::vector<uint32_t> spirvOf(const KernelVariant& variant) {
    return *KernelCodes(runtime_test::allSpirv()).spirv(variant);
  }
  // The module of a permutation that the test has copied.
  void giveSpirv(KernelVariant& variant, std::span<const uint32_t> words) {
    variant.hash = test::freshHash();
    const KernelCode* const code[] = {test::makeSpirv(*variant.kernel, variant.hash, words)};
    device_->addCode(code);
  }
  void SetUp() override {
    VulkanHeadless::SetUp();
    if (device_ == nullptr) return;
    a_ = add("first/positions", ramp(1));
    b_ = add("first/tangents", ramp(2));
    update();
    addAccumulate(list_, a_, b_, 2, 3);
  }
  void TearDown() override {
    if (device_ == nullptr) return;
    // The error has changed nothing: a good list gives the numbers of an untouched device.
    tracker_ = {};
    PassList good;
    addAccumulate(good, a_, b_, 2, 3);
    execute(good);
    std::vector<uint32_t> expected = ramp(2);
    accumulateOnHost(expected, ramp(1), 2, 3);
    EXPECT_EQ(read(b_), expected);
    VulkanHeadless::TearDown();
  }
  void expectError(std::initializer_list<const char*> words) {
    const std::string message = errorOf(list_);
    for (const char* word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
  }

  BufferId a_ = BufferId::kInvalid;
  BufferId b_ = BufferId::kInvalid;
  PassList list_;
};

TEST_F(VulkanErrors, NamePassAndResourceOfARemovedBuffer) {
  const BufferId gone = add("gone", ramp(1));
  update();
  list_.clear();
  addAccumulate(list_, gone, b_, 1, 1);
  table_.remove(gone);
  update();
  const std::string number = "#" + std::to_string(static_cast<uint32_t>(gone));
  expectError({"accumulate", "g_source", number.c_str(), "removed"});
}

TEST_F(VulkanErrors, NameABufferThatUpdateHasNotSeen) {
  const BufferId fresh = add("fresh", ramp(1));
  list_.clear();
  addAccumulate(list_, fresh, b_, 1, 1);
  expectError({"accumulate", "g_source", "update()"});
  update();
}

TEST_F(VulkanErrors, NameTheBytesOfABindingBehindTheBuffersEnd) {
  list_.bindings[1].size = kBytes + 4;
  expectError({"accumulate", "first/", "4004", "4000"});
}

TEST_F(VulkanErrors, NameAnOffsetThatTheDeviceCannotBind) {
  for (PassBinding& binding : list_.bindings) {
    if (binding.buffer == a_) {
      binding.offset = 2;
      binding.size = 8;
    }
  }
  expectError({"accumulate", "g_source", "storage buffer offset alignment"});
}

TEST_F(VulkanErrors, NameTheResourceThatNothingIsBoundTo) {
  std::erase_if(list_.bindings, [&](const PassBinding& binding) { return binding.buffer == a_; });
  list_.passes[0].bindingCount = 2;
  expectError({"accumulate", "binds nothing", "g_source"});
}

TEST_F(VulkanErrors, NameTheAxisWithTooManyGroups) {
  list_.passes[0].groups[1] = 0xffffffffu;
  expectError({"accumulate", "axis y", "4294967295"});
}

TEST_F(VulkanErrors, NameAnAxisWithoutGroups) {
  list_.passes[0].groups[2] = 0;
  expectError({"accumulate", "axis z"});
}

TEST_F(VulkanErrors, NameAKernelWithoutSpirv) {
  KernelVariant empty = runtime_test::accumulateVariant({.doubled = true});
  empty.hash = test::freshHash();
  list_.passes[0].kernel = &empty;
  expectError({"accumulate", "doubled=1", "SPIR-V"});
}

TEST_F(VulkanErrors, NameAKernelWhoseSpirvIsCutOff) {
  KernelVariant cut = runtime_test::accumulateVariant();
  list_.passes[0].kernel = &cut;
  const std::vector<uint32_t> whole = spirvOf(runtime_test::accumulateVariant());
  giveSpirv(cut, std::span(whole).first(6));
  expectError({"accumulate", "SPIR-V", "word 5"});
  giveSpirv(cut, std::vector<uint32_t>(20, 0x12345678u));
  expectError({"accumulate", "SPIR-V"});
}

TEST_F(VulkanErrors, NameAFeatureThatTheDeviceWasNotGiven) {
  // The module with OpCapability Float64 in front of its own capabilities.
  const KernelVariant& plain = runtime_test::accumulateVariant();
  std::vector<uint32_t> words = spirvOf(plain);
  const uint32_t capability[] = {2u << 16 | 17u, 10u};
  words.insert(words.begin() + 5, std::begin(capability), std::end(capability));
  KernelVariant needy = plain;
  giveSpirv(needy, words);
  list_.passes[0].kernel = &needy;
  expectError({"accumulate", "shaderFloat64"});
}

TEST_F(VulkanErrors, NameABlockThatIsTooSmall) {
  for (PassBinding& binding : list_.bindings)
    if (binding.buffer == BufferId::kInvalid) binding.size = 8;
  expectError({"accumulate", "AccumulateConstants", "16 bytes"});
}

TEST_F(VulkanErrors, NameAnUploadBehindTheBuffersEnd) {
  const std::vector<uint32_t> four = ramp(0, 4);
  addUpload(list_, a_, std::as_bytes(std::span(four)), kBytes - 8);
  expectError({"upload", "first/positions", "16 bytes at 3992"});
}

TEST_F(VulkanErrors, NameABufferThatWasNotMadeForIndirectArguments) {
  list_.passes[0].kind = PassKind::kDispatchIndirect;
  list_.passes[0].indirect = a_;
  expectError({"accumulate", "first/positions", "indirect"});
}

TEST_F(VulkanErrors, NameAPassWhoseRangesLeaveTheList) {
  list_.passes[0].specValueCount = 1;
  const Result<void> done = device_->execute(list_);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("accumulate"), std::string::npos) << done.error().message;
}

// Making a device.

TEST(VulkanHeadlessDevice, RefusesAnIndexThatNoDeviceHas) {
  HeadlessDef def;
  def.deviceIndex = 1000;
  const Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan(def);
  ASSERT_FALSE(made);
  if (made.error().code == ErrorCode::kUnsupported)
    PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
  EXPECT_NE(made.error().message.find("1000"), std::string::npos) << made.error().message;
}

// An environment variable for the time of a scope.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    had_ = std::getenv(name) != nullptr;
    setenv(name, value, 1);
  }
  ~Environment() {
    if (had_) {
      setenv(name_, old_.c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::string old_;
  bool had_ = false;
};

TEST(VulkanHeadlessDevice, NamesThePackageWithTheValidationLayerWhenItIsMissing) {
  const Environment nowhere("VK_LAYER_PATH", "/nonexistent");
  HeadlessDef def;
  def.validation = true;
  const Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan(def);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(made.error().message.find("apt-get install"), std::string::npos)
      << made.error().message;
}

TEST(VulkanHeadlessDevice, NamesThePackageWithADriverWhenThereIsNone) {
  const Environment newName("VK_DRIVER_FILES", "/nonexistent.json");
  const Environment oldName("VK_ICD_FILENAMES", "/nonexistent.json");
  const Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan({});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(made.error().message.find("apt-get install"), std::string::npos)
      << made.error().message;
}

TEST(VulkanHeadlessDevice, LeavesNothingBehind) {
  testing::internal::CaptureStderr();
  {
    HeadlessDef def;
    def.validation = true;
    Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan(def);
    if (!made && made.error().code == ErrorCode::kUnsupported) {
      testing::internal::GetCapturedStderr();
      PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
    }
    ASSERT_TRUE(made);
    ResourceTable table;
    const BufferId buffer = table.add({"a", 4096, 4, BufferUsage::kStorage, {}});
    ASSERT_TRUE((*made)->update(table));
    PassList list;
    ASSERT_TRUE((*made)->render(list, {.width = 16, .height = 16, .samples = 4}));
    ASSERT_TRUE((*made)->read(buffer));
  }
  // The layer reports objects that outlive their device.
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
