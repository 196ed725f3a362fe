// A dialog that opens files.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "stage/folder_listing.h"
#include "window/window.h"

namespace viewer {

/// Files that a user wants to see.
struct FileChoice {
  std::vector<std::filesystem::path> files;
  bool adds = false;  ///< to those that are there, or in place of them
};

class FileDialog {
 public:
  /// Opens it in the folder where it was last, at first the current one; or closes it.
  void toggle();
  bool isOpen() const { return isOpen_; }
  /// Builds it, where it is open. \return what the user has chosen, once.
  std::optional<FileChoice> build(const WindowSize& size);

 private:
  std::optional<FileChoice> takePath();
  void buildEntries();
  void enter(const std::filesystem::path& folder);

  bool isOpen_ = false, wantsFocus_ = false;
  std::filesystem::path folder_;
  std::array<char, 1024> path_ = {};
  std::vector<FolderEntry> entries_;
  std::set<std::string> chosen_;  // names
  std::string error_;
};

}  // namespace viewer
