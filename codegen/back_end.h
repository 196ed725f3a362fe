// From the front end's module to the shipped code: bindings, optimization, validation, GLSL, ESSL.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pelage/layout.h"
#include "pelage/tier.h"

namespace pelage::codegen {

/// The binding of one resource of a module.
struct BindingPatch {
  uint32_t set = 0;         ///< as in the raw module
  uint32_t rawBinding = 0;  ///< as in the raw module
  uint32_t binding = 0;     ///< Vulkan binding in the same set
  uint32_t glBinding = 0;   ///< not of storage buffers
  ResourceKind kind = ResourceKind::kStorageBuffer;
  bool operator==(const BindingPatch&) const = default;
};

struct BackEndInput {
  std::span<const uint32_t> rawSpirv;
  std::string entry;
  Stage stage = Stage::kCompute;
  std::vector<BindingPatch> patches;
  bool precise = false;
  Tier tier = Tier::kBase;
  uint32_t firstStorageBinding = 0;  ///< on GL; the others follow
};

struct BackEndError {
  std::string code;
  std::string message;
  bool isError = true;
};

struct BackEndOutput {
  std::vector<uint32_t> optimised;  ///< with names and lines; bindings patched
  std::vector<uint32_t> spirv;      ///< stripped: the shipped code
  std::string glsl;
  std::string essl;
  std::vector<BackEndError> errors;
};

/// Continues as far as possible: the result of a failed step stays empty.
BackEndOutput runBackEnd(const BackEndInput& input);

/// Returns the names and versions of the tools behind it, for cache keys.
std::string backEndVersion();

}  // namespace pelage::codegen
