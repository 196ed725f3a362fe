// A module as naga reads it, which the back end has translated to WGSL (codegen/wgsl).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pelage::codegen {

/// Returns an optimized module with the same meaning in the form that naga translates: every access
/// chain is in the block that uses it, because naga keeps values of other blocks in variables, and
/// WGSL has none of pointers; the value of an atomic operation is copied there, because naga does
/// not look for it in other blocks; and buffers that the module only reads are NonWritable, so that
/// the access in WGSL is the one of KernelVariant::bindings. A malformed module is returned
/// unchanged.
std::vector<uint32_t> prepareForWgsl(std::span<const uint32_t> spirv);

}  // namespace pelage::codegen
