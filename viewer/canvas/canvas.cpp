#include "canvas/canvas.h"

#include <fmt/format.h>

#include <bit>
#include <string>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;

pelage::Result<void> checkSamples(const pelage::DeviceInfo& info, uint32_t samples) {
  if (std::has_single_bit(samples) && (info.sampleCounts & samples) != 0) return {};
  std::string counts;
  for (uint32_t count = 1; count <= info.sampleCounts; count *= 2)
    if ((info.sampleCounts & count) != 0)
      counts += (counts.empty() ? "" : ", ") + std::to_string(count);
  return Error{ErrorCode::kUnsupported,
               fmt::format("view.samples is {}, but {} has targets of {} samples a pixel", samples,
                           info.name, counts)};
}

pelage::Result<std::unique_ptr<Canvas>> createCanvas(const CanvasDef& def, Window& window) {
  if (def.api == pelage::Api::kVulkan) {
#ifdef PELAGE_VIEWER_VULKAN
    return createVulkanCanvas(def, window);
#else
    return Error{ErrorCode::kUnsupported,
                 "this viewer was built without Vulkan: configure with -DPELAGE_VULKAN=ON"};
#endif
  }
#ifdef PELAGE_VIEWER_GL
  return createGlCanvas(def, window);
#else
  return Error{ErrorCode::kUnsupported,
               "this viewer was built without OpenGL: configure with -DPELAGE_GL=ON"};
#endif
}

}  // namespace viewer
