// Dispatches and draws on a device of every API: what the runtimes have in common.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/errors.h"
#include "support/own_device.h"

namespace pelage::test {
namespace {

constexpr uint32_t kThreads = 1000;  // no multiple of the group size
constexpr Float4 kBackground = {0, 0.5f, 4, 1};

class Devices : public testing::TestWithParam<Api>, protected OwnDevice {
 protected:
  void SetUp() override { open(GetParam()); }
  void TearDown() override { expectNoMessages(); }
};
INSTANTIATE_TEST_SUITE_P(All, Devices, testing::ValuesIn(kApis), apiTestName);

TEST_P(Devices, NameThemselvesAndTheirDriver) {
  const DeviceInfo& info = device_->info();
  EXPECT_EQ(info.api, GetParam());
  EXPECT_FALSE(info.name.empty());
  EXPECT_FALSE(info.driver.empty());
  if (GetParam() == Api::kVulkan) {
    EXPECT_TRUE(info.version.starts_with("1.")) << info.version;
  } else {
    const char* version = GetParam() == Api::kGles ? "OpenGL ES 3.2" : "4.";
    EXPECT_NE(info.version.find(version), std::string::npos) << info.version;
  }
  EXPECT_GE(info.maxSamples, 4u);
  RecordProperty("device", info.name + ", " + info.driver + ", " + info.version);
}

TEST_P(Devices, RefuseAnIndexThatNoDeviceHas) {
  expectError(createDevice({.api = GetParam(), .deviceIndex = 1000}), ErrorCode::kInvalidArgument,
              "1000");
}

TEST_P(Devices, FillBuffersWithInitialDataOrZerosAndReadPartsOfThem) {
  const std::vector<uint32_t> initial = ramp(7, 1000);
  const BufferId filled = add("filled", initial);
  // Memory that was used before, so that the zeros below are not there by luck.
  constexpr size_t kCount = (3u << 20) / 4 + 5;  // more than one piece of GL's zeros
  for (int i = 0; i < 8; ++i) add("dirt", std::vector<uint32_t>(kCount, 0xdeadbeefu));
  update();
  for (uint32_t id = 1; id < table_.end(); id += 2) table_.remove(table_.at(id));
  update();
  const BufferId zeros = addWords("zeros", kCount);
  update();
  EXPECT_EQ(read(filled), initial);
  EXPECT_EQ(read(filled, 400, 8), ramp(107, 2));
  EXPECT_EQ(read(filled, 3996), ramp(1006, 1));
  expectError(device_->read(filled, 3996, 8), "3996");
  EXPECT_EQ(read(zeros), std::vector<uint32_t>(kCount, 0));
}

TEST_P(Devices, ForgetRemovedBuffersAndKeepTheOthers) {
  const BufferId first = add("first", ramp(1, 10));
  const BufferId second = add("second", ramp(2, 10));
  update();
  table_.remove(first);
  const BufferId third = add("third", ramp(3, 10));
  update();
  EXPECT_FALSE(device_->read(first));
  EXPECT_EQ(read(second), ramp(2, 10));
  EXPECT_EQ(read(third), ramp(3, 10));
}

TEST_P(Devices, RunChainedDispatchesWithTheNumbersOfTheHost) {
  std::vector<uint32_t> a = ramp(1, kThreads), b = ramp(50000, kThreads);
  const BufferId bufferA = add("a", a), bufferB = add("b", b);
  update();
  PassList list;
  for (uint32_t i = 0; i < 20; ++i) {
    const bool even = i % 2 == 0;
    addAccumulate(list, even ? bufferA : bufferB, even ? bufferB : bufferA, kThreads, i + 2, i,
                  i % 3 == 0);
  }
  // The same list twice: the hazards between lists count as well.
  for (int round = 0; round < 2; ++round) {
    execute(list);
    for (uint32_t i = 0; i < 20; ++i) {
      const bool even = i % 2 == 0;
      accumulateOnHost(even ? a : b, even ? b : a, i + 2, i, i % 3 == 0);
    }
  }
  EXPECT_EQ(read(bufferA), a);
  EXPECT_EQ(read(bufferB), b);
}

TEST_P(Devices, TakeTheGroupsOfAnIndirectDispatchFromABufferThatAPassWrote) {
  std::vector<uint32_t> target(kThreads, 5);
  const BufferId source = add("source", ramp(0, kThreads));
  const BufferId result = add("result", target);
  constexpr uint64_t kOffset = 256;
  const BufferId arguments =
      addWords("arguments", (kOffset + 16) / 4, BufferUsage::kStorage | BufferUsage::kIndirect);
  update();
  constexpr uint32_t kTouched = 192;  // by three groups
  PassList list;
  for (int round = 0; round < 2; ++round) {  // the second one writes what the first has read
    expectOk(PassBuilder(list)
                 .dispatch(runtime_test::writeArgumentsVariant(), 1)
                 .bind("g_arguments", arguments, 16, kOffset)
                 .constants("AccumulateConstants", AccumulateConstants{kTouched, 0, 0, 0})
                 .finish());
    addAccumulate(list, source, result, kThreads, 2, 1);
    Pass& pass = list.passes.back();
    pass.kind = PassKind::kDispatchIndirect;
    pass.indirect = arguments;
    pass.indirectOffset = kOffset;
    for (uint32_t i = 0; i < kTouched; ++i) target[i] = 3 * target[i] + 2 * i + 1;
  }
  execute(list);
  EXPECT_EQ(read(result), target);
}

TEST_P(Devices, SetSpecializationConstantsAndKeepTheirDefaults) {
  const BufferId source = add("source", ramp(1, kThreads));
  const BufferId plain = addWords("plain", kThreads), set = addWords("set", kThreads);
  const BufferId setAgain = addWords("setAgain", kThreads);
  update();
  PassList list;
  const auto addPass = [&](BufferId target, std::span<const SpecValue> values) {
    expectOk(PassBuilder(list)
                 .dispatch(runtime_test::multiplyBySpecVariant(), kThreads)
                 .bind("g_source", source, kThreads * 4)
                 .bind("g_target", target, kThreads * 4)
                 .constants("AccumulateConstants", AccumulateConstants{kThreads, 0, 9, 0})
                 .spec(values)
                 .finish());
  };
  using Values = runtime_test::MultiplyBySpecSpecialization;
  addPass(plain, {});
  addPass(set, Values{.kFactor = 7, .kAddBias = true}.values());
  addPass(setAgain, Values{.kFactor = 8}.values());
  execute(list);
  std::vector<uint32_t> expected[3];
  for (uint32_t i = 1; i <= kThreads; ++i) {
    expected[0].push_back(2 * i);
    expected[1].push_back(7 * i + 9);
    expected[2].push_back(8 * i);
  }
  EXPECT_EQ(read(plain), expected[0]);
  EXPECT_EQ(read(set), expected[1]);
  EXPECT_EQ(read(setAgain), expected[2]);
}

TEST_P(Devices, SeeTheUploadsOfEveryFrameInTheOrderOfTheList) {
  std::vector<uint32_t> whole(kThreads), target(kThreads), part = ramp(9, kThreads);
  const BufferId wholeBuffer = addWords("whole", kThreads), partBuffer = add("part", part);
  const BufferId targetBuffer = addWords("target", kThreads);
  update();
  PassList list;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    list.clear();
    whole = ramp(1000 * frame, kThreads);
    addUpload(list, wholeBuffer, std::as_bytes(std::span(whole)));
    const std::vector<uint32_t> piece = ramp(100 + frame, 17), over(10, 77 + frame);
    const size_t first = size_t{31} * frame;
    std::copy(piece.begin(), piece.end(), part.begin() + static_cast<std::ptrdiff_t>(first));
    addUpload(list, partBuffer, std::as_bytes(std::span(piece)), first * 4);
    addUpload(list, wholeBuffer, std::as_bytes(std::span(over)), 80);  // over the first
    std::copy(over.begin(), over.end(), whole.begin() + 20);
    addAccumulate(list, wholeBuffer, targetBuffer, kThreads, 3, frame);
    addAccumulate(list, partBuffer, targetBuffer, kThreads, 11, frame);
    // The uploaded buffer is written by a kernel too, and uploaded again in the next frame.
    addAccumulate(list, targetBuffer, partBuffer, kThreads, 1, 0);
    execute(list);
    accumulateOnHost(whole, target, 3, frame);
    accumulateOnHost(part, target, 11, frame);
    accumulateOnHost(target, part, 1, 0);
  }
  EXPECT_EQ(read(wholeBuffer), whole);
  EXPECT_EQ(read(targetBuffer), target);
  EXPECT_EQ(read(partBuffer), part);
}

TEST_P(Devices, MeasureEveryPass) {
  const BufferId a = add("a", ramp(1, kThreads)), b = add("b", ramp(2, kThreads));
  update();
  PassList list;
  for (int i = 0; i < 300; ++i)  // more than one query pool of Vulkan holds
    addAccumulate(list, a, b, kThreads, 2, 3);
  std::vector<PassTiming> timings;
  execute(list, &timings);
  ASSERT_EQ(timings.size(), 300u);
  double sum = 0;
  for (const PassTiming& timing : timings) {
    EXPECT_STREQ(timing.name, "accumulate");
    // Some GL drivers have no timestamps.
    EXPECT_TRUE(timing.milliseconds >= 0 ||
                (timing.milliseconds == -1 && GetParam() != Api::kVulkan))
        << timing.milliseconds;
    EXPECT_LT(timing.milliseconds, 10000);
    sum += timing.milliseconds;
  }
  if (GetParam() == Api::kVulkan) {
    EXPECT_GT(sum, 0);
  }
}

TEST_P(Devices, PutTheTopRowFirst) {
  const BufferId corners = add("corners", kUpperHalf);
  update();
  PassList list;
  const Float4 color = {1, 0.25f, 8, 1};
  addFill(list, {}, corners, 6, {color, {0, 0, 0.01f, 0}});
  addFill(list, {}, corners, 6, {{9, 9, 9, 9}, {0, 0, 0.99f, 0}});
  // In front of the near plane, which a depth of -1..1 would show.
  addFill(list, {}, corners, 6, {{8, 8, 8, 8}, {0, 0, -0.01f, 0}});
  const RenderedImage image = render(list, {.width = 5, .height = 6, .clearColor = kBackground});
  for (size_t i = 0; i < 30; ++i)
    EXPECT_EQ(image.pixels[i], i < 15 ? color : kBackground) << "pixel " << i;
}

TEST_P(Devices, KeepTheNearestOfSeveralDrawsInStandardAndReversedDepth) {
  const BufferId corners = add("corners", kEverything), upper = add("upper", kUpperHalf);
  update();
  for (const bool reversed : {false, true}) {
    PassList list;
    const DrawState state{.depthCompare = reversed ? DepthCompare::kGreater : DepthCompare::kLess};
    addFill(list, state, corners, 3, {{1, 0, 0, 1}, {0, 0, 0.5f, 0}});
    addFill(list, state, upper, 6, {{0, 1, 0, 1}, {0, 0, 0.25f, 0}});
    addFill(list, state, upper, 6, {{0, 0, 1, 1}, {0, 0, 0.75f, 0}});
    const RenderedImage image =
        render(list, {.width = 4, .height = 4, .clearDepth = reversed ? 0.0f : 1.0f});
    EXPECT_EQ(image.pixels[0], reversed ? (Float4{0, 0, 1, 1}) : (Float4{0, 1, 0, 1}));
    EXPECT_EQ(image.pixels[15], (Float4{1, 0, 0, 1}));
  }
}

TEST_P(Devices, WriteDepthWithoutTestingItAndTestItWithoutWriting) {
  const BufferId corners = add("corners", kEverything);
  update();
  PassList list;
  // Far, but it always passes and writes; so the one in between fails against the near one before.
  const auto draw = [&](DepthCompare compare, bool write, float depth, Float4 color) {
    addFill(list, {.depthCompare = compare, .depthWrite = write}, corners, 3,
            {color, {0, 0, depth, 0}});
  };
  draw(DepthCompare::kLess, true, 0.2f, {1, 0, 0, 1});
  draw(DepthCompare::kAlways, true, 0.8f, {0, 1, 0, 1});
  draw(DepthCompare::kLess, false, 0.5f, {0, 0, 1, 1});      // passes: 0.8 is there now
  draw(DepthCompare::kLess, true, 0.6f, {1, 1, 1, 1});       // passes: 0.5 was not written
  draw(DepthCompare::kLessEqual, true, 0.7f, {9, 9, 9, 9});  // fails
  EXPECT_EQ(render(list, {.width = 1, .height = 1}).pixels[0], (Float4{1, 1, 1, 1}));
}

TEST_P(Devices, BlendPremultipliedAlphaInTheOrderOfTheDraws) {
  const BufferId corners = add("corners", kEverything);
  update();
  PassList list;
  const DrawState state{.depthCompare = DepthCompare::kAlways,
                        .depthWrite = false,
                        .blend = BlendMode::kPremultipliedAlpha};
  addFill(list, state, corners, 3, {{0.5f, 0, 0, 0.5f}, {}});
  addFill(list, state, corners, 3, {{0, 0.25f, 0, 0.75f}, {}});
  const RenderedImage image = render(list, {.width = 2, .height = 2, .clearColor = {0, 0, 4, 1}});
  for (const Float4& pixel : image.pixels) EXPECT_EQ(pixel, (Float4{0.125f, 0.25f, 0.5f, 1}));
}

TEST_P(Devices, AverageTheLinearValuesOfFourSamples) {
  // A slanted edge: pixels on it have one to three covered samples of four.
  const BufferId corners =
      add("corners", std::vector<Float4>{{-1, -1, 0, 1}, {1, -1, 0, 1}, {-1, 1, 0, 1}});
  update();
  PassList list;
  addFill(list, {}, corners, 3, {{8, 1, 0, 1}, {0.01f, 0.02f, 0, 0}});
  const RenderedImage image =
      render(list, {.width = 16, .height = 16, .samples = 4, .clearColor = {0, 1, 0, 0}});
  size_t levels[5] = {};
  for (const Float4& pixel : image.pixels) {
    EXPECT_EQ(pixel.y, 1.0f);
    EXPECT_EQ(pixel.x, 8 * pixel.w);
    EXPECT_EQ(pixel.w * 4, std::round(pixel.w * 4)) << "no quarter";
    ++levels[static_cast<size_t>(std::clamp(pixel.w * 4, 0.0f, 4.0f))];
  }
  EXPECT_GT(levels[0], 50u);
  EXPECT_GT(levels[4], 50u);
  EXPECT_GT(levels[1] + levels[2] + levels[3], 8u);
}

TEST_P(Devices, DrawIndexedTrianglesThatDispatchesOfTheSameListHaveWritten) {
  // A quad of one pixel in the top left corner of 4 x 4.
  const std::vector<Float4> quad = {
      {-1, 0.5f, 0, 1}, {-0.5f, 0.5f, 0, 1}, {-1, 1, 0, 1}, {-0.5f, 1, 0, 1}};
  const BufferId shape = add("shape", quad), corners = addWords("corners", 16);
  const BufferId given = add("given", std::vector<uint32_t>{0, 1, 2, 2, 1, 3});
  const BufferId indices = addWords("indices", 6, BufferUsage::kStorage | BufferUsage::kIndex);
  update();
  PassList list;
  addAccumulate(list, shape, corners, 16, 1, 0);  // of zeros: copies
  addAccumulate(list, given, indices, 6, 1, 0);
  addFill(list, {}, corners, 4, {{1, 1, 1, 1}, {}}, indices, 6);
  std::vector<PassTiming> timings;
  const RenderedImage image = render(list, {.width = 4, .height = 4}, &timings);
  for (size_t i = 0; i < 16; ++i)
    EXPECT_EQ(image.pixels[i].x, i == 0 ? 1.0f : 0.0f) << "pixel " << i;
  EXPECT_GE(list.drawBarriers.size(), 2u);
  ASSERT_EQ(timings.size(), 3u);
  EXPECT_STREQ(timings[0].name, "accumulate");
  EXPECT_STREQ(timings[2].name, "fill_pixel");
}

TEST_P(Devices, RefuseTargetsThatNoDeviceHas) {
  const PassList list;
  for (const RenderTargetDef& target :
       {RenderTargetDef{.width = 0, .height = 4}, RenderTargetDef{.width = 4, .height = 16385},
        RenderTargetDef{.width = 4, .height = 4, .samples = 3},
        RenderTargetDef{.width = 4, .height = 4, .samples = 16}}) {
    const Result<RenderedImage> image = device_->render(list, target);
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::kInvalidArgument) << image.error().message;
  }
}

