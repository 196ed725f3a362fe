// Results on disk under the hash of everything that they depend on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace pelage::codegen {

class Cache {
 public:
  explicit Cache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Empty when there is none or the file is damaged.
  std::optional<std::string> load(const std::string& key) const;
  /// A result that cannot be written is made again the next time.
  void store(const std::string& key, std::string_view payload) const;
  /// Deletes the entries that were not used for the longest time until all fit into `bytes`.
  void prune(uint64_t bytes) const;

 private:
  std::filesystem::path path(const std::string& key) const { return folder_ / (key + ".bin"); }
  std::filesystem::path folder_;
};

}  // namespace pelage::codegen
