#include "palette_png.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <vector>

namespace sample {

namespace {

constexpr size_t kColors = 64;
constexpr int kRounds = 8;

using Color = std::array<uint8_t, 3>;

std::vector<Color> pixelsOf(const ByteImage& image) {
  std::vector<Color> pixels(image.rgb.size() / 3);
  for (size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = {image.rgb[3 * i], image.rgb[3 * i + 1], image.rgb[3 * i + 2]};
  return pixels;
}

// Median cut (Heckbert, "Color image quantization for frame buffer display", SIGGRAPH 1982): the
// part that spreads most is cut in its middle until there are enough parts.
std::vector<Color> cutColors(std::vector<Color> pixels) {
  struct Part {
    size_t first, last;
    int axis, spread;
  };
  const auto measure = [&](size_t first, size_t last) {
    Part part = {first, last, 0, -1};
    for (int axis = 0; axis < 3; ++axis) {
      uint8_t low = 255, high = 0;
      for (size_t i = first; i < last; ++i) {
        low = std::min(low, pixels[i][axis]);
        high = std::max(high, pixels[i][axis]);
      }
      if (high - low > part.spread) part = {first, last, axis, high - low};
    }
    return part;
  };
  std::vector<Part> parts = {measure(0, pixels.size())};
  while (parts.size() < kColors) {
    const auto widest =
        std::max_element(parts.begin(), parts.end(),
                         [](const Part& a, const Part& b) { return a.spread < b.spread; });
    if (widest->spread == 0) break;
    const Part part = *widest;
    const auto first = pixels.begin() + static_cast<ptrdiff_t>(part.first);
    const auto last = pixels.begin() + static_cast<ptrdiff_t>(part.last);
    std::sort(first, last,
              [&](const Color& a, const Color& b) { return a[part.axis] < b[part.axis]; });
    // Equal colours stay in one part.
    const uint8_t middle = std::max(pixels[(part.first + part.last) / 2][part.axis],
                                    static_cast<uint8_t>((*first)[part.axis] + 1));
    const auto cut = static_cast<size_t>(
        std::partition_point(first, last, [&](const Color& c) { return c[part.axis] < middle; }) -
        pixels.begin());
    *widest = measure(part.first, cut);
    parts.push_back(measure(cut, part.last));
  }
  std::vector<Color> colors;
  for (const Part& part : parts) colors.push_back(pixels[(part.first + part.last) / 2]);
  return colors;
}

size_t nearest(const std::vector<Color>& colors, const Color& pixel) {
  size_t best = 0;
  int distance = std::numeric_limits<int>::max();
  for (size_t i = 0; i < colors.size(); ++i) {
    int d = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int difference = colors[i][axis] - pixel[axis];
      d += difference * difference;
    }
    if (d < distance) {
      distance = d;
      best = i;
    }
  }
  return best;
}

// Each colour goes to the mean of its pixels.
void refine(std::vector<Color>& colors, const std::vector<Color>& pixels) {
  std::vector<std::array<uint64_t, 4>> sums(colors.size());
  for (const Color& pixel : pixels) {
    auto& sum = sums[nearest(colors, pixel)];
    for (int axis = 0; axis < 3; ++axis) sum[axis] += pixel[axis];
    ++sum[3];
  }
  for (size_t i = 0; i < colors.size(); ++i)
    for (int axis = 0; axis < 3 && sums[i][3] > 0; ++axis)
      colors[i][axis] = static_cast<uint8_t>((sums[i][axis] + sums[i][3] / 2) / sums[i][3]);
}

}  // namespace

pelage::Result<void> writePalettePng(const std::string& path, const ByteImage& image) {
  const std::vector<Color> pixels = pixelsOf(image);
  std::vector<Color> colors = cutColors(pixels);
  for (int round = 0; round < kRounds; ++round) refine(colors, pixels);

  std::vector<uint8_t> indices;
  indices.reserve(pixels.size());
  for (const Color& pixel : pixels) indices.push_back(static_cast<uint8_t>(nearest(colors, pixel)));
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB_COLORMAP;
  png.colormap_entries = static_cast<png_uint_32>(colors.size());
  if (png_image_write_to_file(&png, path.c_str(), 0, indices.data(), 0, colors.data()) != 0)
    return {};
  return pelage::Error{pelage::ErrorCode::kFileNotFound,
                       fmt::format("{}: cannot be written: {}", path, png.message)};
}

}  // namespace sample
