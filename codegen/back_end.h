// From the front end's module to what is shipped: bindings, optimisation, validation, GLSL, ESSL.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pelage/layout.h"

namespace pelage::codegen {

/// Where one resource of a module goes.
struct BindingPatch {
  uint32_t set = 0;         ///< as in the raw module
  uint32_t rawBinding = 0;  ///< as in the raw module
  uint32_t binding = 0;     ///< Vulkan binding in the same set
  uint32_t glBinding = 0;
  ResourceKind kind = ResourceKind::kStorageBuffer;
  bool operator==(const BindingPatch&) const = default;
};

struct BackEndInput {
  std::span<const uint32_t> rawSpirv;
  std::string entry;
  Stage stage = Stage::kCompute;
  std::vector<BindingPatch> patches;
  bool precise = false;
  bool desktopTier = false;
};

struct BackEndError {
  std::string code;
  std::string message;
  bool isError = true;
};

struct BackEndOutput {
  std::vector<uint32_t> optimised;  ///< with names and lines; bindings patched
  std::vector<uint32_t> spirv;      ///< stripped: what is shipped
  std::string glsl;
  std::string essl;
  std::vector<BackEndError> errors;
};

/// Goes as far as it can: what a failed step would have made stays empty.
BackEndOutput runBackEnd(const BackEndInput& input);

/// Names and versions of the tools behind it, for cache keys.
std::string backEndVersion();

}  // namespace pelage::codegen
