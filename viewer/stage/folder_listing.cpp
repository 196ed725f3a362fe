#include "stage/folder_listing.h"

#include <algorithm>
#include <system_error>
#include <tuple>

#include "stage/files.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;

pelage::Result<std::vector<FolderEntry>> listFolder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::vector<FolderEntry> entries;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;  // an entry that is gone is no folder
    const bool isFolder = at->is_directory(ignored);
    if (name.starts_with('.') || (!isFolder && !isKnownFile(at->path()))) continue;
    entries.push_back({name, isFolder});
  }
  if (error)
    return Error{ErrorCode::kFileNotFound,
                 folder.string() + " cannot be listed: " + error.message()};
  std::sort(entries.begin(), entries.end(), [](const FolderEntry& a, const FolderEntry& b) {
    return std::tuple(!a.isFolder, a.name) < std::tuple(!b.isFolder, b.name);
  });
  return entries;
}

}  // namespace viewer
