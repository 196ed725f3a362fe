#include "codegen/cache.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "codegen/file_io.h"
#include "codegen/hash.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
constexpr size_t kDigestLength = 64;

}  // namespace

std::optional<std::string> Cache::load(const std::string& key) const {
  std::optional<std::string> text = readWholeFile(path(key));
  if (!text || text->size() < kDigestLength) return std::nullopt;
  const std::string digest = text->substr(0, kDigestLength);
  text->erase(0, kDigestLength);
  if (sha256Hex(*text) != digest) return std::nullopt;
  std::error_code ignored;
  fs::last_write_time(path(key), fs::file_time_type::clock::now(), ignored);
  return text;
}

void Cache::store(const std::string& key, std::string_view payload) const {
  writeWholeFile(path(key), sha256Hex(payload) + std::string(payload));
}

void Cache::prune(uint64_t bytes) const {
  struct File {
    fs::file_time_type time;
    fs::path path;
    uint64_t size;
  };
  std::vector<File> files;
  uint64_t total = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    if (entry.path().extension() != ".bin") continue;
    std::error_code failed;
    const File file{entry.last_write_time(failed), entry.path(), entry.file_size(failed)};
    if (failed) continue;
    total += file.size;
    files.push_back(file);
  }
  std::sort(files.begin(), files.end(),
            [](const File& a, const File& b) { return a.time < b.time; });
  for (const File& file : files) {
    if (total <= bytes) break;
    fs::remove(file.path, error);
    total -= file.size;
  }
}

}  // namespace pelage::codegen
