// Input as values: events of the window or of a script, and keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace viewer {

/// GLFW's number of a key; for printable keys it is their character: 'F'.
using Key = int;
inline constexpr Key kKeySpace = 32, kKeyEscape = 256, kKeyEnter = 257, kKeyTab = 258,
                     kKeyBackspace = 259, kKeyDelete = 261, kKeyRight = 262, kKeyLeft = 263,
                     kKeyDown = 264, kKeyUp = 265, kKeyHome = 268, kKeyEnd = 269, kKeyF1 = 290,
                     kKeyF8 = 297, kKeyF9 = 298, kKeyF10 = 299, kKeyF12 = 301, kKeyLeftShift = 340,
                     kKeyLeftControl = 341, kKeyLeftAlt = 342, kKeyRightShift = 344,
                     kKeyRightControl = 345, kKeyRightAlt = 346;
inline constexpr Key kMaxKey = 511;

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
/// The window is minimized, or restored.
struct Minimized {
  bool minimized = true;
  bool operator==(const Minimized&) const = default;
};
struct FilesDropped {
  std::vector<std::filesystem::path> files;
  bool operator==(const FilesDropped&) const = default;
};
/// Saves the picture of this frame. Only scripts have it; a person presses F12.
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
