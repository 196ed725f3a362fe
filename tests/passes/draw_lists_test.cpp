// Draws that share layouts, take their counts from buffers, write buffers, and go on in a target
// over several lists: on every API.

#include "runtime_test/layouts.h"
#include "support/errors.h"
#include "support/own_device.h"

namespace pelage::test {
namespace {

using runtime_test::RecordConstants;

constexpr uint32_t kWidth = 12, kHeight = 7;
constexpr size_t kPixels = size_t{kWidth} * kHeight;
constexpr Float4 kRed = {1, 0, 0, 1};
constexpr Float4 kGreen = {0, 1, 0, 1};
constexpr Float4 kClear = {0.25f, 0.5f, 0.75f, 0.5f};
constexpr uint32_t kFar = 0x3f800000u;  // the bits of 1.0f

// Pixels x0..x1, y0..y1 (row 0 is the top row) at a depth, as two triangles.
struct Rectangle {
  uint32_t x0, y0, x1, y1;
  float depth = 0.5f;

  bool contains(size_t pixel) const {
    const size_t x = pixel % kWidth, y = pixel / kWidth;
    return x >= x0 && x < x1 && y >= y0 && y < y1;
  }
  std::vector<Float4> corners() const {
    const auto corner = [&](uint32_t x, uint32_t y) {
      return Float4{2 * static_cast<float>(x) / kWidth - 1, 1 - 2 * static_cast<float>(y) / kHeight,
                    depth, 1};
    };
    return {corner(x0, y0), corner(x1, y0), corner(x1, y1),
            corner(x0, y0), corner(x1, y1), corner(x0, y1)};
  }
};

class DrawLists : public GpuTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    if (IsSkipped()) return;
    hits_.emplace(gpu(), "hits", std::vector<uint32_t>(kPixels, 0));
    depths_.emplace(gpu(), "depths", std::vector<uint32_t>(kPixels, kFar));
    shifts_.emplace(gpu(), "shifts", std::vector<Float4>(4, Float4{2.0f * 2 / kWidth, 0, 0, 0}));
  }
  void TearDown() override {
    hits_.reset();
    depths_.reset();
    shifts_.reset();
    for (const BufferId id : buffers_) {
      gpu().hazards.forget(id);
      gpu().resources.remove(id);
    }
    GpuTest::TearDown();
  }

  HeadlessDevice& device() { return *gpu().device(); }
  BufferId add(BufferDesc desc) {
    buffers_.push_back(gpu().resources.add(std::move(desc)));
    return buffers_.back();
  }
  BufferId addCorners(const std::vector<Float4>& corners) {
    buffers_.push_back(gpu().resources.add("corners", corners, BufferUsage::kStorage));
    return buffers_.back();
  }
  BufferId addCorners(const Rectangle& rectangle) { return addCorners(rectangle.corners()); }
  BufferId addWords(const char* name, size_t count, BufferUsage usage = BufferUsage::kStorage) {
    return add({.name = name, .size = count * 4, .stride = 4, .usage = usage});
  }

  // Offers everything that any of the kernels may want.
  void finish(PassBuilder& pass, BufferId corners, Float4 color, Float4 offset = {}) {
    pass.bind("g_corners", corners, gpu().resources.find(corners)->size);
    hits_->bindTo(pass, "g_hits");
    depths_->bindTo(pass, "g_depths");
    shifts_->bindTo(pass, "g_shifts");
    expectOk(pass.constants("FillConstants", FillConstants{color, offset})
                 .constants("RecordConstants", RecordConstants{kWidth, 0, 0, 0})
                 .finish());
  }
  void addDraw(PassList& list, const KernelVariant& vertex, const KernelVariant& pixel,
               BufferId corners, Float4 color, const DrawState& state = {}, uint32_t instances = 1,
               Float4 offset = {}) {
    PassBuilder pass(list);
    pass.draw(vertex, pixel, state, 6, instances);
    finish(pass, corners, color, offset);
  }
  void addRecord(PassList& list, BufferId corners, Float4 color, const DrawState& state = {}) {
    addDraw(list, runtime_test::fillVertexVariant(), runtime_test::recordPixelVariant(), corners,
            color, state);
  }
  RenderedImage render(std::span<PassList> lists, RenderTargetDef target = {}) {
    target.width = kWidth;
    target.height = kHeight;
    target.clearColor = kClear;
    std::vector<const PassList*> pointers;
    for (PassList& list : lists) {
      gpu().hazards.resolve(list);
      pointers.push_back(&list);
    }
    expectOk(device().update(gpu().resources));
    Result<RenderedImage> image = device().render(pointers, target);
    if (image) return *std::move(image);
    ADD_FAILURE() << image.error().message;
    return {kWidth, kHeight, std::vector<Float4>(kPixels)};
  }
  RenderedImage render(PassList& list, const RenderTargetDef& target = {}) {
    return render(std::span(&list, 1), target);
  }
  Result<RenderedImage> tryRender(const PassList& list, const RenderTargetDef& target) {
    expectOk(device().update(gpu().resources));
    PassList copy = list;
    copy.run.reset();  // it may have run
    gpu().hazards.resolve(copy);
    return device().render(copy, target);
  }
  std::vector<float> readFloats(BufferId id) {
    const Result<std::vector<std::byte>> bytes = required(device().read(id));
    return valuesOf<float>(*bytes);
  }

