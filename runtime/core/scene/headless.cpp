#include "pelage/headless.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

namespace pelage {

namespace {

constexpr uint32_t kMaxTextureSize = 2048, kMaxTextureLayers = 256;

// Rounds to the nearest half. What is below 2^-14 becomes 0, what is too large the largest half,
// and NaN 0.
uint16_t toHalf(float value) {
  const uint32_t sign = std::signbit(value) ? 0x8000u : 0;
  const float size = std::abs(value);
  if (!(size >= 0x1p-14f)) return static_cast<uint16_t>(sign);
  const uint32_t bits = std::bit_cast<uint32_t>(size) + 0x1000u;
  const uint32_t half = size < 65504.0f ? (bits - (112u << 23)) >> 13 : 0x7bffu;
  return static_cast<uint16_t>(sign | half);
}

}  // namespace

const char* apiName(Api api) {
  switch (api) {
    case Api::kVulkan:
      return "vulkan";
    case Api::kGl:
      return "gl";
    case Api::kGles:
      return "gles";
  }
  return "unknown";
}

Result<std::unique_ptr<HeadlessDevice>> HeadlessDevice::another() const {
  return Error{
      ErrorCode::kUnsupported,
      "HeadlessDevice::another() is of Vulkan: make an OpenGL device by createHeadlessGl()"};
}

Result<void> HeadlessDevice::supports(const TransparencySettings& settings,
                                      const DrawnFeatures& hair) const {
  const Result<PassList> list = listToDraw(settings, hair, info().tier);
  if (!list) return list.error();
  return supports(*list);
}

Result<PixelArea> HeadlessDevice::drawArea(const RenderTargetDef& target) {
  const PixelArea& area = target.area;
  if (area.width == 0 || area.height == 0) return PixelArea{0, 0, target.width, target.height};
  if (uint64_t{area.x} + area.width <= target.width &&
      uint64_t{area.y} + area.height <= target.height)
    return area;
  return Error{ErrorCode::kInvalidArgument,
               "RenderTargetDef::area: " + std::to_string(area.width) + " x " +
                   std::to_string(area.height) + " pixels at (" + std::to_string(area.x) + ", " +
                   std::to_string(area.y) + ") leave the target of " +
                   std::to_string(target.width) + " x " + std::to_string(target.height)};
}

Result<std::vector<std::byte>> HeadlessDevice::textureBytes(const TextureDef& texture) {
  const bool cube = texture.shape == TextureShape::kCube;
  const auto isSize = [](uint32_t size) { return size >= 1 && size <= kMaxTextureSize; };
  const bool square = texture.width == texture.height && texture.layers == 6;
  const bool plane = texture.shape == TextureShape::kPlane;
  const uint32_t mostLayers = plane ? 1 : kMaxTextureLayers;
  const auto mostLevels =
      static_cast<uint32_t>(plane ? std::bit_width(std::max(texture.width, texture.height)) : 1);
  const bool shaped = (cube ? square : texture.layers >= 1 && texture.layers <= mostLayers) &&
                      texture.mipLevels >= 1 && texture.mipLevels <= mostLevels;
  uint64_t values = 0;
  for (uint32_t level = 0; level < std::min(texture.mipLevels, mostLevels); ++level)
    values += uint64_t{sizeOfLevel(texture.width, level)} * sizeOfLevel(texture.height, level) *
              texture.layers * texture.channels;
  if (!isSize(texture.width) || !isSize(texture.height) || !shaped ||
      (texture.channels != 1 && texture.channels != 4) || texture.texels.size() != values) {
    return Error{ErrorCode::kInvalidArgument,
                 "TextureDef: " + std::to_string(texture.width) + " x " +
                     std::to_string(texture.height) + " texels in " +
                     std::to_string(texture.layers) + " layers and " +
                     std::to_string(texture.mipLevels) + " mip levels with " +
                     std::to_string(texture.channels) + " channels and " +
                     std::to_string(texture.texels.size()) +
                     " values; a size is 1 to 2048, layers are 1 to 256, 6 squares of a cube or 1 "
                     "of a plane, which may have mip levels down to 1 texel, channels 1 or 4, and "
                     "there is a value for each"};
  }
  const size_t size = texture.channels == 1 ? sizeof(float) : sizeof(uint16_t);
  std::vector<std::byte> bytes(texture.texels.size() * size);
  for (size_t i = 0; i < texture.texels.size(); ++i) {
    const uint16_t half = toHalf(texture.texels[i]);
    std::memcpy(bytes.data() + i * size,
                texture.channels == 1 ? static_cast<const void*>(&texture.texels[i])
                                      : static_cast<const void*>(&half),
                size);
  }
  return bytes;
}

Result<void> HeadlessDevice::checkDepthCopy(const RenderTargetDef& target, size_t lists,
                                            uint64_t bytes) {
  if (target.depthCopy == BufferId::kInvalid) return {};
  const auto invalid = [](std::string message) {
    return Error{ErrorCode::kInvalidArgument, "RenderTargetDef::depthCopy: " + std::move(message)};
  };
  const std::string buffer = "buffer " + std::to_string(static_cast<uint32_t>(target.depthCopy));
  const Result<PixelArea> area = drawArea(target);
  if (!area) return area.error();
  const uint64_t needed = uint64_t{area->width} * area->height * sizeof(float);
  if (target.samples > 1) {
    return invalid("the target has " + std::to_string(target.samples) +
                   " samples a pixel; depth is copied from one with 1");
  }
  if (target.depthCopyAfter >= lists) {
    return invalid("depthCopyAfter is " + std::to_string(target.depthCopyAfter) + ", there are " +
                   std::to_string(lists) + " lists");
  }
  if (bytes == 0) return invalid(buffer + " was removed, or update() has not seen it");
  if (bytes < needed) {
    return invalid(buffer + " has " + std::to_string(bytes) + " bytes, the depth of " +
                   std::to_string(area->width) + " x " + std::to_string(area->height) +
                   " pixels takes " + std::to_string(needed));
  }
  return {};
}

namespace {

void append(std::vector<PassTiming>* all, const std::vector<PassTiming>& more) {
  if (all != nullptr) all->insert(all->end(), more.begin(), more.end());
}

}  // namespace

Result<void> HeadlessDevice::run(Frame& frame, std::vector<PassTiming>* timings) {
  if (frame.viewCount() > 0) {
    return Error{ErrorCode::kInvalidArgument, "HeadlessDevice::run(): the frame has " +
                                                  std::to_string(frame.viewCount()) +
                                                  " views: render() it, with a target for each"};
  }
  const Result<std::vector<RenderedImage>> none = render(frame, {}, timings);
  if (!none) return none.error();
  return {};
}

Result<std::vector<RenderedImage>> HeadlessDevice::render(Frame& frame,
                                                          std::span<const RenderTargetDef> targets,
                                                          std::vector<PassTiming>* timings) {
  if (targets.size() != frame.viewCount()) {
    return Error{ErrorCode::kInvalidArgument,
                 "HeadlessDevice::render(): the frame has " + std::to_string(frame.viewCount()) +
                     " views, but there are " + std::to_string(targets.size()) + " targets"};
  }
  if (Result<void> done = frame.finish(); !done) return done.error();
  std::vector<PixelArea> areas;
  for (const RenderTargetDef& target : targets) {
    const Result<PixelArea> area = drawArea(target);
    if (!area) return area.error();
    areas.push_back(*area);
  }
  if (Result<void> fits = frame.checkAreas(areas); !fits) return fits.error();
  if (timings != nullptr) timings->clear();
  std::vector<PassTiming> times;
  std::vector<PassTiming>* const wanted = timings != nullptr ? &times : nullptr;
  std::vector<RenderedImage> images;
  std::vector<const PassList*> lists;  // of the view that is gathered
  const auto renderView = [&]() -> Result<void> {
    if (lists.empty()) return {};
    Result<RenderedImage> image = render(lists, targets[images.size()], wanted);
    lists.clear();
    if (!image) return image.error();
    images.push_back(std::move(*image));
    append(timings, times);
    return {};
  };
  FrameExecutor executor;
  executor.update = [&](const ResourceTable& resources) { return update(resources); };
  executor.record = [&](const FrameStep& step) -> Result<void> {
    if (step.listOfView == 0) {
      if (Result<void> done = renderView(); !done) return done;
    }
    if (step.view != FrameStep::kNoView) {
      lists.push_back(step.list);
      return {};
    }
    Result<void> done = execute(*step.list, wanted);
    if (done) append(timings, times);
    return done;
  };
  executor.draw = [](const FrameStep&) { return Result<void>(); };
  if (Result<void> done = frame.run(executor); !done) return done.error();
  if (Result<void> done = renderView(); !done) return done.error();
  return images;
}

}  // namespace pelage
