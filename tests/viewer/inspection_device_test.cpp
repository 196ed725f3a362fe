// Figures that the viewer measures on the GPU match the positions of the hair.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "device.h"
#include "sample/code.h"
#include "stage/stage.h"
#include "stage/stage_settings.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "viewer/window_apis.h"
#include "viewer_kernels/code.h"

namespace {

using pelage::Float3;
using pelage::Float4;
using pelage::test::required;
using viewer::InspectedValue;
using viewer::InspectionFigures;

constexpr uint32_t kPixels = 64;

class Inspection : public testing::TestWithParam<pelage::Api> {
 protected:
  void SetUp() override {
    auto device = sample::createDevice({.api = GetParam(), .validation = true});
    if (!device) device = sample::createDevice({.api = GetParam()});
    if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << device.error().message;
    device_ = *std::move(device);
    device_->addCode(sample::allCode());
    device_->addCode(viewer_kernels::allCode());
    stage_.setDevice({device_->info().tier, device_->info().maxBufferBytes});
    stage_.look.shadow = pelage::HairShadow::kNone;
    stage_.look.transparency = pelage::Transparency::kAlphaTest;
    stage_.look.strandShare = 0.02f;
    stage_.look.detailPixels = 0;
    stage_.clock.fixed = true;
    required(
        stage_.show({.kind = viewer::StageKind::kHead, .preset = sample::GroomPreset::kMohawk}));
    stage_.frameAll(1);
    // Hair stays in its bind pose.
    stage_.clock.playing = false;
    ASSERT_NO_FATAL_FAILURE(draw());
  }
  void TearDown() override { EXPECT_EQ(device_ ? device_->messageCount() : 0u, 0u); }

  void draw() {
    auto frame = required(stage_.makeFrame(1.0 / 60, kPixels, kPixels));
    std::vector<pelage::RenderTargetDef> targets;
    for (const viewer::CanvasView& view : stage_.views())
      targets.push_back({.width = kPixels, .height = kPixels, .depthCopy = view.depthCopy});
    const auto images = required(device_->render(*frame, targets));
    picture_ = images->back();
    required(stage_.measure([&](pelage::BufferId buffer) { return device_->read(buffer); }));
  }
  const pelage::HairObject& hair() { return stage_.scene().hair(stage_.hairs()[0]); }
  std::vector<Float4> positions() {
    const auto bytes = device_->read(hair().buffers().positions);
    EXPECT_TRUE(bytes);
    std::vector<Float4> values(uint64_t{hair().guideCount()} * hair().verticesPerStrand());
    std::memcpy(values.data(), bytes->data(), values.size() * sizeof(Float4));
    return values;
  }
  InspectionFigures figuresOf(InspectedValue value) {
    stage_.inspection.value = value;
    draw();
    return stage_.inspected();
  }

  /// Returns the counters of the transparency method.
  pelage::TransparencyCounters counters() {
    const auto read = [&](pelage::BufferId buffer) { return device_->read(buffer); };
    const auto statistics = stage_.statistics(read);
    EXPECT_TRUE(statistics && statistics->transparency);
    return statistics && statistics->transparency ? *statistics->transparency
                                                  : pelage::TransparencyCounters{};
  }
  /// Counts the pixels of the last view by their strongest channel.
  std::array<size_t, 3> pixelsByChannel() const {
    std::array<size_t, 3> pixels = {};
    for (const Float4& p : picture_.pixels) {
      if (!(p.w > 0)) continue;
      ++pixels[p.x > p.y && p.x > p.z ? 0 : p.y > p.z ? 1 : 2];
    }
    return pixels;
  }

