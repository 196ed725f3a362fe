// Reads and writes whole files; a reader of little-endian binary data that knows its position.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pelage/result.h"

namespace pelage::detail {

static_assert(std::endian::native == std::endian::little,
              "the file formats are little endian and are read by copying");

/// Errors: the file does not exist, is no regular file, cannot be read.
Result<std::vector<std::byte>> readFile(const std::filesystem::path& path);

/// Errors: the file cannot be created or written; a partial file is removed.
Result<void> writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// "name: byte N: what"
Error fileError(std::string_view name, uint64_t offset, std::string_view what);

template <class T>
T readAt(std::span<const std::byte> bytes, uint64_t offset) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

}  // namespace pelage::detail
