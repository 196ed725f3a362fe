// Everything that the outputs are written from.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "codegen/host_struct.h"
#include "codegen/layout_plan.h"
#include "codegen/manifest.h"
#include "codegen/reflect.h"

namespace pelage::codegen {

struct BindingUse {
  uint32_t set = 0;
  uint32_t entry = 0;
  Access access = Access::kNone;
};

/// A distinct variant: one SPIR-V, used by one or more permutations.
struct VariantOutput {
  std::vector<Permutation> permutations;  ///< in the manifest's order
  std::vector<uint32_t> spirv;
  std::string glsl;
  std::string essl;
  std::vector<BindingUse> bindings;  ///< ascending by (set, entry)
  uint32_t groupSize[3] = {0, 0, 0};
  uint32_t sharedBytes = 0;
  uint64_t hash = 0;
};

struct KernelOutput {
  ManifestKernel kernel;
  std::vector<SpecConstantInfo> specConstants;  ///< ascending by id
  std::vector<VariantOutput> variants;
};

struct Program {
  Manifest manifest;
  std::vector<PlannedLayout> layouts;
  std::vector<HostStruct> structs;  ///< each behind those that it contains
  std::vector<KernelOutput> kernels;
};

/// Names and contents of the files to write, relative to the output folder.
std::map<std::string, std::string> emitSources(const Program& program);

/// reflection.json: what the outputs say, without the code.
std::string emitReflection(const Program& program);

}  // namespace pelage::codegen
