#include "input/script.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <sstream>
#include <utility>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr int kFunctionKeys = 25;
constexpr std::string_view kCode = "code";

struct Named {
  const char* name;
  Key key;
};
constexpr Named kNamed[] = {
    {"space", kKeySpace},         {"escape", kKeyEscape},
    {"enter", kKeyEnter},         {"tab", kKeyTab},
    {"backspace", kKeyBackspace}, {"delete", kKeyDelete},
    {"right", kKeyRight},         {"left", kKeyLeft},
    {"down", kKeyDown},           {"up", kKeyUp},
    {"home", kKeyHome},           {"end", kKeyEnd},
    {"shift", kKeyLeftShift},     {"control", kKeyLeftControl},
    {"alt", kKeyLeftAlt},         {"rightshift", kKeyRightShift},
    {"rightalt", kKeyRightAlt},   {"rightcontrol", kKeyRightControl},
};

std::optional<int> numberOf(std::string_view text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (text.empty() || code != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace

std::string keyName(Key key) {
  for (const Named& named : kNamed)
    if (named.key == key) return named.name;
  if (key >= 'A' && key <= 'Z') return {static_cast<char>(key - 'A' + 'a')};
  if (key > ' ' && key < 127 && (key < 'a' || key > 'z')) return {static_cast<char>(key)};
  if (key >= kKeyF1 && key < kKeyF1 + kFunctionKeys) return "f" + std::to_string(key - kKeyF1 + 1);
  return std::string(kCode) + std::to_string(key);
}

std::optional<Key> keyOf(std::string_view name) {
  for (const Named& named : kNamed)
    if (name == named.name) return named.key;
  if (name.size() == 1 && name[0] > ' ' && name[0] < 127)
    return name[0] >= 'a' && name[0] <= 'z' ? name[0] - 'a' + 'A' : Key{name[0]};
  if (name.starts_with('f')) {
    const auto number = numberOf(name.substr(1));
    if (number && *number >= 1 && *number <= kFunctionKeys) return kKeyF1 + *number - 1;
  }
  if (name.starts_with(kCode)) {
    const auto number = numberOf(name.substr(kCode.size()));
    if (number && *number >= 0 && *number <= kMaxKey) return *number;
  }
  return std::nullopt;
}

namespace {

constexpr const char* kButtons[] = {"left", "right", "middle"};
constexpr double kMaxWindowSize = 16384;
constexpr double kMaxPlace = 1e6;  // the mouse may leave the window
constexpr double kMaxFrames = 1e12;

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

// Splits a line into words; rest() is for names of files, which may have spaces.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    skipSpace();
    const size_t end = std::min(rest_.find_first_of(" \t"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }
  std::string_view rest() {
    skipSpace();
    while (!rest_.empty() && (rest_.back() == ' ' || rest_.back() == '\t')) rest_.remove_suffix(1);
    return std::exchange(rest_, {});
  }
  bool atEnd() {
    skipSpace();
    return rest_.empty();
  }

 private:
  void skipSpace() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }
  std::string_view rest_;
};

// Parses a finite number in a range.
std::optional<double> number(std::string_view word, double low, double high) {
  double value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, code] = std::from_chars(word.data(), end, value);
  if (code != std::errc() || stop != end || !(value >= low && value <= high)) return std::nullopt;
  return value;
}

std::optional<MouseButton> buttonOf(std::string_view name) {
  for (size_t i = 0; i < std::size(kButtons); ++i)
    if (name == kButtons[i]) return static_cast<MouseButton>(i);
  return std::nullopt;
}

// The events of a line; an error says what is wrong with it.
using Events = std::vector<Event>;
Result<Events> fail(std::string what) { return Error{ErrorCode::kInvalidFile, std::move(what)}; }

Result<Events> parseMouse(std::string_view name, Words& words) {
  if (name == "move") {
    const auto x = number(words.next(), -kMaxPlace, kMaxPlace);
    const auto y = number(words.next(), -kMaxPlace, kMaxPlace);
    if (!x || !y) return fail("'move' needs x and y in window coordinates");
    return Events{MouseMoved{*x, *y}};
  }
  if (name == "scroll") {
    const auto steps = number(words.next(), -kMaxPlace, kMaxPlace);
    if (!steps) return fail("'scroll' needs a number of steps");
    return Events{Scrolled{*steps}};
  }
  const auto button = buttonOf(words.next());
  if (!button) return fail(fmt::format("'{}' needs left, right or middle", name));
  return Events{MousePressed{*button, name == "press"}};
}

Result<Events> parseKey(std::string_view name, Words& words) {
  if (name == "text") {
    const auto code = number(words.next(), 1, 0x10ffff);
    if (!code || *code != std::floor(*code)) return fail("'text' needs a Unicode number");
    return Events{TextTyped{static_cast<uint32_t>(*code)}};
  }
  const std::string_view word = words.next();
  const auto key = keyOf(word);
  if (!key) return fail(fmt::format("there is no key '{}'", word));
  if (name == "keydown") return Events{KeyPressed{*key, true}};
  if (name == "keyup") return Events{KeyPressed{*key, false}};
  return Events{KeyPressed{*key, true}, KeyPressed{*key, false}};
}

Result<Events> parseEvent(std::string_view name, Words& words) {
  if (name == "move" || name == "scroll" || name == "press" || name == "release")
    return parseMouse(name, words);
  if (name == "key" || name == "keydown" || name == "keyup" || name == "text")
    return parseKey(name, words);
  if (name == "quit") return Events{Quit{}};
  if (name == "minimize" || name == "restore") return Events{Minimized{name == "minimize"}};
  if (name == "resize") {
    const auto width = number(words.next(), 1, kMaxWindowSize),
               height = number(words.next(), 1, kMaxWindowSize);
    if (!width || !height)
      return fail(fmt::format("'resize' needs a width and a height, 1..{}", kMaxWindowSize));
    return Events{Resized{static_cast<uint32_t>(*width), static_cast<uint32_t>(*height)}};
  }
  if (name == "drop" || name == "screenshot") {
    const std::string_view file = words.rest();
    if (file.empty()) return fail(fmt::format("'{}' needs a file", name));
    if (name == "drop") return Events{FilesDropped{{file}}};
    return Events{ScreenshotWanted{file}};
  }
  return fail(fmt::format(
      "there is no event '{}': it is move, press, release, scroll, key, keydown, keyup, text, "
      "resize, minimize, restore, drop, screenshot or quit",
      name));
}

// Appends an event. Files that are dropped in one frame become one event.
void append(std::vector<ScriptedEvent>& events, uint64_t frame, Event event) {
  auto* dropped = std::get_if<FilesDropped>(&event);
  if (dropped != nullptr && !events.empty() && events.back().frame == frame) {
    if (auto* before = std::get_if<FilesDropped>(&events.back().event)) {
      before->files.push_back(std::move(dropped->files.front()));
      return;
    }
  }
  events.push_back({frame, std::move(event)});
}

}  // namespace

