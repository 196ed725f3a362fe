#include "base/file_io.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "pelage/stream.h"

namespace pelage::detail {

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path) {
  auto file = FileSource::open(path);
  if (!file) return file.error();
  return readAll(*file, path.string());
}

Result<void> writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file)
    return Error{ErrorCode::kFileNotFound,
                 fmt::format("{}: cannot be written; check that its folder exists and is writable",
                             path.string())};
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return Error{
        ErrorCode::kFileNotFound,
        fmt::format("{}: writing {} bytes failed; is the disk full?", path.string(), bytes.size())};
  }
  return {};
}

Error fileError(std::string_view name, uint64_t offset, std::string_view what) {
  return Error{ErrorCode::kInvalidFile, fmt::format("{}: byte {}: {}", name, offset, what)};
}

Result<std::string> ByteReader::text(uint32_t length, std::string_view what) {
  if (left() < length) return truncated(what);
  offset_ += length;
  return std::string(reinterpret_cast<const char*>(bytes_.data() + offset_ - length), length);
}

Error ByteReader::truncated(std::string_view what) const {
  return fileError(name_, bytes_.size(), fmt::format("the file ends inside {}", what));
}

}  // namespace pelage::detail
