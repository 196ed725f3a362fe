#include "png_file.h"

#include <fmt/format.h>
#include <png.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "names.h"

namespace sample {

namespace {

// libpng's reader and writer state, released on every way out.
struct PngState {
  png_image image{};
  PngState() { image.version = PNG_IMAGE_VERSION; }
  ~PngState() { png_image_free(&image); }
  PngState(const PngState&) = delete;
  PngState& operator=(const PngState&) = delete;
};

Error fileError(ErrorCode code, const std::string& path, const char* what, const char* why) {
  return {code, fmt::format("{}: {}: {}", path, what, why)};
}

}  // namespace

Result<void> writePng(const std::string& path, const ByteImage& image) {
  const std::string temporary = path + ".part";
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (file == nullptr)
    return fileError(ErrorCode::kFileNotFound, path, "cannot be written", std::strerror(errno));

  PngState png;
  png.image.width = image.width;
  png.image.height = image.height;
  png.image.format = PNG_FORMAT_RGB;
  const bool written =
      png_image_write_to_stdio(&png.image, file, 0, image.rgb.data(), 0, nullptr) != 0;
  const bool closed = std::fclose(file) == 0;
  std::error_code error;
  if (!written || !closed) {
    const std::string why = written ? std::strerror(errno) : png.image.message;
    std::filesystem::remove(temporary, error);
    return fileError(ErrorCode::kFileNotFound, path, "cannot be written", why.c_str());
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    const std::string why = error.message();
    std::filesystem::remove(temporary, error);
    return fileError(ErrorCode::kFileNotFound, path, "cannot be renamed into place", why.c_str());
  }
  return {};
}

Result<ByteImage> readPng(const std::string& path) {
  PngState png;
  if (!png_image_begin_read_from_file(&png.image, path.c_str()))
    return fileError(
        std::filesystem::exists(path) ? ErrorCode::kInvalidFile : ErrorCode::kFileNotFound, path,
        "cannot be read as PNG", png.image.message);
  png.image.format = PNG_FORMAT_RGB;
  ByteImage image;
  image.width = png.image.width;
  image.height = png.image.height;
  image.rgb.resize(PNG_IMAGE_SIZE(png.image));
  const png_color black = {0, 0, 0};
  if (!png_image_finish_read(&png.image, &black, image.rgb.data(), 0, nullptr))
    return fileError(ErrorCode::kInvalidFile, path, "cannot be read as PNG", png.image.message);
  return image;
}

}  // namespace sample