TEST_P(Devices, DrawWithTheSampleCountsThatTheyNameAndNoOthers) {
  const PassList list;
  for (const uint32_t samples : {1u, 2u, 4u, 8u}) {
    const auto image = device_->render(list, {.width = 4, .height = 4, .samples = samples});
    ASSERT_EQ(image.ok(), (device_->info().sampleCounts & samples) != 0) << samples;
    if (!image) expectError(image, ErrorCode::kUnsupported, {device_->info().name});
  }
}

// The limits of a device are not in wrong_lists_test.cpp, nor is what its table has and it has not.
TEST_P(Devices, RefuseMoreGroupsThanTheyHaveAndBuffersThatTheyHaveNotSeen) {
  const BufferId source = add("source", ramp(1, kThreads)),
                 target = add("target", ramp(2, kThreads));
  update();
  PassList many;
  addAccumulate(many, source, target, kThreads, 1, 1);
  many.passes[0].groups[2] = 0xffffffffu;
  expectError(run(many), {"accumulate", "axis z", "4294967295"});
  const BufferId fresh = add("fresh", ramp(1, kThreads));
  PassList unseen;
  addAccumulate(unseen, fresh, target, kThreads, 1, 1);
  expectError(run(unseen), {"accumulate", "g_source", "update()"});
  EXPECT_EQ(read(target), ramp(2, kThreads));
  // They go on.
  tracker_ = {};
  update();
  PassList good;
  addAccumulate(good, fresh, target, kThreads, 1, 1);
  execute(good);
  std::vector<uint32_t> expected = ramp(2, kThreads);
  accumulateOnHost(ramp(1, kThreads), expected, 1, 1);
  EXPECT_EQ(read(target), expected);
}

}  // namespace
}  // namespace pelage::test
