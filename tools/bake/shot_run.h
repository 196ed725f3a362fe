// Runs shots: simulates the frames that are missing, and completes the files.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "error_bound.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "project.h"
#include "shot_scene.h"

namespace pelage::bake {

struct RunOptions {
  std::optional<FrameRange> range;  ///< of whole chunks; nothing: all frames
  std::string device;               ///< index or UUID, before that of the project
  bool wait = true;                 ///< for another process that has the same frames
  bool restart = false;             ///< removes what is there first
  uint32_t threads = 0;  ///< that encode, for all shots in flight; 0: as many as there are cores
  /// Frames that have run and frames to run, the pre-roll included; of runShots(), frames that need
  /// not run any more and those of all shots.
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

/// Shared by the runs of a process: the Vulkan device, the assets, and the hashes of files.
/// Threads: any.
class RunResources {
 public:
  /// \param jobs  shots in flight at most, 1 or more
  explicit RunResources(uint32_t jobs = 1) : jobs_(jobs) {}

  /// A device for one scene, as openDevice(); those of Vulkan share one, which the first call
  /// chooses.
  Result<std::unique_ptr<HeadlessDevice>> device(Api api, const std::string& wanted);
  /// fingerprintOf(), which reads each file once.
  Result<uint64_t> fingerprint(const Project& project, const Shot& shot);
  /// loadShot(), with the assets of an earlier shot where it has the same; those of the `jobs`
  /// latest ones stay loaded.
  Result<ShotInputs> inputs(const Shot& shot);
  /// HeadlessDevice::busySeconds() of the shared device.
  double busySeconds() const;

 private:
  struct Assets {
    uint64_t key = 0;
    std::mutex mutex;
    std::optional<ShotInputs> loaded;
  };

  const uint32_t jobs_;
  mutable std::mutex deviceMutex_;
  std::unique_ptr<HeadlessDevice> device_;
  std::mutex assetsMutex_;  // of what follows
  FileHashes hashes_;
  std::deque<std::shared_ptr<Assets>> assets_;  // latest last
};

/// Runs a shot. Errors: those of the inputs, the device and the disk; work of something else in the
/// folder. What is complete stays, and the next run goes on from there.
Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options,
                          RunResources& resources);
Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options);

/// The outcome of several shots.
struct RunsReport {
  std::vector<Result<RunReport>> shots;  ///< in the order in which they were given
  double busySeconds = 0;                ///< RunResources::busySeconds()
};
/// Runs shots in their order, `jobs` at a time (1 or more), each on a thread; the files are those
/// of runShot(). An error ends its shot alone. Shots that are to begin once `options.interrupted`
/// says so do not begin, and count as interrupted. The functions of `options` are called by one
/// thread at a time, but `interrupted` by all.
RunsReport runShots(const Project& project, std::span<const Shot> shots, const RunOptions& options,
                    uint32_t jobs);

/// A device by its index or UUID ("GPU-" before it is taken, too); empty takes the best one.
/// \param queues  HeadlessDef::queues
Result<std::unique_ptr<HeadlessDevice>> openDevice(Api api, const std::string& device,
                                                   uint32_t queues = 1);

}  // namespace pelage::bake
