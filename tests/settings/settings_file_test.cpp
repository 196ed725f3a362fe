// Settings as JSON: what is written is what is read, and errors say what to do.
#include "pelage/settings/settings_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "random_settings.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using pelage::parseSettings;
using pelage::saveSettings;
using pelage::SceneSettings;
using pelage::SettingsExtent;
using pelage::SettingsFile;
using pelage::settingsSnippet;
using pelage::settingsText;
using pelage::SimulationSettings;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;
using pelage::test::textOf;

TEST(SettingsFile, SetsWhatItHasAndNothingElse) {
  const auto file = required(SettingsFile::parse(
      R"({"solver": "classic", "gravity": [0, -1.6, 0.5], "damping": 0.25, "subSteps": 4,
          "wind": {"velocity": [1, 2, 3]}, "sleep": {"enabled": false},
          "curves": {"damping": [1, 2, 3, 4, 5, 6, 7, 8]}, "contact": {"friction": 0.5}})",
      "a.json"));
  SimulationSettings settings;
  settings.bendLength = 0.123f;
  settings.wind.gustPeriod = 7;
  SimulationSettings expected = settings;
  file->apply(settings);
  expected.solver = pelage::Solver::kClassic;
  expected.gravity = {0, -1.6f, 0.5f};
  expected.damping = 0.25f;
  expected.subSteps = 4;
  expected.wind.velocity = {1, 2, 3};
  expected.sleep.enabled = false;
  expected.curves.damping = {1, 2, 3, 4, 5, 6, 7, 8};
  expected.contact.friction = 0.5f;
  EXPECT_EQ(settings, expected);
  EXPECT_EQ(file->names(),
            (std::vector<std::string>{"solver", "gravity", "damping", "subSteps", "wind.velocity",
                                      "curves.damping", "sleep.enabled", "contact.friction"}));
}

TEST(SettingsFile, HasTheSectionsOfAScene) {
  const auto file = required(SettingsFile::parse(
      R"({"simulation": {"wind": {"gustPeriod": 3}}, "damping": 0.5, "material": {"model": "fiber"},
          "object": {"drawnShare": 0.5}, "creation": {"skinning": "dualQuaternions"},
          "lights": [{"color": [2, 2, 2]}, {"opaque": {"bias": 0.01}, "shadow": "deep"}],
          "transparency": {"method": "hybrid8", "maxBytes": 5000000000}})",
      "a.json"));
  SceneSettings settings;
  settings.lights[0].shadowSize = 77;
  settings.lights.resize(5);
  file->apply(settings);
  EXPECT_EQ(settings.simulation.wind.gustPeriod, 3);
  EXPECT_EQ(settings.simulation.damping, 0.5f);
  EXPECT_EQ(settings.material.model, pelage::ShadingModel::kFiber);
  EXPECT_EQ(settings.object.drawnShare, 0.5f);
  EXPECT_EQ(settings.creation.skinning, pelage::SkinningMethod::kDualQuaternions);
  ASSERT_EQ(settings.lights.size(), 2u);
  EXPECT_EQ(settings.lights[0].color, (pelage::Float3{2, 2, 2}));
  EXPECT_EQ(settings.lights[0].shadowSize, 77u);
  EXPECT_EQ(settings.lights[1].opaque.bias, 0.01f);
  EXPECT_EQ(settings.lights[1].shadow, pelage::HairShadow::kDeep);
  EXPECT_EQ(settings.transparency.method, pelage::Transparency::kHybrid8);
  EXPECT_EQ(settings.transparency.maxBytes, 5000000000u);
  EXPECT_TRUE(file->sets("simulation.damping"));
  EXPECT_TRUE(file->sets("material"));
  EXPECT_TRUE(file->sets("lights"));
  EXPECT_TRUE(file->sets("lights[1].shadow"));
  EXPECT_FALSE(file->sets("lights[0].shadow"));
  EXPECT_FALSE(file->sets("view"));
}

TEST(SettingsFile, OfAnEmptyObjectSetsNothing) {
  const auto file = required(SettingsFile::parse("{}", "a.json"));
  SceneSettings settings;
  settings.lights.clear();
  SceneSettings expected = settings;
  file->apply(settings);
  EXPECT_TRUE(haveSameSettings(settings, expected));
}

