#include "interface/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <ctime>
#include <system_error>
#include <utility>

#include "interface/help.h"

namespace viewer {

using pelage::Result;

namespace {

constexpr double kAveraged = 0.5;  // [s]

void memoryLine(uint64_t bytes, const char* what) {
  textWithValue(what, fmt::format("{:.1f} MiB", mebibytes(bytes)));
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
    const std::string value = fmt::format("{}x   {:.3f} ms", pass.passes, pass.milliseconds);
    if (ImGui::Selectable(pass.name.c_str(), pass.name == pass_)) pass_ = pass.name;
    ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(value.c_str()).x);
    text(value);
  }
}

void StatisticsPanel::build(const Stage& stage, const Canvas& canvas, const PassHistory& history) {
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

void FileDialog::toggle() {
  isOpen_ = !isOpen_;
  if (!isOpen_) return;
  std::error_code ignored;
  enter(folder_.empty() ? std::filesystem::current_path(ignored) : folder_);
  wantsFocus_ = true;
}

// Shows a folder; if it cannot be read, the current one stays.
void FileDialog::enter(const std::filesystem::path& folder) {
  auto list = listFolder(folder);
  error_ = list ? std::string() : list.error().message;
  if (!list) return;
  list_ = *std::move(list);
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
  if (list_.fileCount == 0) ImGui::TextWrapped("%s", reasonForNoFiles(list_).c_str());
  if (ImGui::Selectable("..")) next = folder_.parent_path();
  for (const FolderEntry& entry : list_.entries) {
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

std::optional<FileChoice> FileDialog::build() {
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

void FrameTimes::add(double seconds, const PassHistory& history) {
  seconds_ += seconds;
  ++frames_;
  if (!history.totals().empty()) gpuMilliseconds_ += static_cast<double>(history.totals().back());
  if (!text_.empty() && seconds_ < kAveraged) return;
  const double rate = frames_ / std::max(seconds_, 1e-6);
  text_ = rate < 10 ? fmt::format("{:.2g} frames/s", rate) : fmt::format("{:.0f} frames/s", rate);
  if (!history.totals().empty())
    text_ += fmt::format(", GPU {:.2f} ms", gpuMilliseconds_ / frames_);
  seconds_ = gpuMilliseconds_ = 0;
  frames_ = 0;
}

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
  if (key == kKeyF1) showsHelp_ = !showsHelp_;
}

PanelWishes Panels::build(Stage& stage, const Canvas& canvas, const PassHistory& history,
                          const WindowSize& size, double seconds, UserInterface& interface) {
  PanelWishes wishes;
  std::vector<SettingsMessage> messages;
  times_.add(seconds, history);
  const auto windows = [&] {
    buildInspectionKey(stage, size, areShown_);
    layout_.begin(size, {areShown_ && showsSettings_, areShown_ && showsStatistics_, showsHelp_,
                         dialog_.isOpen()});
    std::optional<FileChoice> chosen;
    if (dialog_.isOpen()) {
      layout_.place(SideWindow::kFiles);
      chosen = dialog_.build();
    }
    if (showsHelp_) {
      layout_.place(SideWindow::kHelp);
      showsHelp_ = buildHelp();
    }
    if (areShown_) {
      wishes = buildStagePanel(stage, canvas, history, size, times_.text());
      if (showsSettings_) {
        layout_.place(SideWindow::kSettings);
        messages = settings_[stage.side()].build(stage);
      }
      if (showsStatistics_) {
        layout_.place(SideWindow::kStatistics);
        statistics_.build(stage, canvas, history);
      }
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
  if (wishes.togglesHelp) takeKey(kKeyF1);
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
