#include "viewer/script_makers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <random>

#include "panels/value_widget.h"
#include "pelage/settings/settings_file.h"

namespace pelage::test {

namespace {

// Returns the value at a share of the slider; another one for kinds without a slider.
ParameterValue valueAt(const Parameter& parameter, double share, const ParameterValue& now) {
  const double number = viewer::valueAtShare(parameter, share);
  switch (parameter.type) {
    case ParameterType::kBool:
      return !std::get<bool>(now);
    case ParameterType::kCount: {
      const auto count = static_cast<uint64_t>(number);
      return parameter.isPowerOfTwo ? std::bit_floor(count) : count;
    }
    case ParameterType::kFloat:
      return static_cast<float>(number);
    case ParameterType::kVector:
    case ParameterType::kColor: {
      const auto x = static_cast<float>(number);
      return Float3{x, x / 2, x / 4};
    }
    case ParameterType::kCurve: {
      ParameterCurve curve = std::get<ParameterCurve>(now);
      curve[3] = static_cast<float>(number);
      return curve;
    }
    case ParameterType::kChoice:
      break;
  }
  return (std::get<uint64_t>(now) + 1) % parameter.choices.size();
}

void save(const SceneSettings& settings, const std::filesystem::path& path) {
  const auto saved = saveSettings(path, settings, SettingsExtent::kAll);
  EXPECT_TRUE(saved) << (saved ? "" : saved.error().message);
}

const SettingsSection& sectionOf(std::string_view key) {
  const auto all = settingsSections();
  return *std::find_if(all.begin(), all.end(), [&](const auto& s) { return s.key == key; });
}

const Parameter& parameterOf(std::string_view key, std::string_view path) {
  const auto all = sectionOf(key).parameters;
  return *std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.path == path; });
}

}  // namespace

std::string everySetting(const SceneSettings& base, const std::filesystem::path& folder) {
  std::string script;
  uint32_t frame = 1;
  const auto drop = [&](const SceneSettings& settings) {
    const std::string name = fmt::format("setting_{}.json", frame);
    save(settings, folder / name);
    script += fmt::format("{} drop {}\n", frame++, name);
  };
  const auto all = settingsSections();
  for (size_t s = 0; s < all.size(); ++s) {
    for (const Parameter& parameter : all[s].parameters) {
      SceneSettings settings = base;
      all[s].set(settings, parameter, valueAt(parameter, 0.75, all[s].get(base, parameter)));
      if (parameter.path == "innerConeAngle") settings.lights[0].outerConeAngle = 1.5f;
      drop(settings);
    }
  }
  drop(base);
  return script;
}

std::string everyMethod(const SceneSettings& base, const std::filesystem::path& folder,
                        std::vector<std::string>& names) {
  std::string script;
  uint32_t frame = 1;
  const Parameter& methods = parameterOf("transparency", "method");
  for (uint64_t i = 0; i < methods.choices.size(); ++i) {
    SceneSettings settings = base;
    sectionOf("transparency").set(settings, methods, i);
    const std::string name = choiceName(methods.choices[i]);
    save(settings, folder / (name + ".json"));
    script +=
        fmt::format("{} drop {}.json\n{} screenshot method_{}.png\n", frame, name, frame + 1, name);
    frame += 2;
    names.push_back(name);
  }
  for (const HairShadow shadow : {HairShadow::kDepth, HairShadow::kDeep}) {
    SceneSettings settings = base;
    settings.lights[0].shadow = shadow;
    settings.lights[0].shadowSize = 256;
    save(settings, folder / fmt::format("shadow_{}.json", static_cast<int>(shadow)));
    script += fmt::format("{} drop shadow_{}.json\n", frame++, static_cast<int>(shadow));
  }
  script += fmt::format("{} screenshot shadow.png\n", frame++);
  SceneSettings settings = base;
  settings.view = {.samples = 4, .reversedDepth = true};
  save(settings, folder / "view.json");
  return script + fmt::format("{} drop view.json\n{} screenshot view.png\n", frame, frame + 1);
}

std::string randomInput(uint32_t seed, uint32_t frames, const std::vector<std::string>& files) {
  static constexpr const char* kKeys[] = {
      "s",     "s",   "f",  "space", ".",    "r",      "l",         "b", "c",  "-", "=", "escape",
      "enter", "tab", "up", "left",  "home", "delete", "backspace", "1", "f9", "a", "z", "y"};
  static constexpr const char* kHeld[] = {"control", "shift", "alt", "g"};
  static constexpr const char* kButtons[] = {"left", "left", "left", "right", "middle"};
  std::mt19937 random(seed);
  const auto below = [&](uint32_t end) { return static_cast<uint32_t>(random() % end); };
  const auto percent = [&](uint32_t share) { return below(100) < share; };
  std::string script = "0 key s\n";
  uint32_t width = 320, height = 240;
  for (uint32_t frame = 0; frame < frames; ++frame) {
    const auto add = [&](const std::string& event) {
      script += fmt::format("{} {}\n", frame, event);
    };
    if (percent(80)) add(fmt::format("move {} {}", below(width + 20), below(height + 20)));
    if (percent(40)) add(fmt::format("press {}", kButtons[below(std::size(kButtons))]));
    if (percent(30)) add(fmt::format("move {} {}", below(width), below(height)));
    if (percent(60)) add(fmt::format("release {}", kButtons[below(std::size(kButtons))]));
    if (percent(10)) add(fmt::format("scroll {}", static_cast<int>(below(7)) - 3));
    if (percent(30)) add(fmt::format("key {}", kKeys[below(std::size(kKeys))]));
    if (percent(10)) add(fmt::format("keydown {}", kHeld[below(std::size(kHeld))]));
    if (percent(20)) add(fmt::format("keyup {}", kHeld[below(std::size(kHeld))]));
    if (percent(5)) add(fmt::format("text {}", 32 + below(200)));
    if (percent(4)) {
      width = 1 + below(480);
      height = 1 + below(360);
      add(fmt::format("resize {} {}", width, height));
    }
    if (percent(8)) add("drop " + files[below(static_cast<uint32_t>(files.size()))]);
  }
  return script + fmt::format("{} quit\n", frames);
}

std::string randomSettingsFile(const SceneSettings& base, uint32_t seed,
                               const std::filesystem::path& folder) {
  static constexpr std::string_view kCostly[] = {"shadowSize",   "shadowLayers", "countPerGuide",
                                                 "drawnStrands", "subSteps",     "maxBytes"};
  std::mt19937 random(seed);
  SceneSettings settings = base;
  for (const SettingsSection& section : settingsSections()) {
    for (const Parameter& parameter : section.parameters) {
      if (random() % 4 != 0) continue;
      const bool costly =
          std::find(std::begin(kCostly), std::end(kCostly), parameter.field) != std::end(kCostly);
      const double share = std::uniform_real_distribution<double>()(random) * (costly ? 0.2 : 1.0);
      const ParameterValue now = section.get(settings, parameter);
      const ParameterValue value = valueAt(parameter, share, now);
      if (check(parameter, value)) section.set(settings, parameter, value);
    }
  }
  Light& light = settings.lights[0];
  light.outerConeAngle = std::max(light.outerConeAngle, light.innerConeAngle);
  std::string name = fmt::format("random_{}.json", seed);
  save(settings, folder / name);
  return name;
}

}  // namespace pelage::test
