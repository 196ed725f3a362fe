#include "pelage/headless.h"

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

}  // namespace pelage
