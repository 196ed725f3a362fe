// Parts of the viewer that need no device: keys of colors, statistics, history of passes, folders.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "capture/pass_times.h"
#include "stage/files.h"
#include "stage/inspection_look.h"
#include "stage/stage.h"
#include "stage/stage_settings.h"
#include "stage/statistics.h"
#include "stage/strand_inspection.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;
using viewer::InspectedValue;
using viewer::InspectionFigures;
using viewer::InspectionLook;

constexpr pelage::Transparency kWindowed = pelage::Transparency::kWindowed;

bool isEqual(const pelage::Float3& a, const pelage::Float3& b) {
  constexpr float kRounding = 1e-6f;
  return std::abs(a.x - b.x) < kRounding && std::abs(a.y - b.y) < kRounding &&
         std::abs(a.z - b.z) < kRounding;
}

TEST(ColorRamp, HasItsColorsAtEvenStepsAndTheEndsBeyond) {
  const viewer::ColorRamp& ramp = viewer::kSignedRamp;
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, -2), ramp.colors[0]));
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, 0), ramp.colors[2]));
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, 2), ramp.colors[4]));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, -kInfinity), ramp.colors[0]));
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, kInfinity), ramp.colors[4]));
  EXPECT_TRUE(isEqual(colorAt(ramp, -2, 2, std::nanf("")), ramp.colors[0]));
  // The picture does not change colors up to 0.6, so that the key has the same colors.
  for (const viewer::ColorRamp* each :
       {&viewer::kSignedRamp, &viewer::kDepthRamp, &viewer::kCountRamp, &viewer::kKindRamp})
    for (const pelage::Float3& c : each->colors)
      EXPECT_TRUE(c.x <= 0.6f && c.y <= 0.6f && c.z <= 0.6f);
}

TEST(InspectionLook, GoesThroughAllValuesAndBack) {
  InspectionLook look;
  for (int i = 0; i < viewer::kInspectedValues; ++i) look.show(false);
  EXPECT_EQ(look.value, InspectedValue::kNone);
  look.show(true);
  EXPECT_EQ(look.value, InspectedValue::kDetail);
  look.show(false);
  EXPECT_EQ(look.value, InspectedValue::kNone);
}

// A key names its ends with the unit, and has figures if they are known.
TEST(InspectionLook, HasAKeyWithUnitsWhereThereAreColors) {
  InspectionLook look;
  for (int i = 0; i < viewer::kInspectedValues; ++i, look.show(false)) {
    const viewer::InspectionKey key = inspectionKey(look, {}, kWindowed);
    const bool plain =
        look.value == InspectedValue::kNone || look.value == InspectedValue::kSdfSurface;
    EXPECT_EQ(key.ramp == nullptr, plain) << nameOf(look.value);
    EXPECT_EQ(key.title.empty(), plain) << nameOf(look.value);
    EXPECT_EQ(key.high.empty(), plain) << nameOf(look.value);
    EXPECT_LT(lowOf(look), highOf(look)) << nameOf(look.value);
  }
  InspectionFigures figures;
  figures.known = true;
  figures.largest = 0.0034f;
  figures.beyond = 5;
  figures.measured = 70;
  look.value = InspectedValue::kPenetration;
  const viewer::InspectionKey key = inspectionKey(look, figures, kWindowed);
  EXPECT_EQ(key.high, "2 mm");
  ASSERT_EQ(key.lines.size(), 2u);
  EXPECT_EQ(key.lines[0], "deepest 3.4 mm");
  EXPECT_EQ(key.lines[1], "5 of 70 vertices beyond 2 mm");
  look.value = InspectedValue::kStretch;
  EXPECT_EQ(inspectionKey(look, figures, kWindowed).lines[0], "largest 0.34 %");
}

// A method without tiles has no colors, and the key says so.
TEST(InspectionLook, SaysWhatTheMethodHasInItsTiles) {
  InspectionLook look;
  look.value = InspectedValue::kTiles;
  InspectionFigures figures;
  figures.known = true;
  figures.largest = 900;
  figures.fragments = 1000;
  figures.tiles = 12;
  figures.tilesWithoutRoom = 2;
  const viewer::InspectionKey tiles = inspectionKey(look, figures, pelage::Transparency::kTiles);
  EXPECT_EQ(tiles.title, "Fragments a tile of 8 x 8 pixels");
  ASSERT_EQ(tiles.lines.size(), 3u);
  EXPECT_EQ(tiles.lines[0], "fullest tile 900, mean 100");
  EXPECT_EQ(tiles.lines[2], "2 of them empty for lack of room (striped)");
  EXPECT_EQ(inspectionKey(look, figures, kWindowed).title, "Fragments a tile of 8 x 8 pixels");
  const viewer::InspectionKey none = inspectionKey(look, {}, pelage::Transparency::kHybrid8);
  EXPECT_EQ(none.ramp, nullptr);
  ASSERT_EQ(none.lines.size(), 1u);
  EXPECT_NE(none.lines[0].find("choose windowed or tiles"), std::string::npos);
}

TEST(Statistics, SayWhatTheCountersSayAndLeaveOutTheRest) {
  viewer::HairStatistics hair;
  hair.guides = 10;
  hair.bytes = {3u << 20, 1u << 20};
  EXPECT_EQ(linesOf(hair).size(), 2u);
  EXPECT_EQ(linesOf(hair)[1], "4.0 MiB, 1.0 MiB of them shared");
  hair.simulation = {7, 2};
  hair.contacts = {5, 3};
  const std::vector<std::string> lines = linesOf(hair);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2], "7 guides awake, 2 second passes");
  EXPECT_EQ(lines[3], "5 contacts, 3 strands again");
}

