#include "codegen/file_io.h"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

namespace pelage::codegen {

namespace fs = std::filesystem;

std::optional<std::string> readWholeFile(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return std::nullopt;
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) return std::nullopt;
  return std::move(text).str();
}

bool writeWholeFile(const fs::path& path, std::string_view text) {
  static std::atomic<uint32_t> counter{0};
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  fs::path temporary = path;
  temporary += "." + std::to_string(getpid()) + "-" + std::to_string(counter++) + ".tmp";
  {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) {
      fs::remove(temporary, error);
      return false;
    }
  }
  fs::rename(temporary, path, error);
  if (!error) return true;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  return false;
}

bool writeIfChanged(const fs::path& path, std::string_view text) {
  const std::optional<std::string> old = readWholeFile(path);
  if (old && *old == text) return true;
  return writeWholeFile(path, text);
}

}  // namespace pelage::codegen
