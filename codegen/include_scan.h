// Finds every file that a kernel may include, whatever the permutation: the input of cache keys and
// depfiles.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace pelage::codegen {

/// Reads files once and follows their #include lines, with the search order of the front end. Files
/// that have been read may be asked for by several threads.
class IncludeScanner {
 public:
  IncludeScanner(std::filesystem::path baseDir, std::vector<std::filesystem::path> includeDirs)
      : baseDir_(std::move(baseDir)), includeDirs_(std::move(includeDirs)) {}

  /// Returns the names (see displayName()) of the file and all its direct and indirect includes,
  /// sorted. Included files that do not exist are left out.
  std::vector<std::string> closure(const std::string& file);

  /// Returns the SHA-256 of a file's content in hex digits; "missing" if there is none.
  const std::string& contentHash(const std::string& name) { return entry(name).hash; }

  /// Returns the paths of all files of all closures, sorted.
  std::set<std::filesystem::path> files() const;

 private:
  struct Entry {
    std::string hash = "missing";
    std::vector<std::string> includes;  ///< resolved names
  };
  Entry& entry(const std::string& name);
  std::filesystem::path pathOf(const std::string& name) const;

  std::filesystem::path baseDir_;
  std::vector<std::filesystem::path> includeDirs_;
  std::map<std::string, Entry> entries_;
};

}  // namespace pelage::codegen