  std::optional<GuardedBuffer<uint32_t>> hits_, depths_;
  std::optional<GuardedBuffer<Float4>> shifts_;

 private:
  std::vector<BufferId> buffers_;
};
INSTANTIATE_TEST_SUITE_P(All, DrawLists, testing::ValuesIn(kApis), apiTestName);

TEST_P(DrawLists, TakeAVertexKernelOfTheFirstLayoutsOfThePixelKernel) {
  const Rectangle rectangle = {1, 2, 5, 3};
  PassList list;
  addRecord(list, addCorners(rectangle), kRed);
  const RenderedImage image = render(list);
  const std::vector<uint32_t> hits = hits_->read();
  for (size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(hits[i], rectangle.contains(i) ? 1u : 0u) << i;
    EXPECT_EQ(image.pixels[i], rectangle.contains(i) ? kRed : kClear) << i;
  }
}

TEST_P(DrawLists, TakeAPixelKernelOfTheFirstLayoutsOfTheVertexKernel) {
  const Rectangle rectangle = {1, 2, 5, 3};
  PassList list;
  addDraw(list, runtime_test::shiftVertexVariant(), runtime_test::fillPixelVariant(),
          addCorners(rectangle), kGreen);
  const RenderedImage image = render(list);
  const Rectangle shifted = {3, 2, 7, 3};
  for (size_t i = 0; i < kPixels; ++i)
    EXPECT_EQ(image.pixels[i], shifted.contains(i) ? kGreen : kClear) << i;
}

TEST_P(DrawLists, RefuseKernelsOfOtherLayouts) {
  PassList list;
  addRecord(list, addCorners(Rectangle{0, 0, 1, 1}), kRed);
  const LayoutTable* const other[] = {&runtime_test::kRuntimeComputeLayout};
  Kernel kernel = *list.passes[0].pixel->kernel;
  kernel.layouts = other;
  KernelVariant pixel = *list.passes[0].pixel;
  pixel.kernel = &kernel;
  list.passes[0].pixel = &pixel;
  expectError(tryRender(list, {.width = 4, .height = 4}), {"group"});
}

TEST_P(DrawLists, DrawAsManyInstancesAsADispatchHasWritten) {
  // Every instance is two pixels further right than the one before it.
  constexpr uint64_t kOffset = 16;
  const BufferId arguments =
      addWords("arguments", 8, BufferUsage::kStorage | BufferUsage::kIndirect);
  const BufferId shifts = add({.name = "shifts", .size = 64, .stride = 16});
  PassList fill;
  std::vector<Float4> steps;
  for (int i = 0; i < 4; ++i) steps.push_back({2.0f * 2 * static_cast<float>(i) / kWidth, 0, 0, 0});
  addUpload(fill, shifts, std::as_bytes(std::span(steps)));
  const BufferId corners = addCorners(Rectangle{1, 1, 2, 4});
  expectOk(device().update(gpu().resources));
  gpu().hazards.resolve(fill);
  expectOk(device().execute(fill));
  for (const uint32_t instances : {3u, 0u, 4u}) {
    PassList list;
    PassBuilder pass(list);
    expectOk(
        pass.dispatch(runtime_test::writeDrawArgumentsVariant(), 1)
            .bind("g_arguments", arguments, 32)
            .constants("AccumulateConstants", AccumulateConstants{instances, 6, kOffset / 4, 0})
            .finish());
    pass.drawIndirect(runtime_test::shiftVertexVariant(), runtime_test::fillPixelVariant(), {},
                      arguments, kOffset);
    expectOk(pass.bind("g_corners", corners, 96)
                 .bind("g_shifts", shifts, 64)
                 .constants("FillConstants", FillConstants{kGreen, {}})
                 .finish());
    ASSERT_EQ(list.passes.size(), 2u);
    const RenderedImage image = render(list);
    for (size_t i = 0; i < kPixels; ++i) {
      bool covered = false;
      for (uint32_t k = 0; k < instances; ++k)
        covered |= Rectangle{1 + 2 * k, 1, 2 + 2 * k, 4}.contains(i);
      EXPECT_EQ(image.pixels[i], covered ? kGreen : kClear) << instances << ", pixel " << i;
    }
  }
}

