// Whole files in memory, and values in little-endian bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/result.h"

namespace pelage::tools {

static_assert(std::endian::native == std::endian::little, "files are read and written by copying");

/// Errors: the file does not exist, is no regular file, cannot be read.
Result<std::vector<std::byte>> readFile(const std::filesystem::path& path);

/// Errors: the file cannot be created or written; a partial file is removed.
Result<void> writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// "name: byte N: what"
Error fileError(std::string_view name, uint64_t offset, std::string_view what);

/// The bytes must have sizeof(T) from the offset on.
template <class T>
T readAt(std::span<const std::byte> bytes, uint64_t offset) {
  T value;
  std::memcpy(&value, &bytes[offset], sizeof(T));
  return value;
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  const auto added = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), added.begin(), added.end());
}

}  // namespace pelage::tools
