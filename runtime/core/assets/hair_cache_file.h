// Shared by writing, reading and joining of .pelagecache files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>

#include "assets/hair_cache_format.h"
#include "pelage/result.h"

namespace pelage::detail::hair_cache {

/// Returns what is wrong with a def, without regard to its name; nullptr if it is right.
const char* faultOf(const HairCacheDef& def);
/// The sum of the vertices of all strands, also of a def that is not valid.
uint64_t countVertices(const HairCacheDef& def);

/// A file that appears under its name when it is closed, and not at all otherwise.
class OutputFile {
 public:
  /// Errors: the file cannot be created.
  static Result<OutputFile> create(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// Errors: the disk is full.
  Result<void> write(std::span<const std::byte> bytes);
  /// Errors: the disk is full, the file cannot be renamed.
  Result<void> close();
  uint64_t size() const { return size_; }  ///< [bytes] written

 private:
  OutputFile(std::filesystem::path path, std::filesystem::path partial, std::ofstream file)
      : path_(std::move(path)), partial_(std::move(partial)), file_(std::move(file)) {}
  Error failed(const char* what) const;

  std::filesystem::path path_, partial_;  ///< partial_ is empty if there is no such file
  std::ofstream file_;
  uint64_t size_ = 0;
};

}  // namespace pelage::detail::hair_cache
