#include "input/keys.h"

#include <charconv>

namespace viewer {
namespace {

constexpr Key kKeyF1 = 290;
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

bool startsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
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
  if (startsWith(name, "f")) {
    const auto number = numberOf(name.substr(1));
    if (number && *number >= 1 && *number <= kFunctionKeys) return kKeyF1 + *number - 1;
  }
  if (startsWith(name, kCode)) {
    const auto number = numberOf(name.substr(kCode.size()));
    if (number && *number >= 0 && *number <= kMaxKey) return *number;
  }
  return std::nullopt;
}

}  // namespace viewer
