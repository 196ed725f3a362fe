// A project of pelage-bake: the shots that are to be simulated, and where their hair goes.
// docs/bake.md describes the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "asset_files.h"
#include "pelage/asset_cache.h"
#include "pelage/demo/character.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"

namespace pelage::bake {

enum class GeneratedKind : uint8_t { kCharacter, kHead };

/// Assets that the program makes itself.
struct GeneratedAssets {
  GeneratedKind kind = GeneratedKind::kCharacter;
  uint64_t seed = 1;
  std::optional<uint32_t> guides;   ///< of the long hair, others in proportion; or of the head
  std::vector<std::string> grooms;  ///< of a character: empty for all
};

/// Frames A to B, both included.
struct FrameRange {
  int64_t first = 0, last = 0;
  uint64_t count() const { return static_cast<uint64_t>(last - first + 1); }
  bool operator==(const FrameRange&) const = default;
};

struct Shot {
  std::string name;  ///< letters, digits, '.', '_' and '-': a folder has it, too
  FrameRange frames;
  uint32_t preRoll = 0;  ///< frames in the first pose that come before, and are not written

  program::AssetFiles files;
  std::optional<GeneratedAssets> generated;  ///< in place of `files`
  bool collides = true;                      ///< with meshes
  double cellSize = 0;                       ///< of the meshes' SDFs [m]; 0: the default

  /// Whether something moves bones.
  bool hasBones() const { return !animation.empty() || motion || !transforms.empty(); }

  std::filesystem::path animation;        ///< glTF; empty: none
  std::string clip;                       ///< empty: the first one
  std::optional<CharacterMotion> motion;  ///< in place of `animation`
  std::filesystem::path transforms;       ///< loadBoneStream(), in place of `animation`
  std::filesystem::path points;           ///< PointCache, beside all of these; empty: none
  std::filesystem::path pointMesh;        ///< that it moves: loadSkinMesh()
  double pointsPerSecond = 24;            ///< frames of the point cache [1/s]
  double animationStart = 0;              ///< time of the first frame [s]

  std::filesystem::path settings;  ///< empty: none
  std::optional<Solver> solver;    ///< these two go before `settings`
  std::optional<uint32_t> subSteps;
  std::optional<double> errorBound;  ///< [m]; chooses the sub-steps
  double errorShare = 0.99;          ///< of the vertices that are to be within it
  bool followHairs = false;          ///< they are written behind the guides
};

struct Project {
  std::filesystem::path file;
  std::filesystem::path output;  ///< folder
  double framesPerSecond = 24;
  uint32_t chunkFrames = 16;      ///< frames of a chunk; chunks begin at multiples of it
  uint32_t checkpointChunks = 4;  ///< chunks from checkpoint to checkpoint
  float cacheError = 1e-4f;       ///< of the cache [m]
  bool usd = false;               ///< also writes .usda
  Api api = Api::kVulkan;
  std::string device;  ///< index or UUID; empty: the best one
  std::vector<Shot> shots;

  /// nullptr: there is none.
  const Shot* find(std::string_view name) const;
};

/// Loads and checks a project. Relative paths are relative to the file. Errors name the file and a
/// JSON pointer, and say what it must be.
Result<Project> loadProject(const std::filesystem::path& path);

/// Frames of a chunk: the first one of a shot begins with its first frame.
FrameRange chunkOf(const Project& project, const Shot& shot, uint64_t chunk);
uint64_t chunkCount(const Project& project, const Shot& shot);

/// Hashes of files, each read once while its size and time stay. Threads: one at a time.
class FileHashes {
 public:
  /// Errors: a file that cannot be read.
  Result<SourceKey> of(const std::filesystem::path& path);
  uint64_t filesRead() const { return filesRead_; }

 private:
  struct Known {
    uint64_t size = 0;
    std::filesystem::file_time_type time;
    SourceKey key;
  };
  std::map<std::filesystem::path, Known> known_;
  uint64_t filesRead_ = 0;
};

/// A key of all that the frames of a shot depend on: the project's and the shot's settings, and the
/// bytes of all files. \param hashes  of the files that shots share. Errors: a file that cannot be
/// read.
Result<uint64_t> fingerprintOf(const Project& project, const Shot& shot, FileHashes& hashes);

/// A key of all that loadAssets() gives: shots with the same one can share hair and meshes. Errors:
/// as fingerprintOf().
Result<uint64_t> assetKeyOf(const Shot& shot, FileHashes& hashes);

}  // namespace pelage::bake
