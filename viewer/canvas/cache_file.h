// What a driver has compiled, kept in a file from one start to the next.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

namespace viewer {

/// The contents; empty where there is no such file.
std::vector<std::byte> readCache(const std::filesystem::path& path);
/// Writes the file with its folder, under another name first, so that it is always a whole one. A
/// folder that cannot be written is no error: the next start compiles again.
void writeCache(const std::filesystem::path& path, std::span<const std::byte> bytes);
/// Where caches of programs are: $XDG_CACHE_HOME/pelage, or ~/.cache/pelage; empty without either.
std::filesystem::path cacheFolder();

}  // namespace viewer