TEST_P(DrawLists, NameTheDrawWhoseArgumentsAreNotInTheirBuffer) {
  const BufferId arguments =
      addWords("arguments", 8, BufferUsage::kStorage | BufferUsage::kIndirect);
  const BufferId corners = addCorners(Rectangle{0, 0, 1, 1});
  PassList list;
  PassBuilder pass(list);
  pass.drawIndirect(runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(), {},
                    arguments, 16);
  finish(pass, corners, kRed);
  EXPECT_EQ(render(list).pixels[0], kClear);  // zero vertices: the arguments just fit
  list.passes[0].indirectOffset = 20;
  expectError(tryRender(list, {.width = 4, .height = 4}), {"fill_", "arguments"});
  list.passes[0].indirectOffset = 16;
  list.passes[0].indices = corners;
  expectError(tryRender(list, {.width = 4, .height = 4}), {"indices"});
}

TEST_P(DrawLists, WriteBuffersAndNoColourWhereTheStateSaysSo) {
  const Rectangle silent = {2, 1, 9, 6}, loud = {4, 0, 6, 4, 0.25f};
  PassList list;
  addRecord(list, addCorners(silent), kRed, {.colorWrite = false});
  addRecord(list, addCorners(loud), kGreen);
  const RenderedImage image = render(list);
  const std::vector<uint32_t> hits = hits_->read();
  for (size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(image.pixels[i], loud.contains(i) ? kGreen : kClear) << i;
    EXPECT_EQ(hits[i], (silent.contains(i) ? 1u : 0u) + (loud.contains(i) ? 1u : 0u)) << i;
  }
}

TEST_P(DrawLists, PassTheDepthTestWhereTheDepthIsEqual) {
  const Rectangle first = {2, 1, 9, 6, 0.5f}, same = {0, 0, 4, 4, 0.5f};
  const Rectangle nearer = {5, 0, kWidth, kHeight, 0.25f};
  PassList lists[2];
  addRecord(lists[0], addCorners(first), kRed, {.colorWrite = false});
  for (const Rectangle& rectangle : {same, nearer}) {
    addRecord(lists[1], addCorners(rectangle), kGreen,
              {.depthCompare = DepthCompare::kEqual, .depthWrite = false});
  }
  const RenderedImage image = render(lists);
  for (size_t i = 0; i < kPixels; ++i)
    EXPECT_EQ(image.pixels[i], first.contains(i) && same.contains(i) ? kGreen : kClear) << i;
}

TEST_P(DrawLists, ReadInOneListWhatTheDrawsOfAnEarlierOneHaveWritten) {
  const Rectangle first = {0, 0, 5, 4, 0.75f}, second = {3, 2, 11, 5, 0.25f};
  const Rectangle shown = {0, 0, kWidth, kHeight};
  PassList lists[3];
  const DrawState always = {.depthCompare = DepthCompare::kAlways, .depthWrite = false};
  addRecord(lists[0], addCorners(first), kRed, always);
  addRecord(lists[0], addCorners(second), kRed, always);
  // Draws nothing and must not clear what is there.
  expectOk(PassBuilder(lists[1])
               .dispatch(runtime_test::markVariant(), 1)
               .bind("g_arguments", addWords("marked", 16), 64)
               .finish());
  addDraw(lists[2], runtime_test::fillVertexVariant(), runtime_test::showPixelVariant(),
          addCorners(shown), {}, always);
  const RenderedImage image = render(lists);
  for (size_t i = 0; i < kPixels; ++i) {
    const uint32_t hits = (first.contains(i) ? 1u : 0u) + (second.contains(i) ? 1u : 0u);
    EXPECT_EQ(image.pixels[i].x, static_cast<float>(hits)) << i;
    const float depth = second.contains(i) ? 0.25f : first.contains(i) ? 0.75f : 1.0f;
    EXPECT_NEAR(image.pixels[i].y, depth, 1e-6) << i;
  }
}

