#include "interface/settings_panel.h"

#include <imgui.h>

#include <algorithm>
#include <utility>

#include "pelage/settings/settings_file.h"
#include "stage/stage_settings.h"

namespace viewer {

using pelage::Result;
using pelage::SceneSettings;

// Begins new histories when the stage shows another scene.
void SettingsPanel::follow(const Stage& stage) {
  if (shown_ == stage.shown()) return;
  shown_ = stage.shown();
  hair_ = 0;
  histories_.clear();
  for (size_t i = 0; i < stage.hairs().size(); ++i) histories_.emplace_back(settingsOf(stage, i));
}

void SettingsPanel::undo(Stage& stage) {
  follow(stage);
  EditHistory& history = histories_[hair_];
  // Changes by the panel at the left become a state as well.
  history.add(settingsOf(stage, hair_));
  history.undo();
  (void)apply(history.current(), hair_, stage);
}

void SettingsPanel::redo(Stage& stage) {
  follow(stage);
  if (!histories_[hair_].canRedo()) return;
  histories_[hair_].redo();
  (void)apply(histories_[hair_].current(), hair_, stage);
}

Result<void> SettingsPanel::load(const std::filesystem::path& file, Stage& stage) {
  const auto loaded = pelage::SettingsFile::load(file);
  if (!loaded) return loaded.error();
  follow(stage);
  for (size_t i = 0; i < stage.hairs().size(); ++i) {
    SceneSettings settings = settingsOf(stage, i);
    loaded->apply(settings);
    if (Result<void> done = apply(settings, i, stage); !done) return done;
  }
  for (size_t i = 0; i < stage.hairs().size(); ++i) histories_[i].add(settingsOf(stage, i));
  return {};
}

void SettingsPanel::buildHair(const Stage& stage) {
  if (stage.hairs().size() < 2) return;
  const auto name = [&](size_t i) { return stage.scene().hair(stage.hairs()[i]).name(); };
  if (!ImGui::BeginCombo("Hair", name(hair_).c_str())) return;
  for (size_t i = 0; i < stage.hairs().size(); ++i)
    if (ImGui::Selectable(name(i).c_str(), i == hair_)) hair_ = i;
  ImGui::EndCombo();
}

void SettingsPanel::buildFile(Stage& stage, std::vector<SettingsMessage>& messages) {
  EditHistory& history = histories_[hair_];
  if (ImGui::Button("Undo") && history.canUndo()) undo(stage);
  ImGui::SameLine();
  if (ImGui::Button("Redo")) redo(stage);
  ImGui::SameLine();
  if (ImGui::Button("Copy as C++"))
    ImGui::SetClipboardText(pelage::settingsSnippet(settingsOf(stage, hair_)).c_str());
  ImGui::InputText("File", file_, sizeof file_);
  if (ImGui::Button("Load"))
    if (const Result<void> done = load(file_, stage); !done)
      messages.push_back({"The settings cannot be loaded", done.error().message});
  ImGui::SameLine();
  if (ImGui::Button("Save"))
    if (const Result<void> done = saveSettings(file_, settingsOf(stage, hair_)); !done)
      messages.push_back({"The settings cannot be saved", done.error().message});
  ImGui::Separator();
}

std::vector<SettingsMessage> SettingsPanel::build(Stage& stage) {
  std::vector<SettingsMessage> messages;
  follow(stage);
  if (histories_.empty()) return messages;
  if (ImGui::Begin("Settings")) {
    buildHair(stage);
    buildFile(stage, messages);
    const pelage::HairObject& hair = stage.scene().hair(stage.hairs()[hair_]);
    if (hair.limpGuideCount() > 0)
      ImGui::TextWrapped("%u of %u guides are too limp for this sagCompensation, and sag.",
                         hair.limpGuideCount(), hair.guideCount());
    SceneSettings settings = settingsOf(stage, hair_);
    const PanelChange change = drawParameters(panel_, settings);
    if (change.changed())
      if (const Result<void> done = apply(settings, hair_, stage); !done)
        messages.push_back({"The settings cannot be used", done.error().message});
    if (change.finished) histories_[hair_].add(settingsOf(stage, hair_));
  }
  ImGui::End();
  return messages;
}

}  // namespace viewer
