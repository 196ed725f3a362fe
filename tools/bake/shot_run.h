// Runs shots: simulates the frames that are missing, and completes the files.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "error_bound.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "project.h"

namespace pelage::bake {

struct RunOptions {
  std::optional<FrameRange> range;  ///< of whole chunks; nothing: all frames
  std::string device;               ///< index or UUID, before that of the project
  bool wait = true;                 ///< for another process that has the same frames
  bool restart = false;             ///< removes what is there first
  uint32_t threads = 0;             ///< that encode; 0: as many as the machine has cores
  /// Frames that have run and frames to run, the pre-roll included.
  std::function<void(uint64_t done, uint64_t total)> progress;
  /// Ends the run when it returns true: with a checkpoint before the frames to write; else behind
  /// the chunk at hand with a checkpoint, if its other frames take no more than `graceSeconds`, or
  /// behind the frame at hand. With 0 it writes no checkpoint.
  std::function<bool()> interrupted;
  double graceSeconds = 0;
  std::function<void(const std::string& text)> warn;
};

enum class RunOutcome : uint8_t {
  kComplete,     ///< all frames of the shot are written
  kRangeDone,    ///< those of the range are; others are missing
  kInterrupted,  ///< run it again to go on
  kBusy,         ///< another process has the frames, and the options say not to wait
};

struct RunReport {
  RunOutcome outcome = RunOutcome::kComplete;
  bool wasComplete = false;   ///< there was nothing to do
  uint64_t resumedSteps = 0;  ///< of the checkpoint that it went on from; 0: none
  uint64_t stepsRun = 0;      ///< simulated
  uint64_t framesWritten = 0;
  uint32_t subSteps = 0;                ///< of the exact solver; 0 where nothing was simulated
  std::optional<SubStepChoice> choice;  ///< with an error bound
  std::string device;
  double seconds = 0;                  ///< of simulating and writing
  double readingSeconds = 0;           ///< of these, reading positions from the device
  double waitingSeconds = 0;           ///< of these, waiting for the thread that writes
  double encodingSeconds = 0;          ///< that this thread has worked, at the same time
  uint64_t vertices = 0, strands = 0;  ///< written a frame
};

/// Errors: those of the inputs, the device and the disk; work of something else in the folder. What
/// is complete stays, and the next run goes on from there.
Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options);

/// A device by its index or UUID ("GPU-" before it is taken, too); empty takes the best one.
Result<std::unique_ptr<HeadlessDevice>> openDevice(Api api, const std::string& device);

}  // namespace pelage::bake
