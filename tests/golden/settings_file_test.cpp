// Simulation settings as JSON.
#include "settings_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace {

using pelage::SimulationSettings;
using pelage::program::SettingsFile;

TEST(SettingsFile, SetsWhatItHasAndNothingElse) {
  const auto file = SettingsFile::parse(
      R"({"solver": "classic", "gravity": [0, -1.6, 0.5], "damping": 0.25, "subSteps": 4,
          "wind": {"velocity": [1, 2, 3]}, "sleep": {"enabled": false},
          "curves": {"damping": [1, 2, 3, 4, 5, 6, 7, 8]}, "contact": {"friction": 0.5}})",
      "a.json");
  ASSERT_TRUE(file) << file.error().message;
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

TEST(SettingsFile, OfAnEmptyObjectSetsNothing) {
  const auto file = SettingsFile::parse("{}", "a.json");
  ASSERT_TRUE(file) << file.error().message;
  SimulationSettings settings;
  file->apply(settings);
  EXPECT_EQ(settings, SimulationSettings{});
}

TEST(SettingsFile, RefusesByNameWhatIsNoSettingOrOutOfRange) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"bendlength": 0.1})", "'bendlength' is no setting"},
      {R"({"wind": {"speed": 3}})", "'wind.speed' is no setting"},
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
  const auto file = SettingsFile::load("no_such.json");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("no_such.json"), std::string::npos);
}

}  // namespace
