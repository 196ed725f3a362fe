// Statistics of pictures of the samples and the viewer, without their backdrop.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <set>

#include "image.h"

namespace pelage::test {

struct PictureStatistics {
  double drawnShare = 0;   ///< of the pixels
  double mean = 0;         ///< of these pixels' channels, 0..255
  double detailShare = 0;  ///< of these pixels: those unlike their right neighbor, as strands are
  size_t colors = 0;       ///< different ones of them
};

/// \param first, end the columns that it looks at; 0, 0: all.
inline PictureStatistics statisticsOf(const sample::ByteImage& image, uint32_t first = 0,
                                      uint32_t end = 0) {
  if (end == 0) end = image.width;
  RenderedImage empty;
  empty.width = image.width;
  empty.height = image.height;
  empty.pixels.resize(size_t{image.width} * image.height);
  sample::compositeOver(empty, {});
  const sample::ByteImage backdrop = sample::encodeSrgb(empty);
  const auto difference = [](const uint8_t* a, const uint8_t* b) {
    int most = 0;
    for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a[c] - b[c]));
    return most;
  };
  std::set<std::array<uint8_t, 3>> colors;
  size_t drawn = 0, detailed = 0;
  double sum = 0;
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    const size_t column = i / 3 % image.width;
    if (column < first || column >= end) continue;
    const uint8_t* pixel = &image.rgb[i];
    if (difference(pixel, &backdrop.rgb[i]) <= 4) continue;
    ++drawn;
    sum += (pixel[0] + pixel[1] + pixel[2]) / 3.0;
    colors.insert({pixel[0], pixel[1], pixel[2]});
    detailed += i + 3 < image.rgb.size() && difference(pixel, pixel + 3) > 12 ? 1 : 0;
  }
  PictureStatistics result;
  result.colors = colors.size();
  result.drawnShare = static_cast<double>(drawn) /
                      (static_cast<double>(end - first) * static_cast<double>(image.height));
  if (drawn > 0) {
    result.mean = sum / static_cast<double>(drawn);
    result.detailShare = static_cast<double>(detailed) / static_cast<double>(drawn);
  }
  return result;
}

}  // namespace pelage::test
