// Finds more than the first error of a kernel. The HLSL front end gives up at the first one; this
// blanks the statement that holds it and compiles again.
#pragma once

#include <string>
#include <vector>

#include "codegen/front_end.h"

namespace pelage::codegen {

/// Messages for the errors of a kernel that does not compile, one for each statement, in the order
/// in which the front end finds them. `preprocessed` is preprocessHlsl()'s text for the same input,
/// `first` what the front end said about it.
std::vector<FrontEndMessage> findAllErrors(FrontEndInput input, std::string preprocessed,
                                           const std::vector<FrontEndMessage>& first);

}  // namespace pelage::codegen
