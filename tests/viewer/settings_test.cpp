// Settings of a stage: edits reach the scene, and can be read back.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "interface/settings_panel.h"
#include "pelage/settings/settings_file.h"
#include "stage/environment.h"
#include "stage/stage_settings.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using pelage::SceneSettings;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;
using viewer::Stage;

class StageSettings : public testing::Test {
 protected:
  void SetUp() override {
    required(stage_.show({.kind = viewer::StageKind::kHead}));
    ASSERT_EQ(stage_.shown(), 1u);
    ASSERT_FALSE(stage_.hairs().empty());
  }
  /// Returns another value within the range.
  static pelage::ParameterValue otherThan(const pelage::Parameter& parameter,
                                          const pelage::ParameterValue& value) {
    const auto within = [&](double x) {
      const auto between = static_cast<float>((parameter.sliderLow + 3 * parameter.sliderHigh) / 4);
      return static_cast<double>(between) == x
                 ? static_cast<float>((parameter.sliderLow + parameter.sliderHigh) / 2)
                 : between;
    };
    if (const bool* b = std::get_if<bool>(&value)) return !*b;
    if (const uint64_t* n = std::get_if<uint64_t>(&value)) {
      if (parameter.type == pelage::ParameterType::kChoice)
        return (*n + 1) % parameter.choices.size();
      if (parameter.isPowerOfTwo)
        return static_cast<double>(*n * 2) > parameter.high ? *n / 2 : *n * 2;
      return *n == static_cast<uint64_t>(parameter.low) ? *n + 1 : *n - 1;
    }
    if (const float* x = std::get_if<float>(&value)) return within(*x);
    if (const auto* v = std::get_if<pelage::Float3>(&value)) {
      const float x = within(v->x);
      return pelage::Float3{x, v->y, v->z};
    }
    auto curve = std::get<pelage::ParameterCurve>(value);
    curve[3] = curve[3] == 0.5f ? 0.25f : 0.5f;
    return curve;
  }

  Stage stage_;
};

TEST_F(StageSettings, AreWhatWasGiven) {
  size_t moved = 0;
  const auto sections = pelage::settingsSections();
  for (size_t s = 0; s < sections.size(); ++s) {
    for (const pelage::Parameter& parameter : sections[s].parameters) {
      SceneSettings settings = settingsOf(stage_, 0);
      // An object draws no more strands than it has.
      if (parameter.path == "drawnStrands") continue;
      if (sections[s].key == "collider" && stage_.colliders().empty()) continue;
      // A share of the guides needs level of detail.
      if (parameter.path == "levelOfDetail") settings.object.simulatedShare = 1;
      const auto value = otherThan(parameter, sections[s].get(settings, parameter));
      ASSERT_TRUE(check(parameter, value)) << parameter.path;
      sections[s].set(settings, parameter, value);
      if (parameter.path == "innerConeAngle") settings.lights[0].outerConeAngle = 1.5f;
      if (!validate(settings)) continue;  // the two values contradict each other
      required(apply(settings, 0, stage_));
      const SceneSettings now = settingsOf(stage_, 0);
      EXPECT_TRUE(haveSameBits(sections[s].get(now, parameter), value))
          << sections[s].key << '.' << parameter.path;
      ++moved;
    }
  }
  EXPECT_GT(moved, 60u);
}

TEST_F(StageSettings, OfDetailFollowTheSizeInThePicture) {
  const auto shareAt = [&](uint32_t height) {
    EXPECT_EQ(required(stage_.makeFrame(0, height, height))->viewCount(), 1u);
    return stage_.scene().hair(stage_.hairs()[0]).drawnShare;
  };
  EXPECT_EQ(shareAt(1000), 1.0f);
  const float small = shareAt(100);
  EXPECT_LT(small, 0.9f);
  EXPECT_NEAR(shareAt(50), small / 2, 1e-3);
  stage_.look.strandShare = 0.1f;
  EXPECT_EQ(shareAt(100), 0.1f);
  // The settings are those near by.
  EXPECT_EQ(settingsOf(stage_, 0).object.drawnShare, 0.1f);
  stage_.look = {.detailPixels = 0};
  EXPECT_EQ(shareAt(50), 1.0f);
}

