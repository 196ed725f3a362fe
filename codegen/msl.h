// Metal: SPIR-V to MSL by SPIRV-Cross, with a slot for each resource. docs/metal_d3d12.md
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codegen/back_end.h"
#include "pelage/metal_kernel.h"

namespace pelage::codegen {

struct MslModule {
  std::string source;                  ///< empty after an error
  std::string function;                ///< name of the entry point
  std::vector<MetalBinding> bindings;  ///< ascending by (set, entry)
  uint8_t vertexBuffer = MetalKernel::kNone;
  uint8_t sizes = MetalKernel::kNone;
  std::vector<BackEndError> errors;  ///< PK415: beyond kMetalLimits. PK416: SPIRV-Cross refuses it.
};

/// Writes MSL 2.1 (macOS 10.14, iOS 12). Slots are dense in each table, in the order of (set,
/// binding); behind the buffers come the sizes of buffers, where needed, and the vertex buffers.
/// \param spirv an optimized module with patched bindings; its names get into the MSL
/// \param vertexBuffers slots that the vertex inputs need
MslModule writeMsl(std::span<const uint32_t> spirv, uint32_t vertexBuffers);

}  // namespace pelage::codegen
