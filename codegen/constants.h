// Constants that kernels and the host share: the `static const` numbers of the files that a
// manifest lists. The compiler evaluates them, so that they are on the host what they are on the
// GPU.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codegen/diagnostics.h"
#include "codegen/front_end.h"
#include "codegen/reflect.h"

namespace pelage::codegen {

struct SharedConstant {
  std::string name;
  ScalarType type = ScalarType::kUint;  ///< kUint, kInt or kFloat
  uint32_t bits = 0;                    ///< the value, as the GPU has it
  uint32_t line = 0;
  bool operator==(const SharedConstant&) const = default;
};

/// The constants that `file` itself declares at file scope, in its order and without values; not
/// those of files that it includes. Errors: PK510 for one that is no single uint, int or float, or
/// whose name is no C++ name; PK512 when there is none.
/// \param preprocessed the file with all that it includes, with #line directives
std::vector<SharedConstant> findConstants(const std::string& preprocessed, const std::string& file,
                                          Diagnostics& diagnostics);

/// A compute kernel behind the preprocessed file that stores each constant, for readConstants().
FrontEndInput constantsProbe(FrontEndInput source, const std::string& preprocessed,
                             std::span<const SharedConstant> constants);

/// Reads the values from the SPIR-V of the probe. Error PK511: the compiler finds no value for one.
void readConstants(std::span<const uint32_t> spirv, const std::string& file,
                   std::vector<SharedConstant>& constants, Diagnostics& diagnostics);

/// The value in C++: "64u", "-3", "0.001f".
std::string constantValue(const SharedConstant& constant);

}  // namespace pelage::codegen