TEST_F(StageSettings, HaveTheEnvironmentThatIsChosen) {
  const pelage::Float3 own = settingsOf(stage_, 0).lights[0].environment.l1m1;
  EXPECT_STREQ(viewer::environmentName(stage_), viewer::kOwnEnvironment);
  for (const viewer::NamedEnvironment& one : viewer::environments()) {
    setEnvironment(one.light, stage_);
    EXPECT_STREQ(viewer::environmentName(stage_), one.name);
    const pelage::EnvironmentLight e = settingsOf(stage_, 0).lights[0].environment;
    EXPECT_EQ(e.l1m1, one.light.l1m1);
    // No side is darker than black.
    EXPECT_GE(0.282095f * e.l00.x, 0.488603f * std::hypot(e.l1m1.x, e.l10.x, e.l11.x)) << one.name;
  }
  setEnvironment(stage_.ownEnvironment(), stage_);
  EXPECT_EQ(settingsOf(stage_, 0).lights[0].environment.l1m1, own);
}

TEST_F(StageSettings, OfMakingMakeTheHairAgainWithItsLook) {
  SceneSettings settings = settingsOf(stage_, 0);
  const pelage::HairId before = stage_.hairs()[0];
  settings.material.fiberRadius = 90e-6f;
  ASSERT_TRUE(apply(settings, 0, stage_));
  EXPECT_EQ(stage_.hairs()[0], before);
  settings.follow.countPerGuide = 3;
  ASSERT_TRUE(apply(settings, 0, stage_));
  EXPECT_NE(stage_.hairs()[0], before);
  EXPECT_FALSE(stage_.scene().isValid(before));
  const pelage::HairObject& hair = stage_.scene().hair(stage_.hairs()[0]);
  EXPECT_EQ(hair.followCount(), 3 * hair.guideCount());
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), settings));

  settings.object.simulatedShare = 0.5f;
  ASSERT_TRUE(apply(settings, 0, stage_));
  EXPECT_TRUE(settingsOf(stage_, 0).creation.levelOfDetail);
  const auto frame = stage_.makeFrame(0.01, 64, 64);
  EXPECT_TRUE(frame) << frame.error().message;
}

TEST_F(StageSettings, ThatTheSceneRefusesGoBackToTheLastGoodOnes) {
  viewer::GoodSettings good;
  EXPECT_FALSE(good.restore(stage_));
  good.keep(stage_);
  EXPECT_FALSE(good.restore(stage_));
  const SceneSettings first = settingsOf(stage_, 0);
  SceneSettings refused = first;
  refused.transparency.method = pelage::Transparency::kWindowed;
  refused.transparency.maxBytes = 1;
  ASSERT_TRUE(apply(refused, 0, stage_));
  EXPECT_FALSE(stage_.makeFrame(0.01, 64, 64));
  EXPECT_TRUE(good.restore(stage_));
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), first));
  const auto frame = stage_.makeFrame(0.01, 64, 64);
  EXPECT_TRUE(frame) << frame.error().message;
}

// A device or a method may not support a number of samples.
TEST_F(StageSettings, OfTheTargetAreRefusedWithASentenceAndGoBack) {
  pelage::DeviceInfo device;
  device.name = "a device";
  device.sampleCounts = 1 | 4;
  EXPECT_TRUE(viewer::checkSamples(device, 4));
  const auto refused = viewer::checkSamples(device, 8);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "view.samples is 8, but a device has targets of 1, 4 samples a pixel");
  SceneSettings settings = settingsOf(stage_, 0);
  settings.view = {.samples = 4, .reversedDepth = true, .seed = 7};
  ASSERT_TRUE(apply(settings, 0, stage_));
  auto frame = stage_.makeFrame(0.01, 64, 64);
  EXPECT_TRUE(frame) << frame.error().message;
  settings.transparency.method = pelage::Transparency::kTiles;
  ASSERT_TRUE(apply(settings, 0, stage_));
  frame = stage_.makeFrame(0.01, 64, 64);
  expectError(frame, "view.samples is 4");
  EXPECT_TRUE(stage_.resetTarget());
  EXPECT_FALSE(stage_.resetTarget());
  EXPECT_TRUE(stage_.makeFrame(0.01, 64, 64));
}

// Files and settings came in one frame: no good settings were kept for the new hair.
TEST_F(StageSettings, ThatNoFrameRanWithGiveWayToTheDefaults) {
  viewer::GoodSettings good;
  good.keep(stage_);
  ASSERT_TRUE(stage_.show(stage_.source()));
  SceneSettings refused = settingsOf(stage_, 0);
  refused.lights[0].outerConeAngle = 0.5f;  // without a position
  ASSERT_TRUE(apply(refused, 0, stage_));
  ASSERT_FALSE(stage_.makeFrame(0.01, 64, 64));
  EXPECT_FALSE(good.restore(stage_));
  EXPECT_TRUE(viewer::applyDefaultLook(stage_));
  const auto frame = stage_.makeFrame(0.01, 64, 64);
  EXPECT_TRUE(frame) << frame.error().message;
  EXPECT_FALSE(viewer::applyDefaultLook(stage_));
}

