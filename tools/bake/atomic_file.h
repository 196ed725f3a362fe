// Files that appear under their name when all of their bytes are on the disk, and locks that a
// crashed process does not keep.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "pelage/result.h"

namespace pelage::bake {

/// A file that is written under a temporary name. It is removed where commit() is not called; a
/// process that is killed leaves it, and removeTemporaries() finds it.
class AtomicFile {
 public:
  /// \param tag  names the writer in the temporary name: letters, digits, '-'. Errors: as the
  /// system says them.
  static Result<AtomicFile> create(const std::filesystem::path& path, std::string_view tag);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  /// Errors: a full disk and whatever else the system says.
  Result<void> write(std::span<const std::byte> bytes);
  /// Waits until the bytes are on the disk, and gives the file its name.
  Result<void> commit();

 private:
  AtomicFile(std::filesystem::path path, std::filesystem::path temporary, int descriptor);

  std::filesystem::path path_, temporary_;
  int descriptor_ = -1;
};

/// The temporary name of a file: of this process, and of no other one on any machine.
std::filesystem::path temporaryName(const std::filesystem::path& path, std::string_view tag);
/// Gives a complete file that somebody else has written its name: fsync, rename, fsync of the
/// folder.
Result<void> commitFile(const std::filesystem::path& temporary, const std::filesystem::path& path);
/// Writes all of a file at once.
Result<void> writeAtomic(const std::filesystem::path& path, std::string_view tag,
                         std::string_view text);
/// Appends a line to a file in one write, so that lines of several processes do not mix.
Result<void> appendLine(const std::filesystem::path& path, std::string_view line);
/// Removes what processes with this tag have left in a folder.
void removeTemporaries(const std::filesystem::path& folder, std::string_view tag);
/// Creates a folder and its parents. Errors: as the system says them.
Result<void> makeFolder(const std::filesystem::path& folder);

/// An exclusive lock on a file, which the system releases when the process ends, however it ends.
class FileLock {
 public:
  enum class Wait : uint8_t { kNo, kYes };
  /// Takes it. \return a lock that does not hold where another process has it and `wait` is kNo.
  /// Errors: a file that cannot be created, a file system without locks.
  static Result<FileLock> take(const std::filesystem::path& path, Wait wait);
  /// Whether a process holds it, without taking it.
  static bool isHeld(const std::filesystem::path& path);
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();
  bool holds() const { return descriptor_ >= 0; }

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace pelage::bake
