// Scripts of the viewer: scripts that were written can be read, and errors name the line.
#include "input/script.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "input/event.h"
#include "support/errors.h"

namespace {

using pelage::test::expectError;
using pelage::test::required;
using viewer::Event;
using viewer::parseScript;
using viewer::ScriptedEvent;

std::vector<ScriptedEvent> everyEvent() {
  return {{0, viewer::Resized{640, 480}},
          {0, viewer::MouseMoved{-3.25, 1e5}},
          {1, viewer::MousePressed{viewer::MouseButton::kMiddle, true}},
          {1, viewer::MousePressed{viewer::MouseButton::kMiddle, false}},
          {2, viewer::Scrolled{-0.1}},
          {3, viewer::KeyPressed{'F', true}},
          {3, viewer::KeyPressed{'F', false}},
          {3, viewer::KeyPressed{348, true}},
          {3, viewer::TextTyped{0x20ac}},
          {4, viewer::Minimized{true}},
          {4, viewer::Minimized{false}},
          {5, viewer::FilesDropped{{"a file.tfx", "b.tfxmesh"}}},
          {5, viewer::ScreenshotWanted{"picture of it.png"}},
          {900, viewer::Quit{}}};
}

TEST(Script, WhatIsWrittenIsRead) {
  const std::vector<ScriptedEvent> events = everyEvent();
  std::string text;
  for (const ScriptedEvent& event : events) text += scriptLines(event);
  const auto read = required(parseScript(text, "script"));
  ASSERT_EQ(read->size(), events.size());
  for (size_t i = 0; i < events.size(); ++i) EXPECT_EQ((*read)[i], events[i]) << i;
}

TEST(Script, EveryKeyHasAName) {
  for (viewer::Key key = 0; key <= viewer::kMaxKey; ++key)
    EXPECT_EQ(viewer::keyOf(viewer::keyName(key)), key) << viewer::keyName(key);
}

TEST(Script, CommentsAndEmptyLinesAreNothing) {
  const auto read = required(parseScript("# words\r\n\r\n  \t\n 7 key space\r\n", "script"));
  const std::vector<ScriptedEvent> expected = {{7, viewer::KeyPressed{viewer::kKeySpace, true}},
                                               {7, viewer::KeyPressed{viewer::kKeySpace, false}}};
  EXPECT_EQ(*read, expected);
}

TEST(Script, WhatIsWrongIsNamedWithItsLine) {
  const struct {
    const char* text;
    const char* message;
  } kCases[] = {
      {"\nmove 1 2", "s:2: 'move' is no number of a frame"},
      {"1.5 quit", "no number of a frame"},
      {"-1 quit", "no number of a frame"},
      {"nan quit", "no number of a frame"},
      {"4 quit\n3 quit", "s:2: frame 3 comes behind frame 4"},
      {"0 jump", "there is no event 'jump'"},
      {"0", "there is no event ''"},
      {"0 move 1", "needs x and y"},
      {"0 move nan 1", "needs x and y"},
      {"0 move 1e9 1", "needs x and y"},
      {"0 press fire", "needs left, right or middle"},
      {"0 scroll inf", "needs a number of steps"},
      {"0 key nokey", "there is no key 'nokey'"},
      {"0 text 1.5", "needs a Unicode number"},
      {"0 resize 0 10", "needs a width and a height"},
      {"0 resize 10 99999", "needs a width and a height"},
      {"0 drop ", "'drop' needs a file"},
      {"0 quit now", "'now' is too much"},
  };
  for (const auto& [text, message] : kCases) {
    expectError(parseScript(text, "s"), {message});
  }
}

TEST(Script, EventsComeInTheirFrameAndThenItEnds) {
  viewer::Player player({{1, viewer::Scrolled{1}}, {1, viewer::Scrolled{2}}});
  const size_t expected[] = {0, 2, 1};
  for (uint64_t frame = 0; frame < 3; ++frame) {
    std::vector<Event> events;
    player.eventsOf(frame, events);
    ASSERT_EQ(events.size(), expected[frame]) << frame;
    EXPECT_EQ(!events.empty() && std::holds_alternative<viewer::Quit>(events.back()), frame == 2);
  }
}

}  // namespace
