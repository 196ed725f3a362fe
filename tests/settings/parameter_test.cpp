// The table of parameters: it fits itself, the structs, and the ranges of the library.
#include "pelage/settings/parameter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "pelage/scene.h"
#include "pelage/settings/scene_settings.h"
#include "random_settings.h"
#include "support/errors.h"

namespace {

using pelage::check;
using pelage::Parameter;
using pelage::ParameterScale;
using pelage::ParameterType;
using pelage::ParameterValue;
using pelage::SceneSettings;
using pelage::SettingsSection;
using pelage::test::expectError;

void eachParameter(const std::function<void(const SettingsSection&, const Parameter&)>& visit) {
  for (const SettingsSection& section : pelage::settingsSections())
    for (const Parameter& parameter : section.parameters) visit(section, parameter);
}

bool hasNumbers(const Parameter& p) {
  return p.type != ParameterType::kBool && p.type != ParameterType::kChoice;
}

TEST(ParameterTable, HasTextsADefaultInRangeAndASlider) {
  std::set<std::string> names;
  size_t count = 0;
  eachParameter([&](const SettingsSection& section, const Parameter& p) {
    const std::string name = std::string(section.key) + '.' + std::string(p.path);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(p.meaning.empty()) << name;
    EXPECT_TRUE(check(p, p.defaultValue)) << name;
    EXPECT_EQ(p.type == ParameterType::kChoice, !p.choices.empty()) << name;
    ++count;
    if (!hasNumbers(p)) return;
    EXPECT_LT(p.sliderLow, p.sliderHigh) << name;
    EXPECT_GE(p.sliderLow, p.low) << name;
    EXPECT_LE(p.sliderHigh, p.high) << name;
    EXPECT_TRUE(!p.lowIsOpen || p.sliderLow > p.low) << name;
    EXPECT_TRUE(p.scale == ParameterScale::kLinear || p.sliderLow >= 0) << name;
    // A number where an editor can reach it, but for those that mean "all" or "none".
    if (const auto* number = std::get_if<float>(&p.defaultValue)) {
      EXPECT_GE(*number, p.sliderLow) << name;
      EXPECT_LE(*number, p.sliderHigh) << name;
    }
  });
  EXPECT_GE(count, 95u);
}

TEST(ParameterTable, HasTheRangesOfItsTexts) {
  const std::regex range(R"(^([-0-9.,e]*[0-9])\.\.([-0-9.,e]+|pi/2))");
  size_t count = 0;
  eachParameter([&](const SettingsSection&, const Parameter& p) {
    const std::string words(p.range);
    std::smatch ends;
    const auto number = [](std::string text) {
      if (text == "pi/2") return std::numbers::pi / 2;
      std::erase(text, ',');
      return std::stod(text);
    };
    if (std::regex_search(words, ends, range)) {
      EXPECT_NEAR(p.low, number(ends[1]), 1e-7 * std::abs(p.low)) << p.path;
      EXPECT_NEAR(p.high, number(ends[2]), 1e-7 * std::abs(p.high)) << p.path;
      ++count;
    } else if (words.starts_with(">= 0")) {
      EXPECT_EQ(p.low, 0) << p.path;
      EXPECT_FALSE(p.lowIsOpen) << p.path;
      EXPECT_TRUE(std::isinf(p.high)) << p.path;
      ++count;
    } else if (words.starts_with("> 0")) {
      EXPECT_TRUE(p.low > 0 || p.lowIsOpen) << p.path;
      ++count;
    }
  });
  EXPECT_GE(count, 60u);
}

TEST(ParameterTable, GetsWhatWasSetAndChangesNothingElse) {
  std::mt19937 random(1);
  eachParameter([&](const SettingsSection& section, const Parameter& p) {
    SceneSettings settings;
    const ParameterValue value = pelage::test::randomValue(p, random);
    EXPECT_TRUE(check(p, value)) << p.path;
    section.set(settings, p, value);
    EXPECT_TRUE(haveSameBits(section.get(settings, p), value)) << p.path;
    eachParameter([&](const SettingsSection& other, const Parameter& q) {
      if (&q == &p) return;
      EXPECT_TRUE(haveSameBits(other.get(settings, q), q.defaultValue))
          << p.path << " changed " << q.path;
    });
  });
}

// The value with this number in one place.
ParameterValue with(ParameterValue value, double number) {
  const auto as = static_cast<float>(number);
  if (auto* whole = std::get_if<uint64_t>(&value)) *whole = static_cast<uint64_t>(number);
  if (auto* single = std::get_if<float>(&value)) *single = as;
  if (auto* vector = std::get_if<pelage::Float3>(&value)) vector->y = as;
  if (auto* curve = std::get_if<pelage::ParameterCurve>(&value)) (*curve)[5] = as;
  return value;
}

TEST(ParameterTable, HasTheRangesThatTheSimulationChecks) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const Parameter& p : pelage::parametersOf<pelage::SimulationSettings>()) {
    if (!hasNumbers(p)) continue;
    std::vector<double> numbers = {p.low, p.high};
    if (p.type == ParameterType::kCount) {
      numbers.insert(numbers.end(), {p.low - 1, p.high + 1});
    } else {
      for (const double end : {p.low, p.high}) {
        const auto number = static_cast<float>(end);
        for (const float to : {-1e30f, 1e30f}) numbers.push_back(std::nextafter(number, to));
      }
      numbers.insert(numbers.end(), {kNaN, kInfinite, -kInfinite, 0.0, -0.0, 1e30, -1e30});
    }
    for (const double number : numbers) {
      pelage::SimulationSettings settings;
      const ParameterValue value = with(p.defaultValue, number);
      p.set(&settings, value);
      EXPECT_EQ(static_cast<bool>(check(p, value)), static_cast<bool>(validate(settings)))
          << p.path << " = " << number;
    }
  }
}

