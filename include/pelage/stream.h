// Sources of bytes for loaders: a file, memory, or the engine's own files (archives, asset
// databases).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/export.h"
#include "pelage/result.h"

namespace pelage {

/// Bytes with random access. Loaders read in ascending order if the format allows it, and only the
/// bytes they need.
///
/// Threads: one loader, on one thread, at a time; of every kind of source.
class PELAGE_API ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Total size in bytes; loaders call it once. If the source has fewer bytes, reading past its end
  /// is an error, and the loader allocates at most twice what it has read, or 8 MiB.
  virtual uint64_t size() = 0;
  /// Reads up to out.size() bytes from `offset`, all below size(). It may read fewer; the loader
  /// then asks again for the rest.
  /// \return the number of bytes read; 0 if reading failed, which ends the loading with an error.
  /// Exceptions end it, too.
  virtual size_t read(uint64_t offset, std::span<std::byte> out) = 0;
};

/// Bytes in memory. The memory must outlive the source.
class PELAGE_API MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  uint64_t size() override { return bytes_.size(); }
  size_t read(uint64_t offset, std::span<std::byte> out) override;

 private:
  std::span<const std::byte> bytes_;
};

/// A file.
class PELAGE_API FileSource final : public ByteSource {
 public:
  /// Errors: the file does not exist, is no regular file, cannot be opened.
  static Result<FileSource> open(const std::filesystem::path& path);
  uint64_t size() override { return size_; }
  size_t read(uint64_t offset, std::span<std::byte> out) override;

 private:
  FileSource(std::ifstream file, uint64_t size) : file_(std::move(file)), size_(size) {}
  std::ifstream file_;
  uint64_t size_ = 0, position_ = 0;
};

/// Bytes from the engine's own functions, in the style of archives.
class PELAGE_API CallbackSource final : public ByteSource {
 public:
  struct Functions {
    std::function<uint64_t()> size;
    /// Seeks to a byte; returns false if that failed. Called only if the position changes.
    std::function<bool(uint64_t offset)> seek;
    /// Reads from that position and advances it by the returned number of bytes; 0 if reading
    /// failed.
    std::function<size_t(std::span<std::byte> out)> read;
  };
  /// Asserts that all functions are set.
  explicit CallbackSource(Functions functions);
  uint64_t size() override { return functions_.size(); }
  size_t read(uint64_t offset, std::span<std::byte> out) override;

 private:
  Functions functions_;
  uint64_t position_ = 0;
  bool placed_ = false;
};

/// Reads all bytes of a source, for loaders that take memory; `name` names it in errors. Errors
/// name the byte at which reading failed.
PELAGE_API Result<std::vector<std::byte>> readAll(ByteSource& source, std::string_view name);

}  // namespace pelage
