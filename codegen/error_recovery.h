// Finds more than the first error of a kernel. The HLSL front end stops at the first one; this
// blanks the statement that contains it and compiles again.
#pragma once

#include <string>
#include <vector>

#include "codegen/front_end.h"

namespace pelage::codegen {

/// Returns messages for the errors of a kernel that does not compile, one per statement, in the
/// order in which the front end finds them. `preprocessed` is the text of preprocessHlsl() for the
/// same input, `first` the front end's result for it.
std::vector<FrontEndMessage> findAllErrors(FrontEndInput input, std::string preprocessed,
                                           const std::vector<FrontEndMessage>& first);

}  // namespace pelage::codegen
