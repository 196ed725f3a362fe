#include "codegen/enum_names.h"

namespace pelage::codegen {

const char* word(ResourceKind kind) {
  switch (kind) {
    case ResourceKind::kUniformBuffer:
      return "uniformBuffer";
    case ResourceKind::kStorageBuffer:
      return "storageBuffer";
    case ResourceKind::kSampledTexture:
      return "sampledTexture";
    case ResourceKind::kStorageTexture:
      return "storageTexture";
    case ResourceKind::kSampler:
      break;
  }
  return "sampler";
}

const char* word(Access access) {
  switch (access) {
    case Access::kNone:
      return "none";
    case Access::kRead:
      return "read";
    case Access::kWrite:
      return "write";
    case Access::kReadWrite:
      break;
  }
  return "readWrite";
}

const char* word(Stage stage) {
  switch (stage) {
    case Stage::kVertex:
      return "vertex";
    case Stage::kPixel:
      return "pixel";
    case Stage::kCompute:
      break;
  }
  return "compute";
}

const char* word(ScalarType type) {
  switch (type) {
    case ScalarType::kFloat:
      return "float";
    case ScalarType::kInt:
      return "int";
    case ScalarType::kUint:
      return "uint";
    case ScalarType::kBool:
      return "bool";
    case ScalarType::kOther:
      break;
  }
  return "";
}

}  // namespace pelage::codegen
