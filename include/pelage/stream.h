// Where loaders read from: a file, memory, or the engine's own files (archives, asset databases).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/result.h"

namespace pelage {

/// Bytes that can be read at any place. Loaders read in ascending order where the format allows it,
/// and only what they need. A source is used by one loader at a time.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Bytes that there are. Loaders ask once. A source that says more than it has gets an error when
  /// its end is reached, and no more memory than twice what it gave, or 8 MiB.
  virtual uint64_t size() = 0;
  /// Reads from `offset` up to out.size() bytes, all below size(). Fewer are fine; then the loader
  /// asks again for the rest.
  /// \return how many; 0 when reading failed, which ends the loading with an error. Exceptions end
  /// it, too.
  virtual size_t read(uint64_t offset, std::span<std::byte> out) = 0;
};

/// Bytes in memory, which must stay there.
class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  uint64_t size() override { return bytes_.size(); }
  size_t read(uint64_t offset, std::span<std::byte> out) override;

 private:
  std::span<const std::byte> bytes_;
};

/// A file.
class FileSource final : public ByteSource {
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

/// The engine's own functions, of the kind that archives have.
class CallbackSource final : public ByteSource {
 public:
  struct Functions {
    std::function<uint64_t()> size;
    /// Goes to a byte; false when that failed. It is only called when the place changes.
    std::function<bool(uint64_t offset)> seek;
    /// Reads from there, and moves on by what it returns; 0 when reading failed.
    std::function<size_t(std::span<std::byte> out)> read;
  };
  /// Asserts that all functions are there.
  explicit CallbackSource(Functions functions);
  uint64_t size() override { return functions_.size(); }
  size_t read(uint64_t offset, std::span<std::byte> out) override;

 private:
  Functions functions_;
  uint64_t position_ = 0;
  bool placed_ = false;
};

/// All bytes of a source, for loaders that take memory; `name` is what errors call it. Errors name
/// the byte at which reading failed.
Result<std::vector<std::byte>> readAll(ByteSource& source, std::string_view name);

}  // namespace pelage
