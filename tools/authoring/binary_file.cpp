#include "binary_file.h"

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <system_error>

#include "pelage/stream.h"

namespace pelage::tools {

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path) {
  auto file = FileSource::open(path);
  return file ? readAll(*file, path.string()) : file.error();
}

Result<void> writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const auto failed = [&](std::string_view what) {
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: {}", path.string(), what)};
  };
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) return failed("cannot be written; check that its folder exists and is writable");
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return {};
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  return failed(fmt::format("writing {} bytes failed; is the disk full?", bytes.size()));
}

Error fileError(std::string_view name, uint64_t offset, std::string_view what) {
  return {ErrorCode::kInvalidFile, fmt::format("{}: byte {}: {}", name, offset, what)};
}

}  // namespace pelage::tools
