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

/// A cursor that never reads past the end. Bytes and name must outlive it.
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> bytes, std::string_view name)
      : bytes_(bytes), name_(name) {}

  std::string_view name() const { return name_; }
  uint64_t offset() const { return offset_; }
  uint64_t size() const { return bytes_.size(); }
  uint64_t left() const { return bytes_.size() - offset_; }

  /// \param what  names the value in the error: the file ends inside it
  template <class T>
  Result<T> value(std::string_view what) {
    if (left() < sizeof(T)) return truncated(what);
    offset_ += sizeof(T);
    return readAt<T>(bytes_, offset_ - sizeof(T));
  }
  Result<std::string> text(uint32_t length, std::string_view what);

 private:
  Error truncated(std::string_view what) const;

  std::span<const std::byte> bytes_;
  std::string_view name_;
  uint64_t offset_ = 0;
};

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

}  // namespace pelage::detail
