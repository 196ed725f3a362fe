// The panel of all parameters, with a mouse but without a window: each value can be edited, is
// marked as changed, and can be reset.
#include "panels/parameter_panel.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "panels/edit_history.h"
#include "panels/value_widget.h"

namespace {

using pelage::Float2;
using pelage::Parameter;
using pelage::ParameterType;
using pelage::ParameterValue;
using pelage::SceneSettings;
using viewer::EditHistory;
using viewer::PanelChange;
using viewer::PanelItem;
using viewer::ParameterPanel;

/// Makes a context of Dear ImGui without a backend, and a window as high as the panel.
class Panel : public testing::Test {
 protected:
  static constexpr float kWidth = 700, kHeight = 6000;

  Panel() {
    context_ = ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().Fonts->Build();
  }
  ~Panel() override { ImGui::DestroyContext(context_); }

  PanelChange frame(float x = -1, float y = -1, bool down = false) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {kWidth, kHeight};
    io.DeltaTime = 1.0f / 60;
    io.MousePos = {x, y};
    io.MouseDown[0] = down;
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({kWidth, kHeight});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoTitleBar);
    const PanelChange change = viewer::drawParameters(panel, settings);
    ImGui::End();
    ImGui::Render();
    sections |= change.sections;
    if (change.finished) {
      ++finished;
      history.add(settings);
    }
    return change;
  }

  /// Draws until all groups are open and no longer move.
  void open() {
    panel.openAll = true;
    for (int i = 0; i < 4; ++i) frame();
  }

  /// Presses the button at one point and releases it at another.
  void drag(const Float2& from, const Float2& to) {
    frame(from.x, from.y);
    frame(from.x, from.y, true);
    frame(to.x, to.y, true);
    frame(to.x, to.y, true);
    frame(to.x, to.y);
    frame();
  }
  void click(const Float2& at) { drag(at, at); }

  void useClassicSolver() {
    settings.simulation.solver = pelage::Solver::kClassic;
    history.add(settings);
    frame();
  }

  const PanelItem* find(const Parameter& parameter) const {
    for (const PanelItem& item : panel.items)
      if (item.parameter == &parameter && item.index == 0) return &item;
    return nullptr;
  }

  static Float2 inside(const Float2& min, const Float2& max, float x, float y) {
    return {min.x + (max.x - min.x) * x, min.y + (max.y - min.y) * y};
  }

  /// Changes the value with the mouse.
  void move(PanelItem item) {
    const Float2 low = inside(item.min, item.max, 0.06f, 0.5f);
    const double share =
        item.parameter->type == ParameterType::kCount
            ? viewer::shareOf(*item.parameter, static_cast<double>(std::get<uint64_t>(
                                                   item.section->get(settings, *item.parameter))))
            : 0;
    switch (item.parameter->type) {
      case ParameterType::kBool:
        return click(inside(item.min, item.max, 0.5f, 0.5f));
      case ParameterType::kCurve:
        return drag(inside(item.min, item.max, 0.1f, 0.2f), inside(item.min, item.max, 0.9f, 0.9f));
      case ParameterType::kChoice: {
        const bool last = std::get<uint64_t>(item.section->get(settings, *item.parameter)) > 0;
        click(low);
        // The list opens below: click its first or second row.
        const float row = ImGui::GetTextLineHeightWithSpacing();
        return click({low.x, item.max.y + (last ? 0.8f : 1.8f) * row});
      }
      case ParameterType::kCount:
        return drag(low, inside(item.min, item.max, share > 0.5 ? 0.1f : 0.9f, 0.5f));
      default:
        return drag(low, inside(item.min, item.max, 0.2137f, 0.5f));
    }
  }

  ParameterPanel panel;
  SceneSettings settings;
  EditHistory history{SceneSettings{}};
  uint32_t sections = 0;
  int finished = 0;

 private:
  ImGuiContext* context_ = nullptr;
};

void eachParameter(
    const std::function<void(const pelage::SettingsSection&, size_t, const Parameter&)>& visit) {
  const auto all = pelage::settingsSections();
  for (size_t s = 0; s < all.size(); ++s)
    for (const Parameter& parameter : all[s].parameters) visit(all[s], s, parameter);
}

