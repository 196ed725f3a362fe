// The window: its size, and what a person does to it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "input/event.h"
#include "pelage/headless.h"
#include "pelage/result.h"

struct GLFWwindow;

namespace viewer {

struct WindowDef {
  std::string title = "pelage";
  uint32_t width = 1280, height = 800;     ///< window coordinates, 1..16384
  pelage::Api api = pelage::Api::kVulkan;  ///< kGl: with a context, which is current
  bool debug = false;                      ///< GL: a debug context
  bool vsync = true;                       ///< GL: swaps wait for the screen
};

struct WindowSize {
  uint32_t width = 0, height = 0;  ///< window coordinates
  uint32_t pixelWidth = 0, pixelHeight = 0;
  /// Size of text and controls: 2 on a screen with twice the usual pixels per inch.
  float interfaceScale = 1;
  bool hidden = false;  ///< the window is minimized, or has no pixels
  /// Width over height.
  float aspect() const {
    return static_cast<float>(std::max(width, 1u)) / static_cast<float>(std::max(height, 1u));
  }
};

/// Threads: the main one.
class Window {
 public:
  /// Errors: no display; kUnsupported: the display has no OpenGL 4.5.
  static pelage::Result<std::unique_ptr<Window>> create(const WindowDef& def);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Adds the events since the last call. \param wait sleeps until there is an event, at most a
  /// tenth of a second.
  void poll(std::vector<Event>& events, bool wait);
  WindowSize size() const;
  /// Resizes the window, and waits for it. Error: the display refuses the size.
  pelage::Result<void> resize(uint32_t width, uint32_t height);
  /// Minimizes or restores the window, and waits for it. Error: the display does not do it.
  pelage::Result<void> minimize(bool minimized);
  void setTitle(const std::string& title);
  /// Shows the picture that was drawn with OpenGL.
  void swapBuffers();
  GLFWwindow* handle() const { return window_; }

 private:
  Window() = default;
  void listen();
  GLFWwindow* window_ = nullptr;
  std::vector<Event> events_;
};

}  // namespace viewer
