#include "picture_writer.h"

#include <fmt/format.h>

#include <system_error>

#include "png_file.h"

namespace sample {

using pelage::Result;

Result<PictureWriter> PictureWriter::create(const std::filesystem::path& folder, uint32_t cells,
                                            uint32_t width, uint32_t height, uint32_t supersample,
                                            const Backdrop& backdrop) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return pelage::Error{
        pelage::ErrorCode::kFileNotFound,
        fmt::format("{}: cannot make the folder: {}", folder.string(), error.message())};
  return PictureWriter(folder, ContactSheet(cells, width, height), supersample, backdrop);
}

Result<void> PictureWriter::add(uint32_t frame, const pelage::RenderedImage& image) {
  pelage::RenderedImage picture = boxDownsample(image, supersample_);
  compositeOver(picture, backdrop_);
  sheet_.add(picture);
  return writePng((folder_ / fmt::format("frame_{:04}.png", frame)).string(), encodeSrgb(picture));
}

Result<void> PictureWriter::finish() {
  if (sheet_.count() == 0) return {};
  return writePng((folder_ / "contact_sheet.png").string(), sheet_.image());
}

}  // namespace sample
