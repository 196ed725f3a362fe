// Window, interface and canvas of one graphics API.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "canvas/canvas.h"
#include "interface/user_interface.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "window/window.h"

namespace viewer {

struct ScreenDef {
  std::optional<pelage::Api> api;  ///< nothing: Vulkan, or OpenGL where there is none
  int device = -1;                 ///< CanvasDef::deviceIndex
  bool validation = false;
  uint32_t width = 1280, height = 800;  ///< window coordinates
  bool vsync = true;
  std::filesystem::path cache;  ///< CanvasDef::cache
};

/// Threads: the main one.
class Screen {
 public:
  /// Opens all three with the API of the definition. Without one, OpenGL stands in for a Vulkan
  /// that cannot be used, and a message says so. Errors: those of Window::create() and
  /// createCanvas().
  pelage::Result<void> open(const ScreenDef& def);
  /// Opens all three again with the same API, after a loss of the device.
  pelage::Result<void> reopen() { return openApi(*def_.api); }

  // Made in this order, destroyed in reverse.
  std::unique_ptr<Window> window;
  std::unique_ptr<UserInterface> interface;
  std::unique_ptr<Canvas> canvas;

 private:
  pelage::Result<void> openApi(pelage::Api api);
  ScreenDef def_;
};

}  // namespace viewer
