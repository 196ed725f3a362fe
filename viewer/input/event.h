// What a person does to the window, as values: from the window, from a script, into a recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace viewer {

/// Keys as GLFW numbers them, so that printable ones are their character: 'F'.
using Key = int;

enum class MouseButton : uint8_t { kLeft, kRight, kMiddle };

struct MouseMoved {
  double x = 0, y = 0;  ///< in window coordinates, from the top left
  bool operator==(const MouseMoved&) const = default;
};
struct MousePressed {
  MouseButton button = MouseButton::kLeft;
  bool down = true;
  bool operator==(const MousePressed&) const = default;
};
struct Scrolled {
  double steps = 0;  ///< > 0: away from the user
  bool operator==(const Scrolled&) const = default;
};
struct KeyPressed {
  Key key = 0;
  bool down = true;
  bool operator==(const KeyPressed&) const = default;
};
struct TextTyped {
  uint32_t character = 0;  ///< Unicode
  bool operator==(const TextTyped&) const = default;
};
struct Resized {
  uint32_t width = 0, height = 0;  ///< window coordinates
  bool operator==(const Resized&) const = default;
};
/// The window goes to the task bar, or comes back.
struct Minimized {
  bool minimized = true;
  bool operator==(const Minimized&) const = default;
};
struct FilesDropped {
  std::vector<std::filesystem::path> files;
  bool operator==(const FilesDropped&) const = default;
};
/// Saves the picture of this frame. Only scripts have it; the key F12 is the same for a person.
struct ScreenshotWanted {
  std::filesystem::path file;
  bool operator==(const ScreenshotWanted&) const = default;
};
struct Quit {
  bool operator==(const Quit&) const = default;
};

using Event = std::variant<MouseMoved, MousePressed, Scrolled, KeyPressed, TextTyped, Resized,
                           Minimized, FilesDropped, ScreenshotWanted, Quit>;

}  // namespace viewer