Result<std::vector<ScriptedEvent>> parseScript(std::string_view text, std::string_view name) {
  std::vector<ScriptedEvent> events;
  for (size_t line = 1; !text.empty(); ++line) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!content.empty() && content.back() == '\r') content.remove_suffix(1);
    Words words(content);
    if (words.atEnd()) continue;
    const std::string_view first = words.next();
    if (first.front() == '#') continue;
    const auto refuse = [&](const std::string& what) {
      return Error{ErrorCode::kInvalidFile, fmt::format("{}:{}: {}", name, line, what)};
    };
    const auto frame = number(first, 0, kMaxFrames);
    if (!frame || *frame != std::floor(*frame))
      return refuse(fmt::format("'{}' is no number of a frame", first));
    const auto at = static_cast<uint64_t>(*frame);
    if (!events.empty() && at < events.back().frame)
      return refuse(fmt::format("frame {} comes behind frame {}", at, events.back().frame));
    Result<Events> parsed = parseEvent(words.next(), words);
    if (!parsed) return refuse(parsed.error().message);
    if (!words.atEnd()) return refuse(fmt::format("'{}' is too much", words.rest()));
    for (Event& event : *parsed) append(events, at, std::move(event));
  }
  return events;
}

Result<std::vector<ScriptedEvent>> loadScript(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file) return Error{ErrorCode::kFileNotFound, path.string() + ": the script cannot be read"};
  return parseScript(text.str(), path.string());
}

