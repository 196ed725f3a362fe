// The folder of a shot: its complete files, and the progress of its work.
//
//   OUTPUT/SHOT/done.json             the shot is complete: its files with their hashes
//   OUTPUT/SHOT/GROOM.pelagecache     all frames, and GROOM.usda
//   OUTPUT/SHOT/log.jsonl             what has run, a line an event
//   OUTPUT/SHOT/lock, lock-A-B        locks of the folder, and of ranges of frames
//   OUTPUT/SHOT/work                  until it is complete: key.json, chunk-N.json with its files,
//                                     state-N (checkpoints), sub_steps.json
//
// Each file appears when it is complete (AtomicFile). A chunk is there when its .json is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pelage/result.h"
#include "project.h"

namespace pelage::bake {

/// A file of a folder with its expected size and hash.
struct StoredFile {
  std::string name;
  uint64_t bytes = 0;
  uint64_t hash = 0;  ///< XXH3, 64 bits
  bool operator==(const StoredFile&) const = default;
};

/// Hashes a file, and gives it another name in the result. Errors: a file that cannot be read.
Result<StoredFile> storedFile(const std::filesystem::path& path, std::string name);

class ShotStore {
 public:
  ShotStore(const Project& project, const Shot& shot);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path work() const { return folder_ / "work"; }
  std::filesystem::path lockPath() const { return folder_ / "lock"; }
  std::filesystem::path lockPath(const FrameRange& range) const;
  std::filesystem::path chunkFile(std::string_view hair, uint64_t chunk) const;
  std::filesystem::path checkpointFile(uint64_t steps) const;
  std::filesystem::path subStepsFile() const { return work() / "sub_steps.json"; }

  /// Contents of done.json; nothing where the shot is not complete. Errors: a file that is damaged.
  Result<std::optional<nlohmann::json>> done() const;
  /// The fingerprint of the work in the folder; nothing for an empty folder. \param device
  /// receives the device, where it is known.
  Result<std::optional<uint64_t>> fingerprint(std::string* device = nullptr) const;
  /// Makes the folders, and notes what the work is of. Errors: the folder has work of something
  /// else, or of another device.
  Result<void> begin(uint64_t fingerprint, const std::string& device, std::string_view tag) const;
  /// Removes all that the shot has written.
  Result<void> clear() const;

  /// Files of a chunk that is complete; empty where it is not. \param check  reads and hashes them.
  std::vector<StoredFile> chunk(uint64_t chunk, bool check) const;
  Result<void> addChunk(uint64_t chunk, const std::vector<StoredFile>& files,
                        std::string_view tag) const;
  /// Steps of the checkpoints that are there, ascending.
  std::vector<uint64_t> checkpoints() const;

  /// Adds an event to log.jsonl, with time, host and process.
  Result<void> log(nlohmann::json event) const;
  /// The events so far; lines that are incomplete are left out.
  std::vector<nlohmann::json> events() const;

 private:
  std::filesystem::path folder_;
};

nlohmann::json toJson(const std::vector<StoredFile>& files);
/// Errors: JSON that toJson() has not made. \param name  of the file, for errors
Result<std::vector<StoredFile>> filesOf(const nlohmann::json& from, const std::string& name);
/// Names the first file that is missing or has other bytes, and its error; empty if all is well.
/// \param hashes  false: compares sizes alone
std::string faultOf(const std::vector<StoredFile>& files, const std::filesystem::path& folder,
                    bool hashes);

}  // namespace pelage::bake
