// The APIs of the viewer: OpenGL ES draws into no window.
#pragma once

#include <vector>

#include "pelage/headless.h"

namespace pelage::test {

inline const std::vector<Api> kWindowApis = {
#ifdef PELAGE_TEST_VULKAN
    Api::kVulkan,
#endif
#ifdef PELAGE_TEST_GL
    Api::kGl,
#endif
};

}  // namespace pelage::test
