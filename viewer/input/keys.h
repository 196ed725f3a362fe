// Names of keys, as scripts have them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "input/event.h"

namespace viewer {

inline constexpr Key kKeySpace = 32, kKeyEscape = 256, kKeyEnter = 257, kKeyTab = 258,
                     kKeyBackspace = 259, kKeyDelete = 261, kKeyRight = 262, kKeyLeft = 263,
                     kKeyDown = 264, kKeyUp = 265, kKeyHome = 268, kKeyEnd = 269, kKeyF8 = 297,
                     kKeyF9 = 298, kKeyF10 = 299, kKeyF12 = 301, kKeyLeftShift = 340,
                     kKeyLeftControl = 341, kKeyLeftAlt = 342, kKeyRightShift = 344,
                     kKeyRightControl = 345, kKeyRightAlt = 346;
inline constexpr Key kMaxKey = 511;

/// "space", "f", "f12"; "code348" for a key without a name.
std::string keyName(Key key);
/// The key of a name; nothing for others.
std::optional<Key> keyOf(std::string_view name);

}  // namespace viewer
