#include "canvas/canvas.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;

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
