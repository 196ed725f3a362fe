#include <string_view>

#include "pelage/settings/settings_file.h"
#include "targets.h"

namespace pelage::fuzz {

Outcome settings(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto loaded = parseSettings(text, kName);
  if (!loaded) return refused(loaded.error());
  if (auto valid = validate(*loaded); !valid) return broken("not valid: " + valid.error().message);
  for (const SettingsExtent extent : {SettingsExtent::kChanges, SettingsExtent::kAll}) {
    const auto again = parseSettings(settingsText(*loaded, extent), kName);
    if (!again) return broken("the text cannot be read: " + again.error().message);
    if (!haveSameSettings(*again, *loaded)) return broken("the text gives other settings");
  }
  if (settingsSnippet(*loaded).empty() != haveSameSettings(*loaded, {}))
    return broken("the code does not set what differs");
  return {true, {}};
}

}  // namespace pelage::fuzz
