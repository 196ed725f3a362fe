// The reference for pictures of hair: the exact composite, in double precision, of the
// fragments that a scene's strands make.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "oit/hair_scene.h"

namespace bench {

/// Over the pixels that have hair, of red, green and blue.
struct PictureError {
  double psnr = std::numeric_limits<double>::infinity();  ///< [dB], of 1
  double largest = 0;                                     ///< 0..1
  double off = 0;  ///< share of the pixels, by more than 1/255
};

/// Pixels of hair over what is behind it.
struct ExactPicture {
  struct Pixel {
    uint32_t index;  ///< y * width + x
    double color[3];
  };
  std::vector<Pixel> pixels;
  uint64_t fragments = 0;  ///< of the whole picture
  uint32_t rowStep = 1;    ///< pixels are those of each so many rows
  double layersMean = 0;   ///< fragments of a pixel
  uint32_t layersMax = 0;
};

/// Captures fragments on a device, a limited number at a time: of a picture that has more, every
/// second, third... row is taken.
class FragmentReference {
 public:
  /// \param limit fragments; 32 bytes each, on the device and on the host. No more than a device's
  ///   buffers have room for.
  FragmentReference(HairScene& scene, uint32_t limit);
  ~FragmentReference();
  FragmentReference(const FragmentReference&) = delete;
  FragmentReference& operator=(const FragmentReference&) = delete;

  pelage::Result<ExactPicture> picture(const pelage::View& view);

 private:
  HairScene& scene_;
  uint32_t limit_;
  pelage::BufferId fragments_, counts_;
};

PictureError comparePicture(const pelage::RenderedImage& image, const ExactPicture& exact);

}  // namespace bench
