// The program: joins window, canvas, interface, stage and script.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "canvas/canvas.h"
#include "capture/recording.h"
#include "capture/times_file.h"
#include "interface/file_dialog.h"
#include "interface/pass_history.h"
#include "interface/settings_panel.h"
#include "interface/stage_panel.h"
#include "interface/statistics_panel.h"
#include "interface/user_interface.h"
#include "options.h"
#include "pelage/result.h"
#include "reload/kernel_reload.h"
#include "script/script.h"
#include "stage/controls.h"
#include "stage/good_settings.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

class Viewer {
 public:
  explicit Viewer(Options options) : options_(std::move(options)) {}
  /// Opens the window and shows what the options name. Errors: no display, no device; a script
  /// that cannot be read. Files that cannot be shown are a message in the window.
  pelage::Result<void> open();
  /// Until the user quits. Errors: the device fails and does not come back; a screenshot that
  /// cannot be written, in a script; messages of the validation.
  pelage::Result<void> run();

 private:
  pelage::Result<void> openApi(pelage::Api api);
  pelage::Result<void> openAnyApi();
  void showFirst();
  void show(const StageSource& source);
  /// \param adds hair beside the hair that is there, not in place of it.
  void drop(std::vector<std::filesystem::path> files, bool adds = false);
  void compare(std::optional<pelage::Solver> right);
  void compareSolvers();
  SettingsPanel& settings() { return settings_[stage_.side()]; }
  void loadSettings(const std::filesystem::path& file);
  bool takeShortcut(const KeyPressed& key);
  void collect();
  pelage::Result<void> take(const Event& event);
  pelage::Result<void> setTarget(const WindowSize& size);
  pelage::Result<void> drawFrame(const WindowSize& size);
  bool goesBack(const pelage::Error& refused);
  pelage::Result<void> grant(const PanelWishes& wishes);
  pelage::Result<void> loseDevice();
  pelage::Result<void> saveScreenshot();
  pelage::Result<void> openCaptures();
  void toggleRecording();
  void toggleTimes();
  pelage::Result<void> record();
  void endRecording();
  pelage::Result<void> openReload();
  pelage::Result<void> reloadKernels();
  pelage::Result<void> takeKernels(const KernelBuild& build);
  pelage::Result<void> useCode(std::shared_ptr<const KernelTables> code);
  bool keepsOldKernels(const pelage::Error& refused);
  pelage::Result<void> recoverDevice(const pelage::Error& lost);
  void adopt();

  Options options_;
  // Code of kernels that were compiled meanwhile; nothing: the program's own.
  std::shared_ptr<const KernelTables> code_, provenCode_;  // a frame has run with the latter
  std::unique_ptr<KernelReload> reload_;
  // The order in which they come; they go in the opposite one.
  std::unique_ptr<Window> window_;
  std::unique_ptr<UserInterface> interface_;
  std::unique_ptr<Canvas> canvas_;
  Stage stage_;
  GoodSettings good_;
  StageControls controls_;
  std::array<SettingsPanel, 2> settings_;  // [side]
  StatisticsPanel statistics_;
  FileDialog dialog_;
  std::optional<Player> player_;
  std::optional<Recorder> recorder_;
  std::vector<Event> events_;
  PassHistory history_;
  std::filesystem::path screenshot_;  // of this frame
  std::unique_ptr<Recording> recording_;
  std::optional<TimesFile> times_;
  std::chrono::steady_clock::time_point last_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double opened_ = 0, shown_ = 0, firstPicture_ = 0;  // [s] since start_
  double interfaceSeconds_ = 0;                       // of the CPU, in builtFrames_ frames
  uint64_t frame_ = 0, builtFrames_ = 0;
  uint32_t losses_ = 0;  // of the device, in a row
  bool quits_ = false, showsPanel_ = true, showsSettings_ = false, showsStatistics_ = false,
       wantsScreenshot_ = false;
  bool control_ = false;  // its key is down
};

}  // namespace viewer
