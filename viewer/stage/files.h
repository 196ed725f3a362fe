// Grooms and meshes from the files that a user names or drops.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "demo_scene.h"
#include "pelage/asset_cache.h"
#include "pelage/hair_size.h"
#include "pelage/result.h"

namespace viewer {

struct LoadedFiles {
  pelage::AssetCache assets;
  float scale = 1;        ///< meters per unit of the files
  double meanLength = 0;  ///< of the scaled strands [m]
  std::vector<pelage::UnitGuess>
      guesses;                       ///< units of the files, the likeliest first; empty: meters
  std::vector<std::string> remarks;  ///< of the loaders, one a line: repaired values, a likely unit
  std::optional<sample::BoneMotion> motion;  ///< of the bones: a clip of a file
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

/// Lists folders, then files that isKnownFile() knows, each sorted by name, without names that
/// begin with a point. Errors: a folder that cannot be read.
pelage::Result<std::vector<FolderEntry>> listFolder(const std::filesystem::path& folder);

// Files of modeling programs, read by the authoring library: hair curves, and characters that hair
// collides with and follows. A build without the library knows no such files.

/// Whether this build reads files of an extension (".hair") as hair curves.
bool isCurveFile(std::string_view extension);
/// Returns ", .hair, ..." for messages; empty without the authoring library.
const char* curveExtensions();
/// Loads and resamples a file; hair is processed. \param scale meters per unit. Errors: those of
/// the authoring library; a build without it.
pelage::Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float scale,
                                                 std::vector<std::string>& remarks);

/// Whether this build looks for meshes, skins and clips in files of an extension (".gltf").
bool isCharacterFile(std::string_view extension);

/// Adds the contents of a file to the files: its curves as hair, its triangles as a collider, and
/// its clip unless there is a motion already. Hair without bones follows the mesh. All files have
/// one scale, LoadedFiles::scale. \param clip name of the clip; empty: the first one. Errors: a
/// file with neither curves nor triangles; a clip that does not exist; a build without the
/// authoring library.
pelage::Result<void> addCharacterFile(const std::filesystem::path& path, const std::string& clip,
                                      LoadedFiles& files);

}  // namespace viewer