// The new side takes refused settings from the other one before a frame has run with them.
TEST_F(StageSettings, ThatBothSidesHaveGoBackOnBoth) {
  viewer::GoodSettings good;
  good.keep(stage_);
  SceneSettings refused = settingsOf(stage_, 0);
  refused.lights[0].outerConeAngle = 0.5f;  // without a position
  ASSERT_TRUE(apply(refused, 0, stage_));
  ASSERT_TRUE(stage_.compare(pelage::Solver::kExact));
  EXPECT_TRUE(good.restore(stage_));
  ASSERT_FALSE(stage_.makeFrame(0.01, 64, 64));
  EXPECT_FALSE(good.restore(stage_));
  EXPECT_TRUE(viewer::applyDefaultLook(stage_));
  const auto frame = stage_.makeFrame(0.01, 64, 64);
  EXPECT_TRUE(frame) << frame.error().message;
}

// A cap of memory that was enough may be too small for a larger window.
TEST_F(StageSettings, OfMemoryAreThoseOfTheDeviceAgainWhereTheyAreTooSmall) {
  stage_.setDevice({});
  EXPECT_FALSE(stage_.transparency.resetMemory());
  SceneSettings settings = settingsOf(stage_, 0);
  settings.transparency.method = pelage::Transparency::kShortCut;
  settings.transparency.maxBytes = 200 << 10;
  ASSERT_TRUE(apply(settings, 0, stage_));
  ASSERT_TRUE(stage_.makeFrame(0.01, 64, 64));
  ASSERT_FALSE(stage_.makeFrame(0.01, 640, 480));
  EXPECT_TRUE(stage_.transparency.resetMemory());
  EXPECT_TRUE(stage_.makeFrame(0.01, 640, 480));
}

// A way back does not undo what one before it has changed.
TEST_F(StageSettings, GoBackOnEachWayOnce) {
  stage_.setDevice({});
  SceneSettings settings = settingsOf(stage_, 0);
  settings.view.samples = 4;
  settings.transparency.method = pelage::Transparency::kShortCut;
  settings.transparency.maxBytes = 200 << 10;
  ASSERT_TRUE(apply(settings, 0, stage_));
  ASSERT_TRUE(stage_.makeFrame(0.01, 64, 64));
  viewer::GoodSettings good;
  good.keep(stage_);
  viewer::WaysBack ways(good, stage_);
  ASSERT_FALSE(stage_.makeFrame(0.01, 640, 480));
  EXPECT_TRUE(ways.take());
  EXPECT_EQ(stage_.viewSettings.samples, 1u);
  ASSERT_FALSE(stage_.makeFrame(0.01, 640, 480));
  EXPECT_TRUE(ways.take());
  EXPECT_TRUE(stage_.makeFrame(0.01, 640, 480));
  EXPECT_EQ(stage_.viewSettings.samples, 1u);
}

TEST_F(StageSettings, ThatAreOutOfRangeChangeNothing) {
  SceneSettings settings = settingsOf(stage_, 0);
  settings.simulation.damping = std::nanf("");
  settings.material.fiberRadius = 1e-3f;
  const SceneSettings before = settingsOf(stage_, 0);
  expectError(apply(settings, 0, stage_), "damping");
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), before));
}

TEST_F(StageSettings, GoBackAndForward) {
  viewer::SettingsPanel panel;
  const TestFolder folder;
  const std::filesystem::path file = folder / "settings.json";
  SceneSettings wanted = settingsOf(stage_, 0);
  const SceneSettings first = wanted;
  wanted.simulation.damping = 0.25f;
  wanted.material.fiberRadius = 70e-6f;
  wanted.lights.resize(2);
  wanted.lights[1].direction = {0, 1, 0};
  required(saveSettings(file, wanted));
  required(panel.load(file, stage_));
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), wanted));
  panel.undo(stage_);
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), first));
  panel.undo(stage_);
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), first));
  panel.redo(stage_);
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), wanted));
  EXPECT_EQ(stage_.lights().size(), 2u);

  expectError(panel.load("no_such_file.json", stage_), "no_such_file.json");
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), wanted));
}

TEST_F(StageSettings, OfAnotherSceneHaveEditsOfTheirOwn) {
  viewer::SettingsPanel panel;
  panel.undo(stage_);
  ASSERT_TRUE(
      stage_.show({.kind = viewer::StageKind::kHead, .preset = sample::GroomPreset::kCurly}));
  const SceneSettings second = settingsOf(stage_, 0);
  panel.undo(stage_);
  EXPECT_TRUE(haveSameSettings(settingsOf(stage_, 0), second));
}

}  // namespace
