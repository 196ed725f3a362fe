// Grooms and meshes from the files that a user names or drops.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "demo_scene.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace viewer {

struct LoadedFiles : sample::FileAssets {
  float scale = 1;        ///< meters per unit of the files
  double meanLength = 0;  ///< of the scaled strands [m]
  std::vector<pelage::UnitGuess>
      guesses;                       ///< units of the files, the likeliest first; empty: meters
  std::vector<std::string> remarks;  ///< of the loaders, one a line: repaired values, a likely unit
};

/// Loads files by their extensions: .tfx with .tfxbone and .tfxfollow of the same name (named as
/// well, or beside it), .tfxmesh, .pelage; with the authoring library .hair and .hairtxt, and
/// characters: .gltf, .glb and .obj. The curves of a character are hair, its triangles are
/// colliders that hair without bones follows, and its first clip moves the bones. \param scale
/// meters per unit; 0: found from the size of the hair. \param clip name of the clip. Errors: those
/// of the loaders, another kind of file, no hair, several .pelage.
pelage::Result<LoadedFiles> loadFiles(std::span<const std::filesystem::path> files, float scale,
                                      const std::string& clip = {});

/// Whether loadFiles() takes files with this name, or the viewer settings: .json.
bool isKnownFile(const std::filesystem::path& path);

struct FolderEntry {
  std::string name;
  bool isFolder = false;
  bool operator==(const FolderEntry&) const = default;
};

struct FolderList {
  std::vector<FolderEntry> entries;  ///< folders, then files, each sorted by name
  size_t fileCount = 0;              ///< of files in `entries`
  size_t otherCount = 0;             ///< of files that isKnownFile() does not know
};

/// Lists folders, and files that isKnownFile() knows, without names that begin with a point.
/// Errors: a folder that cannot be read.
pelage::Result<FolderList> listFolder(const std::filesystem::path& folder);
/// Returns why a list has no files: what the viewer opens, and how many other files there are.
std::string reasonForNoFiles(const FolderList& list);

}  // namespace viewer
