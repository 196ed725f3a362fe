// The work of a project: lists it, reports progress, and verifies results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pelage/result.h"
#include "project.h"

namespace pelage::bake {

/// One command for `shotCount` shots (1 or more), or for a range of a shot's frames: each is a line
/// that a shell runs, in any order and at the same time as others. \param program  the path of
/// pelage-bake. \param rangeFrames  frames of a range, at most, of one shot; 0: all of a shot
std::vector<std::string> planCommands(const Project& project, const std::string& program,
                                      uint64_t rangeFrames, uint64_t shotCount = 1);

/// A word of a shell's command line, in quotes where it needs them.
std::string shellWord(const std::string& text);

/// "A-B", with numbers below 0, too; nothing for other text.
std::optional<FrameRange> parseFrames(const std::string& text);

enum class ShotState : uint8_t { kMissing, kPartial, kRunning, kComplete, kDamaged, kStale };
const char* toString(ShotState state);

struct ShotStatus {
  ShotState state = ShotState::kMissing;
  uint64_t chunks = 0, chunksWritten = 0;
  uint64_t checkpointSteps = 0;     ///< of the latest; 0: none
  uint64_t bytes = 0;               ///< of the files that are complete
  uint64_t stepsRun = 0;            ///< by all processes that have ended well, from log.jsonl
  double seconds = 0;               ///< likewise
  uint32_t starts = 0, errors = 0;  ///< processes that began to simulate, and errors of these
  std::string lastError;
  std::string fault;  ///< of kDamaged, with the way out
};
/// \param check  hashes the files that are complete; false: compares their sizes alone. Errors:
/// inputs that cannot be read.
Result<ShotStatus> statusOf(const Project& project, const Shot& shot, FileHashes& hashes,
                            bool check = false);

struct ShotCheck {
  bool complete = false;
  uint64_t files = 0, bytes = 0;
  std::string fault;  ///< with the way out; empty where all is well
};
/// Hashes all files of a complete shot, opens its caches and counts their frames; of a shot that is
/// not complete its chunks. \param decode  also decodes all frames
Result<ShotCheck> verifyShot(const Project& project, const Shot& shot, bool decode);

}  // namespace pelage::bake
