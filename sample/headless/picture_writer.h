// The pictures of a run: one PNG a frame and the contact sheet.
#pragma once

#include <cstdint>
#include <filesystem>

#include "image.h"
#include "pelage/headless.h"
#include "pelage/result.h"

namespace sample {

class PictureWriter {
 public:
  /// Makes the folder. \param cells pictures to come. \param width, height their final size
  /// [pixels].
  static pelage::Result<PictureWriter> create(const std::filesystem::path& folder, uint32_t cells,
                                              uint32_t width, uint32_t height, uint32_t supersample,
                                              const Backdrop& backdrop = {});
  /// Averages, puts the picture over the backdrop and writes frame_NNNN.png.
  pelage::Result<void> add(uint32_t frame, const pelage::RenderedImage& image);
  /// Writes contact_sheet.png, if there was a picture.
  pelage::Result<void> finish();
  uint32_t count() const { return sheet_.count(); }

 private:
  PictureWriter(std::filesystem::path folder, ContactSheet sheet, uint32_t supersample,
                const Backdrop& backdrop)
      : folder_(std::move(folder)),
        sheet_(std::move(sheet)),
        supersample_(supersample),
        backdrop_(backdrop) {}

  std::filesystem::path folder_;
  ContactSheet sheet_;
  uint32_t supersample_ = 1;
  Backdrop backdrop_;
};

}  // namespace sample