TEST(ParameterTable, RefusesByNameWhatIsOutOfRange) {
  eachParameter([&](const SettingsSection&, const Parameter& p) {
    if (p.type == ParameterType::kBool) return;
    ParameterValue value = p.defaultValue;
    if (p.type == ParameterType::kChoice)
      value = uint64_t{p.choices.size()};
    else if (p.type == ParameterType::kCount && p.high < 0x1p32 - 1)
      value = static_cast<uint64_t>(p.high) + 1;
    else if (p.type == ParameterType::kCount)
      return;
    else
      value = with(value, std::numeric_limits<double>::quiet_NaN());
    const auto checked = check(p, value, "the.name");
    ASSERT_FALSE(checked) << p.path;
    EXPECT_EQ(checked.error().message.find("'the.name' is "), 0u) << checked.error().message;
  });
}

// Settings that stand for members of a class.
TEST(SceneSettings, HaveTheDefaultsOfTheObjects) {
  pelage::Scene scene;
  pelage::HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = 2;
  asset.positions = {{0, 0, 0, 0}, {0, 0.1f, 0, 0}};
  ASSERT_TRUE(asset.process());
  const auto hair = scene.addHair(asset, {});
  pelage::CollisionMesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.influences.assign(3, {{0, 0, 0, 0}, {1, 0, 0, 0}});
  mesh.indices = {0, 1, 2};
  const auto collider = scene.addCollider(mesh, {});
  ASSERT_TRUE(hair && collider);
  SceneSettings settings;
  settings.object = settingsOf(scene.hair(*hair));
  settings.collider = settingsOf(scene.collider(*collider));
  EXPECT_TRUE(haveSameSettings(settings, {}));

  // settingsOf() returns the settings that apply() sets.
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    settings = pelage::test::randomSettings(random, 1);
    settings.object.drawnStrands = i % 2 == 0 ? 0 : pelage::kAllStrands;
    SceneSettings taken = settings;
    apply(settings.object, scene.hair(*hair));
    apply(settings.collider, scene.collider(*collider));
    taken.object = settingsOf(scene.hair(*hair));
    taken.collider = settingsOf(scene.collider(*collider));
    EXPECT_TRUE(haveSameSettings(taken, settings));
  }

  const pelage::HairDef def;
  pelage::HairDef applied;
  apply(pelage::HairCreation{}, applied);
  EXPECT_TRUE(applied.skinning == def.skinning && applied.collidingHair == def.collidingHair &&
              applied.levelOfDetail == def.levelOfDetail &&
              applied.storeFollowHairs == def.storeFollowHairs);
  const pelage::View view;
  pelage::View appliedView;
  apply(pelage::ViewSettings{}, appliedView);
  EXPECT_TRUE(appliedView.samples == view.samples && appliedView.seed == view.seed &&
              appliedView.reversedDepth == view.reversedDepth);
}

TEST(SceneSettings, AreTheSameWithTheSameBits) {
  const SceneSettings a;
  eachParameter([&](const SettingsSection& section, const Parameter& p) {
    std::mt19937 random(2);
    SceneSettings b;
    ParameterValue value = p.defaultValue;
    while (haveSameBits(value, p.defaultValue)) value = pelage::test::randomValue(p, random);
    section.set(b, p, value);
    EXPECT_FALSE(haveSameSettings(a, b)) << p.path;
    section.set(b, p, p.defaultValue);
    EXPECT_TRUE(haveSameSettings(a, b)) << p.path;
  });
  SceneSettings b;
  b.lights.emplace_back();
  EXPECT_FALSE(haveSameSettings(a, b));
}

TEST(SceneSettings, RefusesWhatDoesNotGoTogether) {
  SceneSettings settings;
  EXPECT_TRUE(validate(settings));
  settings.lights[0].innerConeAngle = 0.2f;
  expectError(validate(settings), "'lights[0].innerConeAngle'");
  settings.lights[0].outerConeAngle = 0.2f;
  EXPECT_TRUE(validate(settings));
  settings.lights.resize(pelage::kMaxLights + 1);
  EXPECT_FALSE(validate(settings));
  settings.lights.clear();
  EXPECT_TRUE(validate(settings));
}

TEST(ParameterText, LosesItsMarks) {
  EXPECT_EQ(pelage::plainText("Shadow, with any `shadow`. [oit.md](oit.md) compares them."),
            "Shadow, with any shadow. oit.md compares them.");
  EXPECT_EQ(pelage::plainText("[a](b"), "a");
  EXPECT_EQ(pelage::choiceName("kKajiyaKay"), "kajiyaKay");
  EXPECT_EQ(pelage::choiceName(""), "");
}

}  // namespace