TEST_F(Panel, DrawsEveryParameterOnceWhereItCanBeReached) {
  open();
  std::set<const Parameter*> drawn;
  for (const PanelItem& item : panel.items) {
    EXPECT_TRUE(drawn.insert(item.parameter).second) << item.parameter->path;
    EXPECT_TRUE(item.min.x >= 0 && item.min.y >= 0 && item.max.x <= kWidth &&
                item.max.y <= kHeight && item.max.x > item.min.x && item.max.y > item.min.y)
        << item.parameter->path;
    EXPECT_FALSE(item.isChanged);
  }
  size_t wanted = 0;
  eachParameter([&](const auto&, size_t, const Parameter& p) {
    EXPECT_TRUE(drawn.contains(&p)) << p.path;
    ++wanted;
  });
  EXPECT_EQ(drawn.size(), wanted);
  EXPECT_EQ(sections, 0u);
  EXPECT_EQ(finished, 0);
}

TEST_F(Panel, MovesEachValueInOneStepAndResetsUndoesAndRedoesIt) {
  open();
  eachParameter([&](const auto& section, size_t s, const Parameter& p) {
    if (p.solver == "classic") useClassicSolver();
    const SceneSettings before = settings;
    sections = 0;
    finished = 0;
    ASSERT_NE(find(p), nullptr) << p.path;
    move(*find(p));
    const ParameterValue moved = section.get(settings, p);
    EXPECT_FALSE(haveSameBits(moved, p.defaultValue)) << p.path;
    EXPECT_TRUE(validate(settings)) << p.path;
    EXPECT_EQ(sections, 1u << s) << p.path;
    EXPECT_EQ(finished, 1) << p.path;
    ASSERT_TRUE(find(p)->isChanged) << p.path;
    const SceneSettings after = settings;

    history.undo();
    EXPECT_TRUE(haveSameSettings(history.current(), before)) << p.path;
    history.redo();
    EXPECT_TRUE(haveSameSettings(history.current(), after)) << p.path;

    const PanelItem changed = *find(p);
    click(inside(changed.resetMin, changed.resetMax, 0.5f, 0.5f));
    EXPECT_TRUE(haveSameBits(section.get(settings, p), p.defaultValue)) << p.path;
    EXPECT_EQ(finished, 2) << p.path;
    frame();
    EXPECT_FALSE(find(p)->isChanged) << p.path;
    settings = SceneSettings{};
    history.add(settings);
  });
}

TEST_F(Panel, GraysWhatTheChosenSolverDoesNotUse) {
  open();
  const auto& parameters = pelage::parametersOf<pelage::SimulationSettings>();
  size_t ofOneSolver = 0;
  for (const pelage::Solver solver : {pelage::Solver::kExact, pelage::Solver::kClassic}) {
    if (solver == pelage::Solver::kClassic) useClassicSolver();
    for (const Parameter& p : parameters) {
      const bool isExact = solver == pelage::Solver::kExact;
      const bool used = p.solver.empty() || (p.solver == "exact") == isExact;
      ASSERT_EQ(find(p)->isUsed, used) << p.path;
      if (used) continue;
      move(*find(p));
      EXPECT_EQ(finished, 0) << p.path;
      EXPECT_NE(viewer::tooltipText(p).find("Only the " + std::string(p.solver)),
                std::string::npos);
      ++ofOneSolver;
    }
  }
  EXPECT_GT(ofOneSolver, 4u);
}

// The grab of a slider would cover a number in it.
TEST_F(Panel, HasNamesInWordsAndNumbersBesideTheirSliders) {
  EXPECT_EQ(viewer::wordsOf("bendLength"), "bend length");
  EXPECT_EQ(viewer::wordsOf("damping"), "damping");
  open();
  eachParameter([&](const auto&, size_t, const Parameter& p) {
    const PanelItem item = *find(p);
    EXPECT_LT(ImGui::CalcTextSize(viewer::wordsOf(p.field).c_str()).x, item.min.x) << p.path;
    if (p.type != ParameterType::kFloat && p.type != ParameterType::kCount) return;
    click({item.max.x - 2, (item.min.y + item.max.y) / 2});
    EXPECT_EQ(finished, 0) << p.path;
  });
}

