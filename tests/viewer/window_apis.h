// The APIs of the viewer. OpenGL ES is not among them: it has no window here.
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