TEST(SettingsFile, RefusesByNameWhatIsNoSettingOrOutOfRange) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"bendlength": 0.1})", "'bendlength' is no setting"},
      {R"({"wind": {"speed": 3}})", "'wind.speed' is no setting"},
      {R"({"wind.velocity": [1, 0, 0]})", "'wind.velocity' is no setting"},
      {R"({"": 0})", "'' is no setting"},
      {R"({"wind": {"": 0}})", "'wind.' is no setting"},
      {R"({"damping": 2})", "'damping' is 2, but must be in 0..1"},
      {R"({"damping": -0.5})", "'damping'"},
      {R"({"damping": "0.1"})", "'damping' must be a number"},
      {R"({"damping": null})", "'damping' must be a number"},
      {R"({"damping": 1e39})", "'damping' is infinite"},
      {R"({"gravity": [0, -9.81]})", "'gravity' must be an array of 3 numbers"},
      {R"({"gravity": [0, true, 0]})", "'gravity' must be an array of 3 numbers"},
      {R"({"curves": {"stiffness": [1, 1]}})", "'curves.stiffness' must be an array of 8 numbers"},
      {R"({"curves": {"stiffness": [1, 1, 1, 1, 1, 1, 1, -1]}})", "'curves.stiffness'"},
      {R"({"curves": 1})", "'curves' must be an object"},
      {R"({"subSteps": 2.5})", "'subSteps' must be a whole number"},
      {R"({"subSteps": -1})", "'subSteps' must be a whole number"},
      {R"({"subSteps": 33})", "'subSteps' is 33, but must be in 1..32"},
      {R"({"sleep": {"enabled": 1}})", "'sleep.enabled' must be true or false"},
      {R"({"sleep": {"time": -1}})", "'sleep.time'"},
      {R"({"solver": "verlet"})", "'solver' must be \"exact\" or \"classic\""},
      {R"({"damping": 0.1, "damping": 0.2})", "'damping' is there twice"},
      {R"({"damping": 0.1, "simulation": {"damping": 0.1}})",
       "'simulation.damping' is there twice"},
      {R"({"simulation": 3})", "'simulation' must be an object"},
      {R"({"material": {"opacity": 1.5}})", "'material.opacity' is 1.5, but must be in 0..1"},
      {R"({"material": {"color": 1}})", "'material.color' is no setting; there are: ambient"},
      {R"({"material": {"fiberRadius": 0}})", "'material.fiberRadius' is 0, but must be above 0"},
      {R"({"view": {"samples": 3}})", "must be a power of two in 1..8"},
      {R"({"lights": {}})", "'lights' must be an array of at most 8 objects"},
      {R"({"lights": [{}, {}, {}, {}, {}, {}, {}, {}, {}]})", "'lights' must be an array"},
      {R"({"lights": [{}, 1]})", "'lights[1]' must be an object"},
      {R"({"lights": [{"direction": [0, 0, 0]}]})", "'lights[0].direction' is (0, 0, 0)"},
      {R"({"lights": [{"innerConeAngle": 0.1}]})", "'lights[0].innerConeAngle' is 0.1"},
      {R"({"lights": [{"opaque": {"depth": 1}}]})", "'lights[0].opaque.depth' is no setting"},
      {R"({"transparency": {"method": "hybrid5"}})", "must be \"alphaTest\", \"stochastic\""},
      {R"([1, 2])", "it must be a JSON object"},
      {R"({"damping": nan})", "byte 14"},
      {R"({"damping": 0.1)", "byte 16"},
      {"", "byte 1"},
  };
  for (const auto& [text, expected] : cases) {
    const auto file = SettingsFile::parse(text, "a.json");
    ASSERT_FALSE(file) << text;
    EXPECT_EQ(file.error().message.substr(0, 8), "a.json: ") << file.error().message;
    EXPECT_NE(file.error().message.find(expected), std::string::npos) << file.error().message;
  }
}

TEST(SettingsFile, NamesAFileThatIsNotThere) {
  expectError(SettingsFile::load("no_such.json"), "no_such.json");
}

TEST(SettingsText, IsReadAsTheSameBits) {
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    const SceneSettings settings = pelage::test::randomSettings(random, i % 3 == 0 ? 1 : 0.1);
    ASSERT_TRUE(validate(settings)) << validate(settings).error().message;
    for (const SettingsExtent extent : {SettingsExtent::kChanges, SettingsExtent::kAll}) {
      const std::string text = settingsText(settings, extent);
      const auto read = parseSettings(text, "text");
      ASSERT_TRUE(read) << read.error().message << "\n" << text;
      ASSERT_TRUE(haveSameSettings(*read, settings)) << text;
    }
  }
}

TEST(SettingsText, KeepsSpecialNumbers) {
  SceneSettings settings;
  settings.simulation.vspThreshold = std::numeric_limits<float>::infinity();
  settings.simulation.gravity = {-0.0f, std::numeric_limits<float>::max(),
                                 std::numeric_limits<float>::denorm_min()};
  settings.follow.seed = ~uint64_t{0};
  const auto read = required(parseSettings(settingsText(settings), "text"));
  EXPECT_TRUE(haveSameSettings(*read, settings));
}

