#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

#include "pelage/gl.h"

namespace pelage::gl {
namespace {

namespace fs = std::filesystem;

// No program binary is near this; a larger file is not ours.
constexpr uintmax_t kLargestFile = 64u << 20;

fs::path fileOf(const std::string& directory, uint64_t key) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "%016llx.glprogram",
                static_cast<unsigned long long>(key));
  return fs::path(directory) / name.data();
}

std::vector<std::byte> loadFile(const fs::path& path) {
  std::error_code error;
  const uintmax_t size = fs::file_size(path, error);
  if (error || size > kLargestFile) return {};
  std::vector<std::byte> bytes(static_cast<size_t>(size));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    return {};
  return bytes;
}

// Written beside its place and renamed, so that no other process reads half of it.
void storeFile(const fs::path& path, std::span<const std::byte> bytes) {
  static std::atomic<uint32_t> serial{0};
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return;
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  fs::path part = path;
  part += "." + std::to_string(now) + "." + std::to_string(serial++);
  bool written = false;
  {
    std::ofstream file(part, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file.close();
    written = static_cast<bool>(file);
  }
  if (written) fs::rename(part, path, error);
  if (!written || error) fs::remove(part, error);
}

}  // namespace

ProgramCache directoryProgramCache(std::string directory) {
  ProgramCache cache;
  cache.load = [directory](uint64_t key) -> std::vector<std::byte> {
    try {
      return loadFile(fileOf(directory, key));
    } catch (const std::bad_alloc&) {
      return {};
    }
  };
  cache.store = [directory = std::move(directory)](uint64_t key, std::span<const std::byte> bytes) {
    try {
      storeFile(fileOf(directory, key), bytes);
    } catch (const std::bad_alloc&) {
      // Not stored: the next run compiles again.
    }
  };
  return cache;
}

}  // namespace pelage::gl