TEST_P(DrawLists, GoOnInTheTargetThatEarlierListsDrewInto) {
  const Rectangle nearer = {2, 1, 6, 4, 0.25f}, farther = {4, 3, 9, 7, 0.75f};
  for (const uint32_t samples : {1u, 4u}) {
    if ((device().info().sampleCounts & samples) == 0) continue;
    PassList lists[4];
    // The first list and the third one have nothing to draw.
    addDraw(lists[1], runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(),
            addCorners(nearer), kRed);
    addDraw(lists[3], runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(),
            addCorners(farther), kGreen);
    const RenderedImage image = render(lists, {.samples = samples});
    for (size_t i = 0; i < kPixels; ++i) {
      EXPECT_EQ(image.pixels[i], nearer.contains(i)    ? kRed
                                 : farther.contains(i) ? kGreen
                                                       : kClear)
          << samples << " samples, pixel " << i;
    }
    const RenderedImage cleared = render(std::span<PassList>(), {.samples = samples});
    for (const Float4& pixel : cleared.pixels) EXPECT_EQ(pixel, kClear);
  }
}

TEST_P(DrawLists, MeasureThePassesOfAllListsInOrder) {
  PassList lists[2];
  const BufferId corners = addCorners(Rectangle{0, 0, 3, 3});
  const BufferId marked = addWords("marked", 16);
  for (PassList& list : lists) {
    expectOk(PassBuilder(list)
                 .dispatch(runtime_test::markVariant(), 1)
                 .bind("g_arguments", marked, 64)
                 .finish());
    addRecord(list, corners, kRed);
    gpu().hazards.resolve(list);
  }
  expectOk(device().update(gpu().resources));
  const PassList* const pointers[] = {&lists[0], &lists[1]};
  std::vector<PassTiming> timings;
  ASSERT_TRUE(device().render(pointers, {.width = kWidth, .height = kHeight}, &timings));
  ASSERT_EQ(timings.size(), 4u);
  for (size_t i = 0; i < 4; ++i)
    EXPECT_STREQ(timings[i].name, i % 2 == 0 ? "mark" : "record_pixel") << i;
}

TEST_P(DrawLists, CopyTheDepthBetweenTwoLists) {
  const Rectangle first = {1, 2, 8, 3, 0.25f}, second = {0, 0, 2, 7, 0.125f};
  const Rectangle everywhere = {0, 0, kWidth, kHeight, 0.5f};
  const auto depthAfter = [&](uint32_t list, size_t i) {
    if (list == 1 && second.contains(i)) return second.depth;
    return first.contains(i) ? first.depth : 1.0f;
  };
  for (const uint32_t after : {0u, 1u}) {
    const BufferId copy = addWords("depth copy", kPixels + 3);
    PassList lists[3];
    addRecord(lists[0], addCorners(first), kRed);
    addRecord(lists[1], addCorners(second), kRed);
    PassBuilder pass(lists[2]);
    pass.draw(runtime_test::fillVertexVariant(), runtime_test::showPixelVariant(),
              {.depthCompare = DepthCompare::kAlways}, 6, 1);
    pass.bind("g_depths", copy, kPixels * 4);  // before the recorded ones
    finish(pass, addCorners(everywhere), {});
    const RenderedImage image = render(lists, {.depthCopy = copy, .depthCopyAfter = after});
    const std::vector<float> depths = readFloats(copy);
    for (size_t i = 0; i < kPixels; ++i) {
      // 2^-23 is what mapping depth to -1..1 and back may lose on OpenGL.
      EXPECT_NEAR(depths[i], depthAfter(after, i), 1.2e-7) << after << ", pixel " << i;
      EXPECT_NEAR(image.pixels[i].y, depthAfter(after, i), 1e-4) << after << ", pixel " << i;
    }
    for (size_t i = kPixels; i < depths.size(); ++i) EXPECT_EQ(depths[i], 0.0f) << i;
  }
}

