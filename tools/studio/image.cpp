#include "image.h"

#include <algorithm>
#include <cmath>

#include "names.h"
#include "pelage/assert.h"

namespace sample {

using pelage::RenderedImage;

namespace {

constexpr uint32_t kSheetSize = 2000;  // pixels, the longer side of a contact sheet at most
constexpr uint32_t kGap = 2;           // pixels between the cells
constexpr uint8_t kGapGrey = 24;
constexpr float kShoulder = 0.6f;  // where the tone curve leaves the identity

uint8_t encodeChannel(float linear) {
  const float x = toneMap(linear);
  const float s = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
  return static_cast<uint8_t>(std::clamp(std::lround(s * 255), 0l, 255l));
}

// Averages a block whose corner is inside the image; it is cut off at the right and bottom edges.
Float4 blockMean(const RenderedImage& image, uint32_t x0, uint32_t y0, uint32_t factor) {
  const uint32_t x1 = std::min(x0 + factor, image.width);
  const uint32_t y1 = std::min(y0 + factor, image.height);
  Float4 sum;
  for (uint32_t y = y0; y < y1; ++y) {
    const Float4* row = image.pixels.data() + static_cast<size_t>(y) * image.width;
    for (uint32_t x = x0; x < x1; ++x) {
      sum.x += row[x].x;
      sum.y += row[x].y;
      sum.z += row[x].z;
      sum.w += row[x].w;
    }
  }
  const float scale = 1.0f / static_cast<float>((x1 - x0) * (y1 - y0));
  return {sum.x * scale, sum.y * scale, sum.z * scale, sum.w * scale};
}

RenderedImage reduce(const RenderedImage& image, uint32_t factor, uint32_t width, uint32_t height) {
  RenderedImage out;
  out.width = width;
  out.height = height;
  out.pixels.resize(static_cast<size_t>(width) * height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      out.pixels[static_cast<size_t>(y) * width + x] =
          blockMean(image, x * factor, y * factor, factor);
  return out;
}

}  // namespace

HairPixels hairPixels(const RenderedImage& image, const RenderedImage* without) {
  PELAGE_ASSERT(without == nullptr || without->pixels.size() == image.pixels.size(),
                "hairPixels() compares pictures of one size");
  constexpr float kVisible = 0.04f;
  HairPixels result;
  double light = 0, alpha = 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const Float4& p = image.pixels[i];
    if (!std::isfinite(p.x + p.y + p.z + p.w)) {
      ++result.invalidCount;
      continue;
    }
    const Float4 q = without == nullptr ? Float4{} : without->pixels[i];
    const float change = std::max(
        {std::abs(p.x - q.x), std::abs(p.y - q.y), std::abs(p.z - q.z), std::abs(p.w - q.w)});
    if (!(change > kVisible)) continue;
    ++result.count;
    light += 0.2126 * double{p.x} + 0.7152 * double{p.y} + 0.0722 * double{p.z};
    alpha += double{p.w};
  }
  if (!image.pixels.empty())
    result.share = static_cast<double>(result.count) / static_cast<double>(image.pixels.size());
  if (alpha > 0) result.meanLight = light / alpha;
  return result;
}

RenderedImage boxDownsample(const RenderedImage& image, uint32_t factor) {
  PELAGE_ASSERT(factor >= 1 && image.width % factor == 0 && image.height % factor == 0,
                "boxDownsample: the size must be a multiple of the factor");
  if (factor == 1) return image;
  return reduce(image, factor, image.width / factor, image.height / factor);
}

Backdrop flatBackdrop(const std::array<uint8_t, 3>& srgb) {
  // The inverse of encodeSrgb().
  const auto linear = [](uint8_t byte) {
    const float v = std::min(static_cast<float>(byte) / 255, 0.999f);  // 1 would be infinite
    const float light = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
    if (light <= kShoulder) return light;
    const float room = 1 - kShoulder;
    return kShoulder - room * std::log(1 - (light - kShoulder) / room);
  };
  const Float3 color = {linear(srgb[0]), linear(srgb[1]), linear(srgb[2])};
  return {color, color, 0};
}

void compositeOver(RenderedImage& image, const Backdrop& backdrop) {
  const float width = static_cast<float>(image.width), height = static_cast<float>(image.height);
  for (uint32_t y = 0; y < image.height; ++y) {
    const float v = (static_cast<float>(y) + 0.5f) / height;
    for (uint32_t x = 0; x < image.width; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / width;
      const float dx = (u - 0.5f) / 0.42f, dy = (v - 0.45f) / 0.42f;
      const float light = 1 + backdrop.glow * std::exp(-(dx * dx + dy * dy));
      Float4& pixel = image.pixels[static_cast<size_t>(y) * image.width + x];
      const float rest = (1 - pixel.w) * light;
      pixel.x += rest * (backdrop.top.x + (backdrop.bottom.x - backdrop.top.x) * v);
      pixel.y += rest * (backdrop.top.y + (backdrop.bottom.y - backdrop.top.y) * v);
      pixel.z += rest * (backdrop.top.z + (backdrop.bottom.z - backdrop.top.z) * v);
      pixel.w = 1;
    }
  }
}

float toneMap(float linear) {
  if (!(linear > 0)) return 0;
  if (linear <= kShoulder) return linear;
  const float room = 1 - kShoulder;
  return kShoulder + room * (1 - std::exp(-(linear - kShoulder) / room));
}

double psnrOf(const ByteImage& a, const ByteImage& b) {
  PELAGE_ASSERT(a.rgb.size() == b.rgb.size(), "psnrOf() needs pictures of one size");
  double sum = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    const double difference = static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]);
    sum += difference * difference;
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.rgb.size()) / sum);
}

