#include "interface/file_dialog.h"

#include <imgui.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace viewer {

namespace {

constexpr float kDialogWidth = 420;  // at scale 1
constexpr float kDialogHeight = 360;

}  // namespace

void FileDialog::toggle() {
  isOpen_ = !isOpen_;
  if (!isOpen_) return;
  std::error_code ignored;
  enter(folder_.empty() ? std::filesystem::current_path(ignored) : folder_);
  wantsFocus_ = true;
}

// A folder that cannot be read leaves the one that is shown.
void FileDialog::enter(const std::filesystem::path& folder) {
  auto entries = listFolder(folder);
  error_ = entries ? std::string() : entries.error().message;
  if (!entries) return;
  entries_ = *std::move(entries);
  folder_ = folder;
  chosen_.clear();
  const std::string text = folder.string();
  path_ = {};
  std::copy_n(text.begin(), std::min(text.size(), path_.size() - 1), path_.begin());
}

// The path that was typed: a folder is entered, a file is opened.
std::optional<FileChoice> FileDialog::takePath() {
  std::error_code ignored;
  const std::filesystem::path path = folder_ / path_.data();
  if (!std::filesystem::is_regular_file(path, ignored)) {
    enter(path.lexically_normal());
    return std::nullopt;
  }
  isOpen_ = false;
  return FileChoice{{path}, false};
}

void FileDialog::buildEntries() {
  std::filesystem::path next;
  if (ImGui::Selectable("..")) next = folder_.parent_path();
  for (const FolderEntry& entry : entries_) {
    const std::string label = entry.isFolder ? entry.name + "/" : entry.name;
    const bool chosen = chosen_.contains(entry.name);
    if (!ImGui::Selectable(label.c_str(), chosen)) continue;
    if (entry.isFolder)
      next = folder_ / entry.name;
    else if (chosen)
      chosen_.erase(entry.name);
    else
      chosen_.insert(entry.name);
  }
  if (!next.empty()) enter(next);
}

std::optional<FileChoice> FileDialog::build(const WindowSize& size) {
  if (!isOpen_) return std::nullopt;
  const float scale = size.interfaceScale;
  const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
  ImGui::SetNextWindowPos({width / 2, height / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(kDialogWidth * scale, width), std::min(kDialogHeight * scale, height)},
      ImGuiCond_Appearing);
  std::optional<FileChoice> choice;
  if (ImGui::Begin("Open files", &isOpen_, ImGuiWindowFlags_NoCollapse)) {
    if (std::exchange(wantsFocus_, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1);
    if (ImGui::InputText("##path", path_.data(), path_.size(),
                         ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll))
      choice = takePath();
    if (!error_.empty()) ImGui::TextWrapped("%s", error_.c_str());
    ImGui::BeginChild("entries", {0, -1.5f * ImGui::GetFrameHeight()}, true);
    buildEntries();
    ImGui::EndChild();
    const bool opens = ImGui::Button("Open");
    ImGui::SameLine();
    const bool adds = ImGui::Button("Add to the scene");
    if ((opens || adds) && !chosen_.empty()) {
      choice = FileChoice{{}, adds};
      for (const std::string& name : chosen_) choice->files.push_back(folder_ / name);
      isOpen_ = false;
    }
  }
  ImGui::End();
  return choice;
}

}  // namespace viewer
