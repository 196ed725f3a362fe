// Files that programs write.
#pragma once

#include <filesystem>
#include <string_view>

#include "pelage/result.h"

namespace pelage::program {

/// Checks the name of an output before anything is read or written, so that no file of another kind
/// is replaced. Errors: another extension than that of the format; upper case does not matter.
/// \param extension with its dot, in lower case
Result<void> checkOutput(const std::filesystem::path& path, std::string_view extension);

}  // namespace pelage::program
