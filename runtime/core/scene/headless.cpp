#include "pelage/headless.h"

#include <string>

namespace pelage {

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

}  // namespace pelage