TEST_F(Panel, ADragIsOneStepHoweverManyFramesItTakes) {
  open();
  const Parameter& p = pelage::parametersOf<pelage::SimulationSettings>()[2];
  ASSERT_EQ(p.path, "damping");
  const PanelItem item = *find(p);
  const Float2 from = inside(item.min, item.max, 0.1f, 0.5f);
  frame(from.x, from.y);
  for (int i = 0; i < 50; ++i) frame(from.x + static_cast<float>(i), from.y, true);
  EXPECT_EQ(finished, 0);
  frame(from.x + 50, from.y);
  EXPECT_EQ(finished, 1);
  history.undo();
  EXPECT_FALSE(history.canUndo());
  EXPECT_TRUE(haveSameSettings(history.current(), {}));
}

TEST_F(Panel, TakesNumbersThatAreTypedAndKeepsThemInRange) {
  open();
  ImGuiIO& io = ImGui::GetIO();
  io.KeyMap[ImGuiKey_Enter] = 1;
  const Parameter& damping = pelage::parametersOf<pelage::SimulationSettings>()[2];
  const auto type = [&](const char* text) {
    const PanelItem item = *find(damping);
    const Float2 at = inside(item.min, item.max, 0.2f, 0.5f);
    io.KeyCtrl = true;
    click(at);
    io.KeyCtrl = false;
    io.AddInputCharactersUTF8(text);
    frame();
    io.KeysDown[1] = true;
    frame();
    io.KeysDown[1] = false;
    frame();
    frame();
    return settings.simulation.damping;
  };
  EXPECT_EQ(type("0.375"), 0.375f);
  EXPECT_EQ(finished, 1);
  EXPECT_EQ(type("7"), 1);
  EXPECT_EQ(type("-2"), 0);
  EXPECT_EQ(type("nan"), 0);
  EXPECT_EQ(type("inf"), 0);
}

TEST_F(Panel, ResetsAGroupAndAddsAndRemovesLights) {
  open();
  const auto press = [&](std::string_view label, std::string_view key, size_t index) {
    for (const viewer::PanelButton& button : panel.buttons)
      if (button.label == label && button.section->key == key && button.index == index) {
        const viewer::PanelButton found = button;
        return click(inside(found.min, found.max, 0.5f, 0.5f));
      }
    FAIL() << "no button '" << label << "' of " << key;
  };
  settings.material.opacity = 0.5f;
  settings.material.tipShare = 0.5f;
  settings.simulation.damping = 0.5f;
  frame();
  press("Reset group", "material", 0);
  EXPECT_EQ(finished, 1);
  SceneSettings expected;
  expected.simulation.damping = 0.5f;
  EXPECT_TRUE(haveSameSettings(settings, expected));
  press("Reset group", "simulation", 0);
  EXPECT_TRUE(haveSameSettings(settings, {}));

  for (size_t count = 2; count <= pelage::kMaxLights; ++count) {
    press("Add light", "lights", 0);
    EXPECT_EQ(settings.lights.size(), count);
  }
  for (const viewer::PanelButton& button : panel.buttons) EXPECT_NE(button.label, "Add light");
  settings.lights[1].color = {2, 2, 2};
  open();
  press("Remove light", "lights", 0);
  ASSERT_EQ(settings.lights.size(), pelage::kMaxLights - 1);
  EXPECT_EQ(settings.lights[0].color.x, 2);
  history.undo();
  EXPECT_EQ(history.current().lights.size(), pelage::kMaxLights);
  while (!settings.lights.empty()) {
    open();
    press("Remove light", "lights", 0);
  }
  press("Add light", "lights", 0);
  EXPECT_EQ(settings.lights.size(), 1u);
}

