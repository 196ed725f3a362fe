#include "output_file.h"

#include <fmt/format.h>

#include "asset_files.h"

namespace pelage::program {

Result<void> checkOutput(const std::filesystem::path& path, std::string_view extension) {
  if (lowerExtension(path) == extension) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{}: nothing was written: the output needs the extension {}",
                           path.string(), extension)};
}

}  // namespace pelage::program
