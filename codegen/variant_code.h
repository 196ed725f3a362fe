// The code of variants in languages that SPIR-V is translated to once it is complete, and the
// packed code of all languages.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "codegen/cache.h"
#include "codegen/program.h"
#include "codegen/unit.h"

namespace pelage::codegen {

struct BuildOptions;

/// Sets the WGSL of all variants that run on WebGPU: from the cache, the others in one run of
/// Node.js.
/// \param folder for its files, does not exist yet
void translateToWgsl(const BuildOptions& options, const std::filesystem::path& folder,
                     const Cache& cache, const std::vector<Unit>& units, Program& program,
                     Diagnostics& diagnostics);

/// Sets the MSL of all variants.
void translateToMsl(size_t threads, const std::vector<Unit>& units,
                    std::vector<KernelOutput>& kernels, Diagnostics& diagnostics);

/// Puts the variants' code together, format by format, and compresses it.
/// \param indent keeps the indentation of sources
void packKernels(size_t threads, bool indent, const Cache& cache,
                 std::vector<KernelOutput>& kernels, Diagnostics& diagnostics);

}  // namespace pelage::codegen
