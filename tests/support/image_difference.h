// How far two pictures are apart.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <ostream>

#include "image.h"

namespace pelage::test {

struct ImageDifference {
  double mean = 0;         ///< mean absolute difference over all channels [1/255]
  uint32_t worst = 0;      ///< largest difference of a channel [1/255]
  uint64_t pixelsOff = 0;  ///< pixels with a channel that differs by more than the threshold
  double shareOff = 0;     ///< of all pixels, 0..1
};

inline std::ostream& operator<<(std::ostream& out, const ImageDifference& d) {
  return out << "mean difference " << d.mean << "/255, worst " << d.worst << "/255, "
             << 100 * d.shareOff << " % of the pixels (" << d.pixelsOff << ") off";
}

/// Two images of one size. \param threshold [1/255].
inline ImageDifference difference(const sample::ByteImage& a, const sample::ByteImage& b,
                                  uint32_t threshold) {
  ImageDifference result;
  uint64_t sum = 0;
  for (size_t pixel = 0; pixel < a.rgb.size() / 3; ++pixel) {
    uint32_t largest = 0;
    for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const auto distance = static_cast<uint32_t>(std::abs(int{a.rgb[i]} - int{b.rgb[i]}));
      sum += distance;
      largest = std::max(largest, distance);
    }
    result.worst = std::max(result.worst, largest);
    result.pixelsOff += largest > threshold ? 1 : 0;
  }
  result.mean = static_cast<double>(sum) / static_cast<double>(a.rgb.size());
  result.shareOff = static_cast<double>(result.pixelsOff) / (static_cast<double>(a.rgb.size()) / 3);
  return result;
}

/// Sum of its colors.
inline float brightness(const Float4& pixel) { return pixel.x + pixel.y + pixel.z; }

/// Where they differ: the absolute difference, eight times as bright.
inline sample::ByteImage differenceImage(const sample::ByteImage& a, const sample::ByteImage& b) {
  sample::ByteImage image = a;
  for (size_t i = 0; i < a.rgb.size(); ++i)
    image.rgb[i] = static_cast<uint8_t>(std::min(255, 8 * std::abs(int{a.rgb[i]} - int{b.rgb[i]})));
  return image;
}

}  // namespace pelage::test
