#include "file_io.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

namespace pelage::detail {

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: no such file", path.string())};
  if (!std::filesystem::is_regular_file(status))
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: not a regular file", path.string())};
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error)
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: {}", path.string(), error.message())};
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{ErrorCode::kFileNotFound,
                 fmt::format("{}: cannot be opened; check its permissions", path.string())};
  std::vector<std::byte> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(file.gcount()) != size)
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: byte {}: reading failed", path.string(),
                                                      static_cast<uint64_t>(file.gcount()))};
  return bytes;
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

}  // namespace pelage::detail
