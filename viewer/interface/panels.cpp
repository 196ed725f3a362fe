#include "interface/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <ctime>
#include <system_error>
#include <utility>

namespace viewer {

using pelage::Result;

namespace {

constexpr float kStatisticsWidth = 400;  // at scale 1
constexpr float kStatisticsHeight = 460;

void memoryLine(uint64_t bytes, const char* what) {
  text(fmt::format("{:8.1f} MiB {}", mebibytes(bytes), what));
}

void buildMemory(const Stage& stage, const Canvas& canvas) {
  const CanvasMemory memory = canvas.memory();
  const pelage::DrawBytes drawn = stage.scene().drawBytes();
  memoryLine(memory.buffers, "in buffers on the device");
  memoryLine(memory.frames, "for constants and uploads");
  for (size_t view = 0; view < drawn.views.size(); ++view)
    memoryLine(drawn.views[view], fmt::format("for view {}", view + 1).c_str());
  memoryLine(drawn.shadows, "for shadow maps");
}

}  // namespace

Result<void> StatisticsPanel::read(const Stage& stage, const pelage::BufferReader& read) {
  if (frames_++ % kReadEvery != 0) return {};
  auto statistics = stage.statistics(read);
  if (!statistics) return statistics.error();
  statistics_ = *std::move(statistics);
  return {};
}

// Lists the passes; a click on one shows its times of the last frames.
void StatisticsPanel::buildPasses(const PassHistory& history) {
  if (history.totals().empty()) {
    text("the device measures no times");
    return;
  }
  const std::vector<PassHistory::PassTime> passes = history.passes();
  const auto chosen = std::find_if(passes.begin(), passes.end(),
                                   [&](const auto& pass) { return pass.name == pass_; });
  const std::vector<float>& values = chosen == passes.end() ? history.totals() : chosen->frames;
  const float most = *std::max_element(values.begin(), values.end());
  ImGui::PlotLines(
      "##history", values.data(), static_cast<int>(values.size()), 0,
      fmt::format("{}: {:.3f} ms", chosen == passes.end() ? "all" : chosen->name, values.back())
          .c_str(),
      0, std::max(1.2f * most, 1e-3f),
      {ImGui::GetContentRegionAvail().x, 4 * ImGui::GetFontSize()});
  if (ImGui::Selectable("all passes", chosen == passes.end())) pass_.clear();
  for (const PassHistory::PassTime& pass : passes) {
    const std::string line =
        fmt::format("{:8.3f} ms {:2}x {}", pass.milliseconds, pass.passes, pass.name);
    if (ImGui::Selectable(line.c_str(), pass.name == pass_)) pass_ = pass.name;
  }
}

void StatisticsPanel::build(const Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size) {
  placeAtRight(size, kStatisticsWidth, kStatisticsHeight);
  if (ImGui::Begin("Statistics")) {
    for (const HairStatistics& hair : statistics_.hairs) {
      text(hair.name);
      for (const std::string& line : linesOf(hair)) text("  " + line);
    }
    for (const ColliderStatistics& collider : statistics_.colliders) text(lineOf(collider));
    if (statistics_.transparency)
      for (const std::string& line : linesOf(*statistics_.transparency)) text(line);
    if (stage.inspection.value == InspectedValue::kTiles)
      for (const std::string& line :
           inspectionKey(stage.inspection, stage.inspected(), stage.look.transparency).lines)
        ImGui::TextWrapped("%s", line.c_str());
    ImGui::Separator();
    buildMemory(stage, canvas);
    ImGui::Separator();
    buildPasses(history);
  }
  ImGui::End();
}

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

// Shows a folder; if it cannot be read, the current one stays.
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

// Enters the folder or opens the file of the path that was typed.
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

namespace {

// Returns the CPU time of this thread [s].
double cpuSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

bool Panels::takeShortcut(const KeyPressed& key, Stage& stage) {
  if (key.key == kKeyLeftControl || key.key == kKeyRightControl) control_ = key.down;
  if (!control_ || !key.down || (key.key != 'Z' && key.key != 'Y')) return false;
  SettingsPanel& settings = settings_[stage.side()];
  key.key == 'Z' ? settings.undo(stage) : settings.redo(stage);
  return true;
}

void Panels::takeKey(Key key) {
  if (key == kKeyTab) areShown_ = !areShown_;
  if (key == 'S') showsSettings_ = !showsSettings_;
  if (key == 'O') dialog_.toggle();
  if (key == 'I') showsStatistics_ = !showsStatistics_;
}

PanelWishes Panels::build(Stage& stage, const Canvas& canvas, const PassHistory& history,
                          const WindowSize& size, double seconds, UserInterface& interface) {
  PanelWishes wishes;
  std::vector<SettingsMessage> messages;
  const auto windows = [&] {
    buildInspectionKey(stage, size);
    std::optional<FileChoice> chosen = dialog_.build(size);
    if (areShown_) {
      wishes = buildStagePanel(stage, canvas, history, size);
      if (showsSettings_) messages = settings_[stage.side()].build(stage, size);
      if (showsStatistics_) statistics_.build(stage, canvas, history, size);
      drawGizmos(stage, size);
    }
    wishes.files = std::move(chosen);
  };
  const double before = cpuSeconds();
  interface.build(size, stage.clock.fixed ? PlayClock::kStep : seconds, windows);
  cpuSeconds_ += cpuSeconds() - before;
  ++buildCount_;
  for (SettingsMessage& message : messages)
    interface.say(std::move(message.title), std::move(message.text));
  return wishes;
}

void Panels::grant(const PanelWishes& wishes) {
  if (wishes.togglesSettings) takeKey('S');
  if (wishes.opensFiles) takeKey('O');
  if (wishes.togglesStatistics) takeKey('I');
}

Result<void> Panels::readStatistics(const Stage& stage, const pelage::BufferReader& read) {
  return showsStatistics_ && areShown_ ? statistics_.read(stage, read) : Result<void>();
}

void Panels::loadSettings(const std::filesystem::path& file, Stage& stage,
                          UserInterface& interface) {
  if (const Result<void> loaded = settings_[stage.side()].load(file, stage); !loaded)
    interface.say("The settings cannot be loaded", loaded.error().message);
}

double Panels::buildMilliseconds() const {
  return 1e3 * cpuSeconds_ / static_cast<double>(std::max<uint64_t>(buildCount_, 1));
}

}  // namespace viewer
