// Whole files in and out.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace pelage::codegen {

/// Empty when it is not a regular file or cannot be read.
std::optional<std::string> readWholeFile(const std::filesystem::path& path);

/// Writes under another name and renames, so that nobody sees half a file. Makes the folder. False
/// when the file system refuses.
bool writeWholeFile(const std::filesystem::path& path, std::string_view text);

/// As writeWholeFile, but leaves a file with the same bytes, and its time, alone.
bool writeIfChanged(const std::filesystem::path& path, std::string_view text);

}  // namespace pelage::codegen
