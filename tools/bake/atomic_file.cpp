#include "atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace pelage::bake {
namespace {

using Path = std::filesystem::path;

Error systemError(const Path& path, const char* what) {
  return {errno == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kInvalidFile,
          fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno))};
}

Result<void> writeAll(int descriptor, const Path& path, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return systemError(path, "cannot be written");
    data += written;
    size -= static_cast<size_t>(written);
  }
  return {};
}

// A name in a folder is on the disk when the folder is.
Result<void> syncFolder(const Path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return systemError(folder, "cannot be opened");
  // Some file systems have no fsync of folders.
  const bool failed = ::fsync(descriptor) != 0 && errno != EINVAL && errno != ENOTSUP;
  Result<void> done;
  if (failed) done = systemError(folder, "fsync");
  ::close(descriptor);
  return done;
}

std::string hostName() {
  std::array<char, 256> name = {};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
  return name.data();
}

struct flock wholeFile() {
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

}  // namespace

std::filesystem::path temporaryName(const Path& path, std::string_view tag) {
  return path.parent_path() /
         fmt::format(".{}.tmp-{}-{}-{}", path.filename().string(), tag, hostName(), ::getpid());
}

AtomicFile::AtomicFile(Path path, Path temporary, int descriptor)
    : path_(std::move(path)), temporary_(std::move(temporary)), descriptor_(descriptor) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, Path())),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

Result<AtomicFile> AtomicFile::create(const Path& path, std::string_view tag) {
  const Path temporary = temporaryName(path, tag);
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return systemError(temporary, "cannot be created");
  return AtomicFile(path, temporary, descriptor);
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  return writeAll(descriptor_, path_, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Result<void> AtomicFile::commit() {
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) return systemError(path_, "close");
  Result<void> done = commitFile(temporary_, path_);
  if (done) temporary_.clear();
  return done;
}

Result<void> commitFile(const Path& temporary, const Path& path) {
  const int descriptor = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return systemError(temporary, "cannot be opened");
  Result<void> done;
  if (::fsync(descriptor) != 0) done = systemError(path, "fsync");
  ::close(descriptor);
  if (!done) return done;
  if (::rename(temporary.c_str(), path.c_str()) != 0) return systemError(path, "cannot be renamed");
  return syncFolder(path.parent_path());
}

Result<void> writeAtomic(const Path& path, std::string_view tag, std::string_view text) {
  auto file = AtomicFile::create(path, tag);
  if (!file) return file.error();
  if (auto done = file->write(std::as_bytes(std::span(text))); !done) return done;
  return file->commit();
}

Result<void> appendLine(const Path& path, std::string_view line) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) return systemError(path, "cannot be opened");
  const std::string text = std::string(line) + "\n";
  Result<void> done = writeAll(descriptor, path, text.data(), text.size());
  ::close(descriptor);
  return done;
}

void removeTemporaries(const Path& folder, std::string_view tag) {
  const std::string mark = fmt::format(".tmp-{}-", tag);
  std::error_code ignored;
  for (std::filesystem::directory_iterator it(folder, ignored), end; it != end;
       it.increment(ignored)) {
    const std::string name = it->path().filename().string();
    if (name.front() == '.' && name.find(mark) != std::string::npos)
      std::filesystem::remove(it->path(), ignored);
    if (ignored) return;
  }
}

Result<void> makeFolder(const Path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code)
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: cannot be created: {}", folder.string(), code.message())};
  return {};
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<FileLock> FileLock::take(const Path& path, Wait wait) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) return systemError(path, "cannot be created");
  struct flock lock = wholeFile();
  int taken = -1;
  do {
    taken = ::fcntl(descriptor, wait == Wait::kYes ? F_OFD_SETLKW : F_OFD_SETLK, &lock);
  } while (taken != 0 && errno == EINTR);
  if (taken == 0) return FileLock(descriptor);
  const bool busy = errno == EAGAIN || errno == EACCES;
  const Error error = systemError(path, "cannot be locked");
  ::close(descriptor);
  if (busy) return FileLock(-1);
  return error;
}

bool FileLock::isHeld(const Path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  struct flock lock = wholeFile();
  const bool held = ::fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
  ::close(descriptor);
  return held;
}

}  // namespace pelage::bake