TEST(SettingsText, HasWhatDiffersAlone) {
  EXPECT_EQ(settingsText({}), "{}\n");
  std::mt19937 random(3);
  for (const pelage::SettingsSection& section : pelage::settingsSections())
    for (const pelage::Parameter& p : section.parameters) {
      SceneSettings settings;
      pelage::ParameterValue value = p.defaultValue;
      while (haveSameBits(value, p.defaultValue)) value = pelage::test::randomValue(p, random);
      section.set(settings, p, value);
      if (p.path == "innerConeAngle")
        settings.lights[0].outerConeAngle = std::numbers::pi_v<float> / 2;
      const auto file = required(SettingsFile::parse(settingsText(settings), "text"));
      const size_t more = p.path == "innerConeAngle" ? 2 : section.isList ? 1 : 0;
      EXPECT_EQ(file->names().size(), 1 + more) << settingsText(settings);
    }
  const auto all = required(SettingsFile::parse(settingsText({}, SettingsExtent::kAll), "text"));
  size_t count = 1;  // "lights"
  for (const pelage::SettingsSection& section : pelage::settingsSections())
    count += section.parameters.size();
  EXPECT_EQ(all->names().size(), count);
}

TEST(SettingsText, ReadsLikeThis) {
  SceneSettings settings;
  settings.simulation.bendLength = 0.08f;
  settings.simulation.wind.velocity = {2, 0, 0};
  settings.material.fiberRadius = 115e-6f;
  settings.lights = {pelage::Light{}, pelage::Light{}};
  settings.lights[1].shadow = pelage::HairShadow::kDeep;
  EXPECT_EQ(settingsText(settings), R"({
  "simulation": {
    "bendLength": 0.08,
    "wind": {
      "velocity": [2, 0, 0]
    }
  },
  "material": {
    "fiberRadius": 0.000115
  },
  "lights": [
    {},
    {
      "shadow": "deep"
    }
  ]
}
)");
}

TEST(SettingsSave, WritesAFileOrLeavesTheOldOne) {
  const TestFolder folder;
  const auto path = folder / "a.json";
  SceneSettings settings;
  settings.material.opacity = 0.3f;
  required(saveSettings(path, settings));
  const auto loaded = required(pelage::loadSettings(path));
  EXPECT_TRUE(haveSameSettings(*loaded, settings));
  const std::string before = textOf(path);
  settings.material.opacity = 3;
  expectError(saveSettings(path, settings), "'material.opacity' is 3");
  EXPECT_EQ(textOf(path), before);
  expectError(saveSettings(folder / "no" / "folder.json", {}), "folder.json");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(SettingsPresets, AreValidAndDiffer) {
  const auto presets = pelage::settingsPresets();
  ASSERT_EQ(presets.size(), 6u);
  for (const pelage::SettingsPreset& preset : presets) {
    const auto settings = required(pelage::presetSettings(preset.name));
    EXPECT_FALSE(preset.meaning.empty());
    for (const pelage::SettingsPreset& other : presets)
      EXPECT_EQ(haveSameSettings(*settings, *pelage::presetSettings(other.name)),
                other.name == preset.name);
  }
  expectError(pelage::presetSettings("bald"), "long, curly, fur, mohawk, afro, beard");
}

// Something of every section and type.
SceneSettings snippetSettings() {
  SceneSettings settings = *pelage::presetSettings("afro");
  settings.simulation.solver = pelage::Solver::kClassic;
  settings.simulation.vspThreshold = std::numeric_limits<float>::infinity();
  settings.simulation.curves.damping = {1, 1, 1, 1, 2, 2, 3, 4.5f};
  settings.object.drawnStrands = 1000;
  settings.object.simulated = false;
  settings.creation.skinning = pelage::SkinningMethod::kDualQuaternions;
  settings.creation.collidingHair = pelage::CollidingHair::kGuidesAndFollows;
  settings.collider.friction = 0.5f;
  settings.colliderLook.color = {1, 0.5f, 0};
  settings.contactLook.width = 2;
  settings.lights.resize(2);
  settings.lights[0].shadow = pelage::HairShadow::kDeep;
  settings.lights[1].opaque.bias = 1e-5f;
  settings.transparency.method = pelage::Transparency::kTiles;
  settings.transparency.maxBytes = uint64_t{8} << 30;
  settings.view.samples = 4;
  return settings;
}

TEST(SettingsSnippet, IsTheCodeOfTheFileThatIsCompiledBelow) {
  const std::filesystem::path golden =
      std::filesystem::path(PELAGE_SOURCE_DIR) / "tests/settings/snippet_golden.inc";
  const std::string code = settingsSnippet(snippetSettings());
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) std::ofstream(golden) << code;
  EXPECT_EQ(code, textOf(golden)) << "PELAGE_UPDATE_GOLDEN=1 writes it again";
  EXPECT_EQ(settingsSnippet({}), "");
}

TEST(SettingsSnippet, SetsTheSettings) {
  pelage::HairObjectSettings hair;
  pelage::HairCreation def;
  pelage::ColliderSettings collider;
  pelage::ViewSettings view;
#include "snippet_golden.inc"
  const SceneSettings settings = {simulation,   material,    hair,   def,          follow, collider,
                                  colliderLook, contactLook, lights, transparency, view};
  EXPECT_TRUE(haveSameSettings(settings, snippetSettings())) << settingsText(settings);
}

}  // namespace
