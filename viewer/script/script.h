// Recorded input: a text file with one event a line, docs/viewer.md.
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
#include <string>
#include <string_view>
#include <vector>

#include "input/event.h"
#include "pelage/result.h"

namespace viewer {

struct ScriptedEvent {
  uint64_t frame = 0;  ///< from 0; the events of a frame come before it is drawn
  Event event;
  bool operator==(const ScriptedEvent&) const = default;
};

/// Reads a script; `name` names it in errors. Frames rise. Errors name the line: an event that does
/// not exist, arguments that are missing, too many or out of range, a frame before the last one.
pelage::Result<std::vector<ScriptedEvent>> parseScript(std::string_view text,
                                                       std::string_view name);
pelage::Result<std::vector<ScriptedEvent>> loadScript(const std::filesystem::path& path);

/// Lines of a script for an event, with their ends; parseScript() gives the same event.
std::string scriptLines(const ScriptedEvent& event);

/// Hands out the events of a script frame by frame.
class Player {
 public:
  Player() = default;
  explicit Player(std::vector<ScriptedEvent> events) : events_(std::move(events)) {}
  /// Adds the events of a frame. Behind the last one it adds Quit. Call it with rising frames.
  void eventsOf(uint64_t frame, std::vector<Event>& events);

 private:
  std::vector<ScriptedEvent> events_;
  size_t next_ = 0;
};

/// Writes the events of a session as they come.
class Recorder {
 public:
  /// Errors: a file that cannot be written.
  static pelage::Result<Recorder> open(const std::filesystem::path& path);
  void add(const ScriptedEvent& event);

 private:
  std::ofstream file_;
};

}  // namespace viewer
