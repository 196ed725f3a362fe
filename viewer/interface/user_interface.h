// The user interface of a window: Dear ImGui with events of the viewer, so that scripts work as a
// person does.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <string>

#include "input/event.h"
#include "window/window.h"

struct ImDrawData;

namespace viewer {

/// Writes a line into the current window.
void text(const std::string& line);
/// Writes a line with a value at the right end.
void textWithValue(const std::string& line, const std::string& value);
/// Writes the name of the next item at the left. The item gets the rest of the width.
void rowName(const char* label);
/// Builds a slider with its name at the left and its value at the right, where its grab does not
/// cover it. The value stays in the range. \param format of the value with its unit: "%.1f m/s".
/// \return whether it changed.
bool slider(const char* label, float& value, float low, float high, const char* format,
            bool logarithmic = false);

class UserInterface {
 public:
  /// Makes the ImGui context. \param scale WindowSize::interfaceScale.
  explicit UserInterface(float scale);
  ~UserInterface();
  UserInterface(const UserInterface&) = delete;
  UserInterface& operator=(const UserInterface&) = delete;

  /// Takes an event. \return whether it belongs to the interface alone.
  bool take(const Event& event);
  /// Builds the interface of a frame. \param seconds since the last one, > 0. \param panels builds
  /// the panels under the messages; may be empty.
  void build(const WindowSize& size, double seconds, const std::function<void()>& panels);
  /// Draws of the last build().
  ImDrawData* drawData() const;

  /// Queues a message, which is shown until the user closes it. A repetition of the newest message
  /// is ignored.
  void say(std::string title, std::string text);
  bool hasMessage() const { return !messages_.empty(); }

 private:
  struct Message {
    std::string title, text;
  };
  void buildMessage(const WindowSize& size);
  std::deque<Message> messages_;
  void takeKey(const KeyPressed& event);
  /// A key or button that went down and up between two builds: it stays down for one build(), so
  /// that short clicks are not lost.
  struct Press {
    bool began = false, ends = false;
    void down(bool& state);
    void up(bool& state);
    void built(bool& state);
  };
  Press buttons_[3];
  std::array<Press, 512> keys_;
};

}  // namespace viewer
