#include "stage/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <tuple>
#include <utility>

#include "asset_files.h"
#include "modeling_files.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;
using pelage::program::lowerExtension;
using Path = std::filesystem::path;

namespace {

// Finds the file with the name of the hair and an extension: among the named files, or beside the
// hair; "-": there is none.
Path companionOf(const Path& hair, const char* extension, std::span<const Path> files) {
  for (const Path& file : files)
    if (lowerExtension(file) == extension && file.stem() == hair.stem()) return file;
  Path beside = hair;
  beside.replace_extension(extension);
  std::error_code error;
  return std::filesystem::is_regular_file(beside, error) ? beside : Path("-");
}

std::string openedFiles() {
  return fmt::format(".tfx, .tfxbone, .tfxfollow, .tfxmesh, .pelage{}",
                     sample::modelingExtensions());
}

struct Sorted {
  pelage::program::AssetFiles own;  // pelage's own formats
  std::vector<Path> modeling;       // sample::isModelingFile()
};

Result<Sorted> sortFiles(std::span<const Path> files) {
  Sorted sorted;
  sorted.own.repair = true;
  for (const Path& file : files) {
    const std::string extension = lowerExtension(file);
    if (extension == ".tfx") {
      sorted.own.hairs.push_back(file);
      sorted.own.bones.push_back(companionOf(file, ".tfxbone", files));
      sorted.own.followHairs.push_back(companionOf(file, ".tfxfollow", files));
    } else if (extension == ".tfxmesh") {
      sorted.own.meshes.push_back(file);
    } else if (extension == ".pelage") {
      if (!sorted.own.cache.empty())
        return Error{ErrorCode::kInvalidArgument,
                     file.string() + ": a second .pelage file; one holds a whole scene"};
      sorted.own.cache = file;
    } else if (sample::isModelingFile(extension)) {
      sorted.modeling.push_back(file);
    } else if (extension != ".tfxbone" && extension != ".tfxfollow") {
      return Error{ErrorCode::kUnsupported,
                   fmt::format("{}: the viewer opens {}", file.string(), openedFiles())};
    }
  }
  return sorted;
}

// Loads all files; scale and guesses stay.
Result<void> loadSorted(Sorted sorted, const std::string& clip, LoadedFiles& loaded) {
  loaded.remarks.clear();
  loaded.motion.reset();
  sorted.own.scale = loaded.scale;
  auto assets = pelage::program::loadAssetFiles(sorted.own, loaded.remarks);
  if (!assets) return assets.error();
  loaded.assets = *std::move(assets);
  if (Result<void> done = sample::addModelingFiles(
          sorted.modeling, {.scale = loaded.scale, .clip = clip}, loaded, loaded.remarks);
      !done)
    return done;
  if (loaded.assets.hairs.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "there is no hair in the files: name a groom, too (.tfx or .pelage)"};
  return {};
}

// Returns the mean length of all strands.
Result<double> meanLengthOf(const pelage::AssetCache& assets) {
  double sum = 0, count = 0;
  for (const pelage::CachedHair& hair : assets.hairs) {
    const auto size = pelage::measureHair(hair.asset);
    if (!size) return size.error();
    sum += size->meanLength * hair.asset.strandCount;
    count += hair.asset.strandCount;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

Result<LoadedFiles> loadFiles(std::span<const Path> files, float scale, const std::string& clip) {
  const Result<Sorted> sorted = sortFiles(files);
  if (!sorted) return sorted.error();
  LoadedFiles loaded;
  loaded.scale = scale > 0 ? scale : 1;
  if (Result<void> done = loadSorted(*sorted, clip, loaded); !done) return done.error();
  Result<double> length = meanLengthOf(loaded.assets);
  if (!length) return length.error();
  loaded.guesses = pelage::guessUnits(*length / loaded.scale);
  if (scale <= 0 && !loaded.guesses.empty()) {
    loaded.scale = loaded.guesses.front().scale;
    if (Result<void> done = loadSorted(*sorted, clip, loaded); !done) return done.error();
    length = meanLengthOf(loaded.assets);
    if (!length) return length.error();
    loaded.remarks.push_back(fmt::format("taken for {}: strands are {:.3g} m long on average",
                                         loaded.guesses.front().unit, *length));
  }
  loaded.meanLength = *length;
  return loaded;
}

bool isKnownFile(const Path& path) {
  const std::string extension = lowerExtension(path);
  constexpr const char* kOwn[] = {".tfx", ".tfxbone", ".tfxfollow", ".tfxmesh", ".pelage", ".json"};
  return std::find(std::begin(kOwn), std::end(kOwn), extension) != std::end(kOwn) ||
         sample::isModelingFile(extension);
}

pelage::Result<FolderList> listFolder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  FolderList list;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;  // an entry may be gone by now
    const bool isFolder = at->is_directory(ignored);
    if (name.starts_with('.')) continue;
    if (!isFolder) ++(isKnownFile(at->path()) ? list.fileCount : list.otherCount);
    if (isFolder || isKnownFile(at->path())) list.entries.push_back({name, isFolder});
  }
  if (error)
    return Error{ErrorCode::kFileNotFound,
                 folder.string() + " cannot be listed: " + error.message()};
  std::sort(list.entries.begin(), list.entries.end(),
            [](const FolderEntry& a, const FolderEntry& b) {
              return std::tuple(!a.isFolder, a.name) < std::tuple(!b.isFolder, b.name);
            });
  return list;
}

std::string reasonForNoFiles(const FolderList& list) {
  const std::string others =
      list.otherCount == 0 ? "No files are here."
      : list.otherCount == 1
          ? "The file here is none that the viewer opens."
          : fmt::format("None of the {} files here is one that the viewer opens.", list.otherCount);
  return fmt::format("{} It opens {}, and settings as .json.", others, openedFiles());
}

}  // namespace viewer