// Without a device there are sizes, but no counters.
TEST(Statistics, OfAStageListItsHairAndColliders) {
  viewer::Stage stage;
  ASSERT_TRUE(stage.show({.kind = viewer::StageKind::kHead,
                          .preset = sample::GroomPreset::kMohawk,
                          .headCollider = sample::HeadCollider::kMesh}));
  size_t reads = 0;
  const auto statistics =
      required(stage.statistics([&](pelage::BufferId) -> pelage::Result<std::vector<std::byte>> {
        ++reads;
        return std::vector<std::byte>(256);
      }));
  ASSERT_EQ(statistics->hairs.size(), 1u);
  EXPECT_GT(statistics->hairs[0].bytes.own, 0u);
  EXPECT_EQ(statistics->colliders.size(), 1u);
  EXPECT_FALSE(statistics->transparency);
  EXPECT_LE(reads, 3u);
}

// The figures of level of detail follow from the settings of an object.
TEST(StrandDetail, CountsWhatIsDrawnAndSimulated) {
  viewer::Stage stage;
  ASSERT_TRUE(
      stage.show({.kind = viewer::StageKind::kHead, .preset = sample::GroomPreset::kMohawk}));
  pelage::SceneSettings settings = settingsOf(stage, 0);
  settings.object.simulatedShare = 0.25f;
  ASSERT_TRUE(apply(settings, 0, stage));
  pelage::HairObject& hair = stage.scene().hair(stage.hairs()[0]);
  hair.drawnShare = 0.5f;
  InspectionFigures figures;
  addDetail(hair, figures);
  EXPECT_TRUE(figures.known);
  EXPECT_EQ(figures.strands, hair.strandCount());
  EXPECT_EQ(figures.drawn, (hair.strandCount() + 1) / 2);
  EXPECT_EQ(figures.simulated, (hair.guideCount() + 3) / 4);
  // The last eighth of the drawn strands fades; its widths add up to half of it.
  EXPECT_NEAR(static_cast<double>(figures.fading), hair.strandCount() / 16.0, 1);
  EXPECT_NEAR(figures.widening, 2 / (1 - 1.0f / 16), 1e-3f);
  InspectionLook look;
  look.value = InspectedValue::kDetail;
  const viewer::InspectionKey key = inspectionKey(look, figures, kWindowed);
  ASSERT_EQ(key.lines.size(), 3u);
  EXPECT_EQ(key.lines[1], "2.13 times as wide as without");
  hair.simulated = false;
  EXPECT_EQ(viewer::simulatedGuides(hair), 0u);
}

TEST(PassHistory, KeepsTheTimesOfEachPassAsLongAsThoseOfAll) {
  viewer::PassHistory history;
  for (int frame = 0; frame < 130; ++frame) {
    std::vector<pelage::PassTiming> timings = {{"a", 1.0}, {"a", 2.0}};
    if (frame % 2 == 1) timings.push_back({"b", 4.0});
    history.add(timings);
  }
  ASSERT_EQ(history.totals().size(), viewer::PassHistory::kFrames);
  for (const auto& pass : history.passes()) {
    ASSERT_EQ(pass.frames.size(), viewer::PassHistory::kFrames) << pass.name;
    EXPECT_EQ(pass.frames.back(), pass.name == "a" ? 3.0f : 4.0f);
    EXPECT_EQ(pass.frames[pass.frames.size() - 2], pass.name == "a" ? 3.0f : 0.0f);
  }
}

TEST(Folder, ListsFoldersThenFilesThatCanBeOpened) {
  const TestFolder folder;
  std::filesystem::create_directory(folder / "z");
  for (const char* name : {"b.tfx", "a.TFX", "words.txt", ".hidden.tfx", "s.json"})
    std::ofstream(folder / name) << "x";
  const auto list = required(viewer::listFolder(folder.path()));
  EXPECT_EQ(list->entries,
            (std::vector<viewer::FolderEntry>{
                {"z", true}, {"a.TFX", false}, {"b.tfx", false}, {"s.json", false}}));
  expectError(viewer::listFolder(folder / "none"), "none");
}

// Two sides have two solvers, each with settings of its own. Going back to one side frees all of
// the other.
TEST(Comparison, ShowsTheSameHairTwiceAndGoes) {
  viewer::Stage stage;
  ASSERT_TRUE(
      stage.show({.kind = viewer::StageKind::kHead, .preset = sample::GroomPreset::kMohawk}));
  const uint64_t bytes = stage.scene().resources().totalBytes();
  const pelage::HairId left = stage.hairs()[0];
  stage.scene().hair(left).material.fiberRadius = 90e-6f;
  ASSERT_TRUE(stage.compare(pelage::Solver::kClassic));
  ASSERT_EQ(stage.sides(), 2u);
  EXPECT_EQ(stage.scene().hairCount(), 4u);  // brows are hair, too
  EXPECT_EQ(stage.side(), 0u);
  EXPECT_EQ(stage.hairs()[0], left);
  EXPECT_EQ(stage.solverOf(0), pelage::Solver::kExact);
  stage.chooseSide(1);
  EXPECT_EQ(stage.solverOf(1), pelage::Solver::kClassic);
  const pelage::HairObject& right = stage.scene().hair(stage.hairs()[0]);
  EXPECT_EQ(right.settings.solver, pelage::Solver::kClassic);
  EXPECT_EQ(right.material.fiberRadius, 90e-6f);
  ASSERT_TRUE(stage.compare(std::nullopt));
  EXPECT_EQ(stage.sides(), 1u);
  EXPECT_EQ(stage.side(), 0u);
  EXPECT_EQ(stage.hairs()[0], left);
  EXPECT_EQ(stage.scene().hairCount(), 2u);
  EXPECT_EQ(stage.scene().resources().totalBytes(), bytes);
}

}  // namespace