std::string scriptLines(const ScriptedEvent& scripted) {
  const auto line = [&](const std::string& what) {
    return fmt::format("{} {}\n", scripted.frame, what);
  };
  return std::visit(
      Overloaded{
          [&](const MouseMoved& e) { return line(fmt::format("move {} {}", e.x, e.y)); },
          [&](const MousePressed& e) {
            return line(fmt::format("{} {}", e.down ? "press" : "release",
                                    kButtons[static_cast<size_t>(e.button)]));
          },
          [&](const Scrolled& e) { return line(fmt::format("scroll {}", e.steps)); },
          [&](const KeyPressed& e) {
            return line(fmt::format("{} {}", e.down ? "keydown" : "keyup", keyName(e.key)));
          },
          [&](const TextTyped& e) { return line(fmt::format("text {}", e.character)); },
          [&](const Resized& e) { return line(fmt::format("resize {} {}", e.width, e.height)); },
          [&](const Minimized& e) { return line(e.minimized ? "minimize" : "restore"); },
          [&](const FilesDropped& e) {
            std::string lines;
            for (const std::filesystem::path& path : e.files)
              lines += line("drop " + path.string());
            return lines;
          },
          [&](const ScreenshotWanted& e) { return line("screenshot " + e.file.string()); },
          [&](const Quit&) { return line("quit"); },
      },
      scripted.event);
}

void Player::eventsOf(uint64_t frame, std::vector<Event>& events) {
  for (; next_ < events_.size() && events_[next_].frame <= frame; ++next_)
    events.push_back(events_[next_].event);
  if (events_.empty() || frame > events_.back().frame) events.emplace_back(Quit{});
}

Result<Recorder> Recorder::open(const std::filesystem::path& path) {
  Recorder recorder;
  recorder.file_.open(path);
  if (!recorder.file_)
    return Error{ErrorCode::kFileNotFound, path.string() + ": the recording cannot be written"};
  recorder.file_ << "# pelage-viewer --fixed-clock --script FILE\n";
  return recorder;
}

void Recorder::add(const ScriptedEvent& event) { file_ << scriptLines(event) << std::flush; }

Result<void> SessionInput::open(const std::filesystem::path& script,
                                const std::filesystem::path& record, const Resized& size) {
  if (!script.empty()) {
    auto events = loadScript(script);
    if (!events) return events.error();
    player_.emplace(*std::move(events));
  }
  if (record.empty()) return {};
  auto recorder = Recorder::open(record);
  if (!recorder) return recorder.error();
  recorder_.emplace(*std::move(recorder));
  recorder_->add({0, size});
  return {};
}

const std::vector<Event>& SessionInput::collect(Window& window) {
  events_.clear();
  window.poll(events_, window.size().hidden);
  if (player_) {
    std::erase_if(events_, [](const Event& event) { return !std::holds_alternative<Quit>(event); });
    player_->eventsOf(frame_, events_);
  }
  for (const Event& event : events_) {
    if (std::holds_alternative<Quit>(event))
      hasEnded_ = true;
    else if (recorder_)
      recorder_->add({frame_, event});
  }
  return events_;
}

}  // namespace viewer
