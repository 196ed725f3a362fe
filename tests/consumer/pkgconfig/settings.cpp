// Settings of an installed pelage: a preset, written and read again.
#include <pelage/settings/settings_file.h>

#include <cstdio>

int main() {
  const auto settings = pelage::presetSettings("curly");
  if (!settings) return 1;
  const std::string text = pelage::settingsText(*settings);
  const auto again = pelage::parseSettings(text, "text");
  if (!again || !pelage::haveSameSettings(*again, *settings)) return 1;
  std::printf("%s", pelage::settingsSnippet(*settings).c_str());
}