TEST_P(DrawLists, CopyTheDepthThatThePixelKernelsSaw) {
  // A slope: one depth a pixel, from 0.1 at the bottom left to 0.9 at the top right.
  std::vector<Float4> corners = Rectangle{0, 0, kWidth, kHeight}.corners();
  for (Float4& corner : corners) corner.z = 0.5f + 0.3f * corner.x + 0.1f * corner.y;
  const BufferId copy = addWords("depth copy", kPixels);
  PassList list;
  addRecord(list, addCorners(corners), kRed);
  render(list, {.depthCopy = copy});
  const std::vector<float> copied = readFloats(copy);
  const std::vector<uint32_t> seen = depths_->read();
  for (size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(copied[i], std::bit_cast<float>(seen[i])) << i;
    const size_t column = i % kWidth, row = i / kWidth;
    const double x = 2 * (static_cast<double>(column) + 0.5) / kWidth - 1;
    const double y = 1 - 2 * (static_cast<double>(row) + 0.5) / kHeight;
    EXPECT_NEAR(copied[i], 0.5 + 0.3 * x + 0.1 * y, 1e-5) << i;
  }
}

TEST_P(DrawLists, DrawIntoAnAreaAndCopyItsDepth) {
  constexpr PixelArea kArea = {3, 2, 6, 4};
  const BufferId copy = addWords("depth copy", kPixels);
  // The left half of the area.
  std::vector<Float4> corners = Rectangle{0, 0, kWidth / 2, kHeight, 0.25f}.corners();
  PassList list;
  addRecord(list, addCorners(corners), kRed);
  const RenderedImage image = render(list, {.depthCopy = copy, .area = kArea});
  const std::vector<float> depths = readFloats(copy);
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      const uint32_t u = x - kArea.x, v = y - kArea.y;  // beyond it to the left and above, too
      const bool inside = u < kArea.width && v < kArea.height;
      const bool drawn = inside && u < kArea.width / 2;
      EXPECT_EQ(image.pixels[y * kWidth + x], drawn ? kRed : kClear) << x << " " << y;
      if (inside) {
        EXPECT_NEAR(depths[v * kArea.width + u], drawn ? 0.25 : 1, 1.2e-7) << u << " " << v;
      }
    }
  }
  for (size_t i = size_t{kArea.width} * kArea.height; i < depths.size(); ++i)
    EXPECT_EQ(depths[i], 0.0f) << i;
}

TEST_P(DrawLists, RefuseAnAreaThatLeavesTheTarget) {
  PassList list;
  for (const PixelArea area : {PixelArea{1, 0, 4, 4}, PixelArea{0, 1, 4, 4},
                               PixelArea{0xffffffffu, 0, 4, 4}, PixelArea{0, 0, 1, 5}})
    expectError(tryRender(list, {.width = 4, .height = 4, .area = area}), "area");
  EXPECT_TRUE(device().render(list, {.width = 4, .height = 4, .area = {3, 3, 1, 1}}));
}

TEST_P(DrawLists, RefuseACopyOfTheDepthThatCannotBe) {
  const BufferId fits = addWords("fits", 16);
  const BufferId small = addWords("small", 15);
  const BufferId never = static_cast<BufferId>(gpu().resources.end() + 1000);
  PassList list;
  const RenderTargetDef good = {.width = 4, .height = 4, .depthCopy = fits};
  RenderTargetDef target = good;
  target.depthCopy = small;
  expectError(tryRender(list, target), "60 bytes");
  target.depthCopy = never;
  expectError(tryRender(list, target), "update()");
  target = good;
  target.depthCopyAfter = 1;
  expectError(tryRender(list, target), "depthCopyAfter");
  if (device().info().maxSamples > 1) {
    target = good;
    target.samples = device().info().maxSamples;
    expectError(tryRender(list, target), "samples");
  }
  EXPECT_TRUE(device().render(list, good));
}

}  // namespace
}  // namespace pelage::test
