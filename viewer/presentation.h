// A stage on a screen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "capture/pass_times.h"
#include "options.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "reload/kernel_reload.h"
#include "screen.h"
#include "stage/stage.h"
#include "stage/stage_settings.h"
#include "window/window.h"

namespace viewer {

/// Draws the frames of a stage on a screen. It goes back to the last settings and kernels that
/// worked where others are refused, and goes on with another device where one is lost.
class Presentation {
  LiveKernels kernels_;  // outlives the canvas, which uses its code

 public:
  Screen screen;
  Stage stage;
  PassHistory history;

  /// Opens the screen, and gives the stage the look that the options and the device want. Errors:
  /// Screen::open()'s.
  pelage::Result<void> open(const Options& options);
  /// Watches kernels as LiveKernels::open() does, and compiles those of a folder at once. Errors:
  /// as there; those of Canvas::setCode().
  pelage::Result<void> openKernels(const std::filesystem::path& folder, bool scripted);

  /// Shows the first source, or the character if the files cannot be shown.
  void showFirst(const StageSource& source);
  /// Shows another source with all of it in the picture; the stage stays as it is on an error.
  void show(const StageSource& source);
  /// Stage::compare() with a message for its error.
  void compare(std::optional<pelage::Solver> right);
  void frameAll() { stage.frameAll(screen.window->size().aspect()); }
  /// Shows the error of a result. \return whether it was a success.
  bool report(const char* title, const pelage::Result<void>& result);

  /// Begins a frame, with new kernels where there are some. Errors: kDeviceLost; those of
  /// Canvas::setCode().
  pelage::Result<void> begin();
  /// Draws the frame. \param seconds since the last one. \param captures Canvas::captured() has the
  /// picture then. \return false if the settings were refused and the last good ones are back.
  /// Errors: refused settings without a way back; the device's.
  pelage::Result<bool> draw(const WindowSize& size, double seconds, bool captures);
  /// The frame is complete.
  void end();
  /// Loses the device as a driver does, with a state of the hair to go on from.
  pelage::Result<void> loseDevice();
  /// Makes another device after a loss. Errors: those of Screen::open(); `lost` itself after
  /// several losses in a row.
  pelage::Result<void> recover(const pelage::Error& lost);
  /// Reads buffers of the scene back.
  pelage::BufferReader reader() {
    return [this](pelage::BufferId buffer) { return screen.canvas->read(buffer); };
  }

 private:
  void adoptDevice();
  bool goesBack(const pelage::Error& refused, WaysBack& ways);
  pelage::Result<void> takeKernels(const KernelBuild& build);
  pelage::Result<void> useCode(std::shared_ptr<const KernelTables> code);
  bool keepsOldKernels(const pelage::Error& refused);

  GoodSettings good_;
  uint32_t losses_ = 0;      // of the device, in a row
  uint32_t coarseness_ = 1;  // CanvasFrame::coarseness
  bool hasFrames_ = false;
};

}  // namespace viewer
