// PNG files, 8-bit sRGB.
#pragma once

#include <string>

#include "image.h"
#include "pelage/result.h"

namespace sample {

/// Writes the picture under a temporary name beside `path` and renames it, so that a file of that
/// name is always a whole one.
pelage::Result<void> writePng(const std::string& path, const ByteImage& image);

/// Reads a PNG of any kind as 8-bit sRGB; alpha is put on black.
pelage::Result<ByteImage> readPng(const std::string& path);

}  // namespace sample
