// Small PNG files: at most 64 colours.
#pragma once

#include <string>

#include "image.h"
#include "pelage/result.h"

namespace sample {

/// Writes the picture with the 64 colours that suit it best. Errors: the file cannot be written.
pelage::Result<void> writePalettePng(const std::string& path, const ByteImage& image);

}  // namespace sample