TEST_F(Panel, ShowsWhatIsSearchedFor) {
  const auto search = [&](const char* text) {
    std::snprintf(panel.search, sizeof panel.search, "%s", text);
    frame();
    frame();
    std::set<std::string> names;
    for (const PanelItem& item : panel.items) names.insert(std::string(item.parameter->path));
    return names;
  };
  EXPECT_EQ(search("GUST"), (std::set<std::string>{"wind.gustStrength", "wind.gustPeriod",
                                                   "wind.strandVariation"}));
  EXPECT_EQ(search("refractive"), std::set<std::string>{"refractiveIndex"});
  EXPECT_TRUE(search("no such thing").empty());
  search("");
  panel.onlyChanged = true;
  settings.material.opacity = 0.5f;
  frame();
  ASSERT_EQ(panel.items.size(), 1u);
  EXPECT_EQ(panel.items[0].parameter->path, "opacity");
}

TEST_F(Panel, ACurveFollowsTheMouse) {
  open();
  const auto& parameters = pelage::parametersOf<pelage::SimulationSettings>();
  const auto curve = std::find_if(parameters.begin(), parameters.end(),
                                  [](const Parameter& p) { return p.path == "curves.stiffness"; });
  const PanelItem item = *find(*curve);
  // The stroke goes from the upper left corner, 4, to the lower right one, 0.
  drag(inside(item.min, item.max, 0.001f, 0.001f), inside(item.min, item.max, 0.999f, 0.999f));
  for (size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(settings.simulation.curves.stiffness[i], 4 - 4 * static_cast<float>(i) / 7, 0.1f);
}

TEST_F(Panel, TakesLessThanHalfAMillisecond) {
  open();
  constexpr int kFrames = 200;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kFrames; ++i) frame();
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  // The time is not asserted: the machine may be busy.
  std::printf("a frame with all %zu parameters open: %.3f ms\n", panel.items.size(),
              time.count() / kFrames);
  RecordProperty("milliseconds_a_frame", std::to_string(time.count() / kFrames));
}

TEST(ValueScale, GoesFromEndToEndAndBack) {
  eachParameter([&](const auto&, size_t, const Parameter& p) {
    if (p.type != ParameterType::kFloat && p.type != ParameterType::kCount) return;
    EXPECT_EQ(viewer::valueAtShare(p, 0), p.sliderLow) << p.path;
    EXPECT_EQ(viewer::valueAtShare(p, 1), p.sliderHigh) << p.path;
    double last = p.sliderLow;
    for (int i = 0; i <= 200; ++i) {
      const double value = viewer::valueAtShare(p, i / 200.0);
      EXPECT_GE(value, last) << p.path;
      last = value;
      const double share = viewer::shareOf(p, value);
      // Rounding of counts is coarse.
      const double error = p.scale == pelage::ParameterScale::kLog ? 2e-3 : 1e-2;
      EXPECT_TRUE(p.type == ParameterType::kCount || i == 0 || std::abs(share - i / 200.0) <= error)
          << p.path << " at " << i;
    }
    const double nan = std::nan("");
    EXPECT_TRUE(viewer::shareOf(p, nan) == 0) << p.path;
    EXPECT_TRUE(viewer::valueAtShare(p, nan) == p.sliderLow) << p.path;
  });
}

TEST(EditHistory, ForgetsWhatWasUndoneAndTheOldest) {
  const auto with = [](float opacity) {
    SceneSettings settings;
    settings.material.opacity = opacity;
    return settings;
  };
  EditHistory history(with(0));
  EXPECT_FALSE(history.canUndo() || history.canRedo());
  history.undo();
  history.redo();
  history.add(with(0));
  EXPECT_FALSE(history.canUndo());
  history.add(with(0.1f));
  history.add(with(0.2f));
  history.undo();
  EXPECT_EQ(history.current().material.opacity, 0.1f);
  history.add(with(0.3f));
  EXPECT_FALSE(history.canRedo());
  history.undo();
  EXPECT_EQ(history.current().material.opacity, 0.1f);
  for (int i = 0; i < 1000; ++i) history.add(with(static_cast<float>(i % 7) / 7));
  size_t steps = 0;
  for (; history.canUndo(); ++steps) history.undo();
  EXPECT_EQ(steps, EditHistory::kMaxStates - 1);
}

}  // namespace
