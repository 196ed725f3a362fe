// Pictures on the host: linear float pixels from the device, 8-bit sRGB for files.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/headless.h"

namespace sample {

/// 8-bit sRGB pixels, three bytes each, row 0 at the top.
struct ByteImage {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;  ///< width * height * 3
};

/// A vertical gradient with a soft bright spot, linear RGB: what the picture shows where nothing
/// was drawn.
struct Backdrop {
  pelage::Float3 top = {0.075f, 0.092f, 0.120f};
  pelage::Float3 bottom = {0.26f, 0.27f, 0.285f};
  float glow = 0.6f;  ///< relative brightening in the middle, >= 0
};

/// A backdrop of one color. \param srgb  its bytes in the picture that encodeSrgb() makes
Backdrop flatBackdrop(const std::array<uint8_t, 3>& srgb);

/// The pixels of a picture that show hair.
struct HairPixels {
  uint64_t count = 0;
  double share = 0;      ///< of all pixels, 0..1
  double meanLight = 0;  ///< mean luminance of these pixels where they are not transparent, linear
  uint64_t invalidCount = 0;  ///< pixels with a NaN or an infinity, which are not in `count`
};

/// Returns the pixels that hair changes visibly: by more than 0.04 (10/255) in a channel or in
/// alpha. \param without the same picture without hair; nullptr for one that is transparent
/// everywhere. Asserts that the sizes are equal.
HairPixels hairPixels(const pelage::RenderedImage& image, const pelage::RenderedImage* without);

/// Averages blocks of factor x factor pixels, in linear light. Asserts that the size is a multiple
/// of the factor, which is at least 1.
pelage::RenderedImage boxDownsample(const pelage::RenderedImage& image, uint32_t factor);

/// Puts an image with premultiplied alpha over the backdrop; alpha becomes 1.
void compositeOver(pelage::RenderedImage& image, const Backdrop& backdrop);

/// Linear light 0..infinity to 0..1: the identity up to 0.6, then a smooth shoulder towards 1
/// (0.6 + 0.4 (1 - exp(-(x - 0.6) / 0.4))). Negative values and NaN become 0.
float toneMap(float linear);

/// Tone-maps and encodes with the sRGB transfer curve (IEC 61966-2-1), rounded to nearest.
ByteImage encodeSrgb(const pelage::RenderedImage& image);

/// Returns the PSNR of two pictures [dB], of 255; infinite where they are the same. Asserts that
/// the sizes are equal.
double psnrOf(const ByteImage& a, const ByteImage& b);

/// The pictures of a run side by side, scaled down so that the sheet stays under about 2000 pixels.
class ContactSheet {
 public:
  /// \param cells how many pictures there will be, >= 1.
  /// \param width, height size of each [pixels].
  ContactSheet(uint32_t cells, uint32_t width, uint32_t height);
  /// Adds the next picture; asserts on another size, or one too many.
  void add(const pelage::RenderedImage& picture);
  uint32_t count() const { return used_; }
  const ByteImage& image() const { return sheet_; }

 private:
  uint32_t cells_ = 0, columns_ = 0, factor_ = 1;
  uint32_t cellWidth_ = 0, cellHeight_ = 0;
  uint32_t width_ = 0, height_ = 0, used_ = 0;
  ByteImage sheet_;
};

}  // namespace sample
