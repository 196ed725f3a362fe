// Pictures of the window as files.
#pragma once

#include <filesystem>

#include "image.h"
#include "pelage/result.h"

namespace viewer {

/// Writes a picture as PNG, and makes the folder of the file. Errors: a file that cannot be
/// written.
pelage::Result<void> writeScreenshot(const sample::ByteImage& picture,
                                     const std::filesystem::path& path);

}  // namespace viewer
