// A cache on disk; the key is the hash of everything on which a result depends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace pelage::codegen {

/// Part of all keys. Counts up when the same tool and input give another result for a reason that
/// no hash sees.
inline constexpr uint64_t kCacheFormat = 1;

class Cache {
 public:
  explicit Cache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Returns the result; empty if there is none or the file is damaged.
  std::optional<std::string> load(const std::string& key) const;
  /// Stores a result. If it cannot be written, it is made again the next time.
  void store(const std::string& key, std::string_view payload) const;
  /// Deletes the least recently used entries until all fit into `bytes`.
  void prune(uint64_t bytes) const;

 private:
  std::filesystem::path path(const std::string& key) const { return folder_ / (key + ".bin"); }
  std::filesystem::path folder_;
};

}  // namespace pelage::codegen
