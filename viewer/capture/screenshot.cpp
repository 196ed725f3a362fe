#include "capture/screenshot.h"

#include <system_error>

#include "png_file.h"

namespace viewer {

pelage::Result<void> writeScreenshot(const sample::ByteImage& picture,
                                     const std::filesystem::path& path) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  return sample::writePng(path.string(), picture);
}

}  // namespace viewer