ByteImage encodeSrgb(const RenderedImage& image) {
  ByteImage out;
  out.width = image.width;
  out.height = image.height;
  out.rgb.reserve(image.pixels.size() * 3);
  for (const Float4& pixel : image.pixels) {
    out.rgb.push_back(encodeChannel(pixel.x));
    out.rgb.push_back(encodeChannel(pixel.y));
    out.rgb.push_back(encodeChannel(pixel.z));
  }
  return out;
}

ContactSheet::ContactSheet(uint32_t cells, uint32_t width, uint32_t height)
    : cells_(cells), width_(width), height_(height) {
  PELAGE_ASSERT(cells >= 1 && width >= 1 && height >= 1, "ContactSheet: nothing to show");
  // The number of columns that makes the sheet about half as wide again as it is high.
  const double ratio = 1.5 * height / width;
  columns_ = static_cast<uint32_t>(std::lround(std::sqrt(cells * ratio)));
  columns_ = std::clamp(columns_, 1u, cells);
  const uint32_t rows = (cells + columns_ - 1) / columns_;
  while (std::max(columns_ * (width / factor_), rows * (height / factor_)) > kSheetSize &&
         std::min(width, height) / (factor_ + 1) >= 1)
    ++factor_;
  cellWidth_ = width / factor_;
  cellHeight_ = height / factor_;
  sheet_.width = columns_ * cellWidth_ + (columns_ + 1) * kGap;
  sheet_.height = rows * cellHeight_ + (rows + 1) * kGap;
  sheet_.rgb.assign(static_cast<size_t>(sheet_.width) * sheet_.height * 3, kGapGrey);
}

void ContactSheet::add(const RenderedImage& picture) {
  PELAGE_ASSERT(used_ < cells_ && picture.width == width_ && picture.height == height_,
                "ContactSheet: a picture of another size, or one too many");
  const ByteImage cell = encodeSrgb(reduce(picture, factor_, cellWidth_, cellHeight_));
  const uint32_t left = kGap + (used_ % columns_) * (cellWidth_ + kGap);
  const uint32_t top = kGap + (used_ / columns_) * (cellHeight_ + kGap);
  for (uint32_t y = 0; y < cellHeight_; ++y) {
    const auto from = cell.rgb.begin() + static_cast<ptrdiff_t>(y) * cellWidth_ * 3;
    const size_t to = (static_cast<size_t>(top + y) * sheet_.width + left) * 3;
    std::copy(from, from + cellWidth_ * 3, sheet_.rgb.begin() + static_cast<ptrdiff_t>(to));
  }
  ++used_;
}

}  // namespace sample
