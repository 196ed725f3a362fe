// What of a folder the viewer can open.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pelage/result.h"

namespace viewer {

struct FolderEntry {
  std::string name;
  bool isFolder = false;
  bool operator==(const FolderEntry&) const = default;
};

/// Lists folders, then files that isKnownFile() knows, each by name; without hidden ones, whose
/// names begin with a point. Errors: a folder that cannot be read.
pelage::Result<std::vector<FolderEntry>> listFolder(const std::filesystem::path& folder);

}  // namespace viewer
