// The user interface of a window: Dear ImGui with the viewer's own input, so that a script does
// what a person does.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <string>

#include "input/event.h"
#include "window/window.h"

struct ImDrawData;

namespace viewer {

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
  /// what is beside the messages; empty for nothing.
  void build(const WindowSize& size, double seconds, const std::function<void()>& panels);
  /// Of the last build().
  ImDrawData* drawData() const;

  /// Shows a message until the user closes it, after those that are there already. One that is the
  /// last of them is not shown twice.
  void say(std::string title, std::string text);
  bool hasMessage() const { return !messages_.empty(); }

 private:
  struct Message {
    std::string title, text;
  };
  void buildMessage(const WindowSize& size);
  std::deque<Message> messages_;
  void takeKey(const KeyPressed& event);
  /// What went down since the last build() and up again: it ends with the next one, so that a short
  /// click is not lost.
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
