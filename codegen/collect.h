// From compiled permutations to the structs and kernels of the program.
#pragma once

#include <vector>

#include "codegen/layout_plan.h"
#include "codegen/program.h"
#include "codegen/unit.h"

namespace pelage::codegen {

/// Returns the host structs of all kernels, each behind those that it contains.
std::vector<HostStruct> collectStructs(const std::vector<Unit>& units, Diagnostics& diagnostics);

/// Returns the kernels in the manifest's order with their distinct variants, and adds the accesses
/// of the variants to the plan.
/// \param keepNames in the SPIR-V of variants
std::vector<KernelOutput> collectKernels(const Manifest& manifest, const std::vector<Unit>& units,
                                         bool keepNames, LayoutPlan& plan,
                                         Diagnostics& diagnostics);

}  // namespace pelage::codegen
