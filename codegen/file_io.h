// Reads and writes whole files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace pelage::codegen {

/// Returns nothing if it is not a regular file or cannot be read.
std::optional<std::string> readWholeFile(const std::filesystem::path& path);

/// Writes under a temporary name and renames, so that nobody reads half a file. Creates the folder.
/// Returns false if the file system refuses.
bool writeWholeFile(const std::filesystem::path& path, std::string_view text);

/// As writeWholeFile, but does not touch a file with the same bytes, nor its time.
bool writeIfChanged(const std::filesystem::path& path, std::string_view text);

}  // namespace pelage::codegen