  pelage::RenderedImage picture_;  // of the last view
  std::unique_ptr<pelage::HeadlessDevice> device_;
  viewer::Stage stage_;
};

// A new rest pose is a tenth longer than the rest lengths that the viewer knows.
TEST_P(Inspection, StretchIsThatOfTheEdges) {
  const uint64_t vertices = uint64_t{hair().guideCount()} * hair().verticesPerStrand();
  const InspectionFigures rest = figuresOf(InspectedValue::kStretch);
  ASSERT_TRUE(rest.known);
  EXPECT_TRUE(rest.largest < 1e-4f) << rest.largest;
  EXPECT_EQ(rest.measured, vertices);
  EXPECT_EQ(rest.beyond, 0u);
  EXPECT_EQ(rest.notFinite, 0u);

  std::vector<Float4> longer = positions();
  for (size_t i = 0; i < longer.size(); ++i) {
    const Float4& root = longer[i - i % hair().verticesPerStrand()];
    Float4& p = longer[i];
    p = {root.x + 1.1f * (p.x - root.x), root.y + 1.1f * (p.y - root.y),
         root.z + 1.1f * (p.z - root.z), p.w};
  }
  pelage::HairObject& object = stage_.scene().hair(stage_.hairs()[0]);
  required(object.setRestPose(longer));
  stage_.clock.playing = true;
  stage_.inspection.value = InspectedValue::kNone;
  draw();
  const InspectionFigures stretched = figuresOf(InspectedValue::kStretch);
  EXPECT_NEAR(stretched.largest, 0.1f, 2e-3f);
  EXPECT_TRUE(stretched.beyond > vertices / 2) << stretched.beyond;
}

// A ball surrounds a vertex that has not moved yet.
TEST_P(Inspection, PenetrationIsTheDepthInTheBall) {
  const uint32_t count = hair().verticesPerStrand();
  const std::vector<Float4> at = positions();
  const Float4& middle = at[count / 2];
  stage_.ball = {true, {middle.x, middle.y + 0.01f, middle.z}, 0.04f};
  stage_.inspection.penetrationRange = 0.02f;
  const InspectionFigures figures = figuresOf(InspectedValue::kPenetration);
  ASSERT_TRUE(figures.known);
  const auto strands = static_cast<uint32_t>(
      std::ceil(static_cast<double>(hair().strandCount()) * static_cast<double>(0.02f)));
  ASSERT_LE(strands, hair().guideCount());
  EXPECT_EQ(figures.measured, uint64_t{strands} * count);
  double deepest = 0;
  int64_t beyond = 0;
  for (size_t i = 0; i < size_t{strands} * count; ++i) {
    if (i % count < 2) continue;
    const Float3& c = stage_.ball.center;
    const double distance = std::hypot(static_cast<double>(at[i].x) - static_cast<double>(c.x),
                                       static_cast<double>(at[i].y) - static_cast<double>(c.y),
                                       static_cast<double>(at[i].z) - static_cast<double>(c.z));
    deepest = std::max(deepest, 0.04 - distance);
    beyond += 0.04 - distance > 0.02 ? 1 : 0;
  }
  EXPECT_GE(deepest, 0.03);
  EXPECT_NEAR(static_cast<double>(figures.largest), deepest, 1e-5);
  EXPECT_LE(std::abs(static_cast<int64_t>(figures.beyond) - beyond), 2);
}

TEST_P(Inspection, FragmentsAreCountedTheSameInEveryFrame) {
  const InspectionFigures first = figuresOf(InspectedValue::kOverdraw);
  ASSERT_TRUE(first.known);
  EXPECT_GT(first.pixels, 10u);
  EXPECT_LE(first.pixels, uint64_t{kPixels} * kPixels);
  EXPECT_GE(first.fragments, first.pixels);
  EXPECT_GE(static_cast<double>(first.largest) * static_cast<double>(first.pixels),
            static_cast<double>(first.fragments));
  (void)figuresOf(InspectedValue::kNone);
  const InspectionFigures again = figuresOf(InspectedValue::kOverdraw);
  EXPECT_EQ(again.fragments, first.fragments);
  EXPECT_EQ(again.pixels, first.pixels);
  EXPECT_EQ(again.largest, first.largest);
  // There are ten follow hairs per guide.
  stage_.look.strandShare = 0.09f;
  (void)figuresOf(InspectedValue::kNone);
  const uint64_t guides = figuresOf(InspectedValue::kOverdraw).fragments;
  stage_.look.strandShare = 1;
  (void)figuresOf(InspectedValue::kNone);
  EXPECT_GT(figuresOf(InspectedValue::kOverdraw).fragments, 4 * guides);
}

TEST_P(Inspection, TilesHaveWhatTheMethodCounts) {
  using pelage::Transparency;
  EXPECT_FALSE(figuresOf(InspectedValue::kTiles).known);  // this method has no tiles
  for (const Transparency method : {Transparency::kWindowed, Transparency::kTiles}) {
    stage_.look.transparency = method;
    (void)figuresOf(InspectedValue::kNone);
    const InspectionFigures figures = figuresOf(InspectedValue::kTiles);
    ASSERT_TRUE(figures.known);
    const pelage::TransparencyCounters counted = counters();
    EXPECT_GT(counted.fragments, 100u);
    EXPECT_EQ(figures.fragments, counted.fragments);
    EXPECT_EQ(figures.tiles, counted.tiles);
    EXPECT_EQ(figures.tilesWithoutRoom, 0u);
    EXPECT_GE(static_cast<double>(figures.largest) * static_cast<double>(figures.tiles),
              static_cast<double>(figures.fragments));
    const std::array<size_t, 3> pixels = pixelsByChannel();
    EXPECT_EQ(pixels[0] + pixels[1] + pixels[2], 64 * figures.tiles);
  }
  (void)figuresOf(InspectedValue::kNone);
  pelage::TransparencySettings scarce = stage_.transparency.settings();
  scarce.nodeCount = counters().fragments / 2;
  stage_.transparency.set(scarce);
  const InspectionFigures figures = figuresOf(InspectedValue::kTiles);
  EXPECT_GT(figures.tilesWithoutRoom, 0u);
  EXPECT_GT(figures.tiles, figures.tilesWithoutRoom);
}

// Strands are blue if they are left out, green if they are drawn, red if their guide is not
// simulated.
TEST_P(Inspection, LevelOfDetailHasAColorForEachKind) {
  stage_.look.strandShare = 1;
  (void)figuresOf(InspectedValue::kDetail);
  std::array<size_t, 3> pixels = pixelsByChannel();
  EXPECT_EQ(pixels[0] + pixels[2], 0u);
  EXPECT_GT(pixels[1], 100u);
  pelage::SceneSettings settings = settingsOf(stage_, 0);
  settings.object.simulatedShare = 0.5f;
  settings.object.drawnShare =
      static_cast<float>(hair().guideCount()) / static_cast<float>(hair().strandCount());
  required(apply(settings, 0, stage_));
  const InspectionFigures figures = figuresOf(InspectedValue::kDetail);
  EXPECT_EQ(figures.simulated, (hair().guideCount() + 1) / 2);
  pixels = pixelsByChannel();
  EXPECT_GT(pixels[0], 20u);
  EXPECT_GT(pixels[1], 20u);
  EXPECT_GT(pixels[2], 20u);
}

TEST_P(Inspection, TheSurfaceOfAnSdfHasTheColorOfTheSettings) {
  required(stage_.show({.kind = viewer::StageKind::kHead,
                        .preset = sample::GroomPreset::kMohawk,
                        .headCollider = sample::HeadCollider::kMesh}));
  stage_.inspection.value = InspectedValue::kSdfSurface;
  stage_.clock.playing = true;
  draw();  // a simulation makes the grid
  // The hair is red.
  for (const size_t channel : {size_t{1}, size_t{2}}) {
    pelage::SceneSettings settings = settingsOf(stage_, 0);
    settings.colliderLook.color = channel == 1 ? Float3{0, 0.8f, 0} : Float3{0, 0, 0.8f};
    required(apply(settings, 0, stage_));
    draw();
    const std::array<size_t, 3> pixels = pixelsByChannel();
    EXPECT_GT(pixels[channel], 300u);
    EXPECT_EQ(pixels[3 - channel], 0u);
  }
}

TEST_P(Inspection, TheGroundIsBelowAllHair) {
  stage_.inspection.value = InspectedValue::kNone;
  const auto drawnRows = [&] {
    draw();
    std::array<size_t, 4> quarters = {};
    for (size_t i = 0; i < picture_.pixels.size(); ++i)
      quarters[4 * i / picture_.pixels.size()] += picture_.pixels[i].w > 0 ? 1 : 0;
    return quarters;
  };
  const std::array<size_t, 4> before = drawnRows();
  stage_.look.showsGround = true;
  const std::array<size_t, 4> after = drawnRows();
  EXPECT_GT(after[3], before[3] + 50);
  EXPECT_EQ(after[0], before[0]);
}

// A view that is no longer shown frees its buffers.
TEST_P(Inspection, LeavesNoBuffersBehind) {
  const uint64_t bytes = stage_.scene().resources().totalBytes();
  for (const auto value :
       {InspectedValue::kStretch, InspectedValue::kOverdraw, InspectedValue::kGuides,
        InspectedValue::kSdfSlice, InspectedValue::kDetail}) {
    (void)figuresOf(value);
    (void)figuresOf(InspectedValue::kNone);
    EXPECT_EQ(stage_.scene().resources().totalBytes(), bytes) << nameOf(value);
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, Inspection, testing::ValuesIn(pelage::test::kWindowApis),
                         pelage::test::apiTestName);

}  // namespace
