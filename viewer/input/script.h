// Input of a session, and its scripts: text files with one event a line, docs/viewer.md.
//
//     # frame event arguments
//     0 move 320 240
//     0 press left
//     4 move 400 250
//     5 release left
//     6 key space
//     8 screenshot picture.png
//     9 quit
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/event.h"
#include "pelage/result.h"
#include "window/window.h"

namespace viewer {

/// Returns the name of a key: "space", "f", "f12"; "code348" for a key without a name.
std::string keyName(Key key);
/// Returns the key with a name; nothing for other words.
std::optional<Key> keyOf(std::string_view name);

struct ScriptedEvent {
  uint64_t frame = 0;  ///< from 0; the events are handled before the frame is drawn
  Event event;
  bool operator==(const ScriptedEvent&) const = default;
};

/// Parses a script; errors begin with `name` and the line. Frame numbers must not decrease. Errors:
/// an unknown event; missing, surplus or invalid arguments; a frame number below the last one.
pelage::Result<std::vector<ScriptedEvent>> parseScript(std::string_view text,
                                                       std::string_view name);
pelage::Result<std::vector<ScriptedEvent>> loadScript(const std::filesystem::path& path);

/// Returns the lines of a script for an event, each with its newline; parseScript() returns the
/// same event.
std::string scriptLines(const ScriptedEvent& event);

/// Hands out the events of a script frame by frame.
class Player {
 public:
  Player() = default;
  explicit Player(std::vector<ScriptedEvent> events) : events_(std::move(events)) {}
  /// Adds the events of a frame. After the last frame it adds Quit. Call it with increasing frames.
  void eventsOf(uint64_t frame, std::vector<Event>& events);

 private:
  std::vector<ScriptedEvent> events_;
  size_t next_ = 0;
};

/// Writes the events of a session as they happen.
class Recorder {
 public:
  /// Errors: a file that cannot be written.
  static pelage::Result<Recorder> open(const std::filesystem::path& path);
  void add(const ScriptedEvent& event);

 private:
  std::ofstream file_;
};

/// The input of a session, frame by frame: the events of a window, or of a script that has the
/// window to itself.
class SessionInput {
 public:
  /// Reads a script and begins a recording, where files are named. \param size of the window, for
  /// the recording. Errors: those of loadScript() and Recorder::open().
  pelage::Result<void> open(const std::filesystem::path& script,
                            const std::filesystem::path& record, const Resized& size);
  /// Returns the events of this frame, and records them. While a script plays, a person can only
  /// close the window.
  const std::vector<Event>& collect(Window& window);
  void endFrame() { ++frame_; }
  uint64_t frame() const { return frame_; }
  bool isScripted() const { return player_.has_value(); }
  /// Whether the user or the script has quit.
  bool hasEnded() const { return hasEnded_; }

 private:
  std::optional<Player> player_;
  std::optional<Recorder> recorder_;
  std::vector<Event> events_;
  uint64_t frame_ = 0;
  bool hasEnded_ = false;
};

}  // namespace viewer
