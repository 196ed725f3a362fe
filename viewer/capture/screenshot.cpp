#include "capture/screenshot.h"

#include <fmt/format.h>

#include <system_error>

#include "png_file.h"

namespace viewer {

pelage::Result<void> writeScreenshot(const sample::ByteImage& picture,
                                     const std::filesystem::path& path) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  return sample::writePng(path.string(), picture);
}

std::filesystem::path nextScreenshot() {
  constexpr int kMost = 9999;
  for (int number = 1;; ++number) {
    const std::filesystem::path path = fmt::format("pelage-{:04}.png", number);
    std::error_code error;
    if (number == kMost || !std::filesystem::exists(path, error)) return path;
  }
}

}  // namespace viewer
