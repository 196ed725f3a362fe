// Pictures of hair over an empty target: what it covers, and how far two of them are apart.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "pelage/headless.h"
#include "support/extremes.h"

namespace pelage::test {

inline size_t coveredPixels(const std::vector<Float4>& pixels) {
  return static_cast<size_t>(
      std::count_if(pixels.begin(), pixels.end(), [](const Float4& p) { return p.w > 0; }));
}
inline size_t coveredPixels(const RenderedImage& image) { return coveredPixels(image.pixels); }

/// Sum of the alphas [pixels].
inline double coverage(const std::vector<Float4>& pixels) {
  double sum = 0;
  for (const Float4& p : pixels) sum += static_cast<double>(p.w);
  return sum;
}
inline double coverage(const RenderedImage& image) { return coverage(image.pixels); }

/// The largest difference of a channel; NaN where one is.
inline double maxDifference(const Float4& a, const Float4& b) {
  double largest = 0;
  for (const float d : {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w})
    keepLargest(largest, std::abs(static_cast<double>(d)));
  return largest;
}
/// Infinite for pictures of different sizes.
inline double maxDifference(const RenderedImage& a, const RenderedImage& b) {
  if (a.pixels.size() != b.pixels.size()) return INFINITY;
  double largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    keepLargest(largest, maxDifference(a.pixels[i], b.pixels[i]));
  return largest;
}

/// False where there is nothing to compare.
inline bool sameBits(const std::vector<Float4>& a, const std::vector<Float4>& b) {
  return !a.empty() && a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(Float4)) == 0;
}
inline bool sameBits(const RenderedImage& a, const RenderedImage& b) {
  return sameBits(a.pixels, b.pixels);
}

inline bool allFinite(const RenderedImage& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(), [](const Float4& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && std::isfinite(p.w);
  });
}

}  // namespace pelage::test
