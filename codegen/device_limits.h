// Limits of devices that concern several kernels, or that other APIs have.
#pragma once

#include <cstdint>
#include <vector>

#include "codegen/unit.h"

namespace pelage::codegen {

/// Number of a vertex kernel's first storage buffer on GL, where both stages of a draw share the
/// binding points: behind those of all pixel kernels that fit. 0 for other kernels.
/// \param units whose pixel kernels have passed the back end
uint32_t firstStorageBinding(const Unit& unit, const std::vector<Unit>& units,
                             const Manifest& manifest);

/// PK702: pairs of a vertex and a pixel kernel with too many storage buffers together.
void checkDraws(const std::vector<Unit>& units, const Manifest& manifest, Diagnostics& diagnostics);

/// PK703: what WebGPU has too little of, or not at all.
void checkWebgpu(const std::vector<Unit>& units, Diagnostics& diagnostics);

}  // namespace pelage::codegen
