#include "window/window.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <utility>

#include "input/event.h"
#include "window/glfw.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr double kWait = 0.1;                            // s; of poll()
constexpr std::chrono::milliseconds kDisplayTime{2000};  // maximum time of a display

// Returns the last error of GLFW.
std::string problem() {
  const char* text = nullptr;
  return glfwGetError(&text) != GLFW_NO_ERROR && text != nullptr ? text : "no reason is known";
}

std::vector<Event>& eventsOf(GLFWwindow* window) {
  return *static_cast<std::vector<Event>*>(glfwGetWindowUserPointer(window));
}

std::optional<MouseButton> buttonOf(int button) {
  if (button == GLFW_MOUSE_BUTTON_LEFT) return MouseButton::kLeft;
  if (button == GLFW_MOUSE_BUTTON_RIGHT) return MouseButton::kRight;
  if (button == GLFW_MOUSE_BUTTON_MIDDLE) return MouseButton::kMiddle;
  return std::nullopt;
}

// Waits for the display. \return whether the condition holds in time.
template <class Condition>
bool waitUntil(Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + kDisplayTime;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    glfwWaitEventsTimeout(0.01);
  }
  return true;
}

}  // namespace

Result<std::unique_ptr<Window>> Window::create(const WindowDef& def) {
  if (glfwInit() != GLFW_TRUE) {
    return Error{ErrorCode::kUnsupported,
                 "there is no display to open a window on (" + problem() +
                     "): start it in a desktop session or under xvfb-run, or use pelage-headless"};
  }
  std::unique_ptr<Window> window(new Window);
  glfwDefaultWindowHints();
  const bool gl = def.api != pelage::Api::kVulkan;
  glfwWindowHint(GLFW_CLIENT_API, gl ? GLFW_OPENGL_API : GLFW_NO_API);
  if (gl) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, def.debug ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
  }
  window->window_ = glfwCreateWindow(static_cast<int>(def.width), static_cast<int>(def.height),
                                     def.title.c_str(), nullptr, nullptr);
  if (window->window_ == nullptr) {
    const std::string why = problem();
    if (!gl) return Error{ErrorCode::kUnsupported, "the display opens no window (" + why + ")"};
    return Error{ErrorCode::kUnsupported,
                 "the display opens no window with OpenGL 4.5 (" + why +
                     "). On Debian: apt-get install libgl1-mesa-dri, or the driver of the GPU; or "
                     "use --api vulkan"};
  }
  if (gl) {
    glfwMakeContextCurrent(window->window_);
    glfwSwapInterval(def.vsync ? 1 : 0);
  }
  window->listen();
  return window;
}

Window::~Window() {
  if (window_ != nullptr) glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::listen() {
  glfwSetWindowUserPointer(window_, &events_);
  glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
    eventsOf(window).emplace_back(MouseMoved{x, y});
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
    if (const auto known = buttonOf(button))
      eventsOf(window).emplace_back(MousePressed{*known, action == GLFW_PRESS});
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double y) {
    eventsOf(window).emplace_back(Scrolled{y});
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    if (key >= 0 && key <= kMaxKey && action != GLFW_REPEAT)
      eventsOf(window).emplace_back(KeyPressed{key, action == GLFW_PRESS});
  });
  glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned int character) {
    eventsOf(window).emplace_back(TextTyped{character});
  });
  glfwSetWindowSizeCallback(window_, [](GLFWwindow* window, int width, int height) {
    if (width > 0 && height > 0)
      eventsOf(window).emplace_back(
          Resized{static_cast<uint32_t>(width), static_cast<uint32_t>(height)});
  });
  glfwSetWindowIconifyCallback(window_, [](GLFWwindow* window, int minimized) {
    eventsOf(window).emplace_back(Minimized{minimized == GLFW_TRUE});
  });
  glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
    eventsOf(window).emplace_back(FilesDropped{{paths, paths + count}});
  });
  glfwSetWindowCloseCallback(window_,
                             [](GLFWwindow* window) { eventsOf(window).emplace_back(Quit{}); });
}

void Window::poll(std::vector<Event>& events, bool wait) {
  if (wait)
    glfwWaitEventsTimeout(kWait);
  else
    glfwPollEvents();
  events.insert(events.end(), std::make_move_iterator(events_.begin()),
                std::make_move_iterator(events_.end()));
  events_.clear();
}

WindowSize Window::size() const {
  int width = 0, height = 0, pixelWidth = 0, pixelHeight = 0;
  glfwGetWindowSize(window_, &width, &height);
  glfwGetFramebufferSize(window_, &pixelWidth, &pixelHeight);
  WindowSize size;
  size.width = static_cast<uint32_t>(std::max(width, 0));
  size.height = static_cast<uint32_t>(std::max(height, 0));
  size.pixelWidth = static_cast<uint32_t>(std::max(pixelWidth, 0));
  size.pixelHeight = static_cast<uint32_t>(std::max(pixelHeight, 0));
  size.hidden = glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE || width <= 0 ||
                height <= 0 || pixelWidth <= 0 || pixelHeight <= 0;
  float scaleX = 1, scaleY = 1;
  glfwGetWindowContentScale(window_, &scaleX, &scaleY);
  // If a window has several pixels per coordinate, the picture is scaled already.
  if (!size.hidden)
    size.interfaceScale =
        std::clamp(scaleX * static_cast<float>(width) / static_cast<float>(pixelWidth), 0.5f, 4.0f);
  return size;
}

Result<void> Window::resize(uint32_t width, uint32_t height) {
  glfwSetWindowSize(window_, static_cast<int>(width), static_cast<int>(height));
  if (waitUntil([&] { return size().width == width && size().height == height; })) return {};
  return Error{ErrorCode::kDevice,
               fmt::format("the window is {} x {}, and the display does not make it {} x {}",
                           size().width, size().height, width, height)};
}

Result<void> Window::minimize(bool minimized) {
  minimized ? glfwIconifyWindow(window_) : glfwRestoreWindow(window_);
  if (waitUntil(
          [&] { return (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE) == minimized; }))
    return {};
  return Error{ErrorCode::kDevice, fmt::format("the display does not {} the window",
                                               minimized ? "minimize" : "restore")};
}

void Window::setTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

void Window::swapBuffers() { glfwSwapBuffers(window_); }

}  // namespace viewer
