// Child processes, so that a crash of a compiler becomes a message and does not end the build. A
// child takes one job after the other: starting one and reading the built-in functions of the
// shading languages would cost more than most jobs.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pelage::codegen {

struct ProcessResult {
  enum class End { kDone, kFailed, kCrashed, kTimedOut, kNotStarted };
  End end = End::kNotStarted;
  std::string reason;  ///< why it is not kDone: "signal 11 (Segmentation fault)"
};

/// A child process that works on jobs, at most one at a time. It starts with the first job, and
/// again with the next one after it has ended.
class Worker {
 public:
  /// \param program called as "program worker"; there it calls serveJobs()
  explicit Worker(std::filesystem::path program) : program_(std::move(program)) {}
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Has the child work on the files `stem`.job, .result and .log, and waits for it. Output of the
  /// child goes to the .log file. A child that failed, crashed or took longer than `timeout` is
  /// gone, and no other job is to blame: a job that crashes a child that has worked before is run
  /// again in a new one.
  ProcessResult run(const std::filesystem::path& stem, std::chrono::seconds timeout);

  /// Lets the child end. Returns kDone if it ended well or there is none.
  ProcessResult finish();

 private:
  ProcessResult runOnce(const std::filesystem::path& stem, std::chrono::seconds timeout);
  bool start(std::string& reason);
  /// Waits for the end of the child, and forgets it.
  ProcessResult collect();

  std::filesystem::path program_;
  pid_t child_ = -1;
  int socket_ = -1;
  bool used_ = false;  ///< the child has finished a job
};

/// The child: calls `work` with each stem until the parent wants no more. Returns the exit status:
/// that of the first `work` that was not 0.
int serveJobs(const std::function<int(const std::filesystem::path& stem)>& work);

/// Runs a program, which is looked for in PATH, and waits for its end. Its output goes to the log.
/// \param arguments the program first
ProcessResult runProgram(std::vector<std::string> arguments, const std::filesystem::path& log);

/// Returns the path of the running executable; empty if the system does not provide it.
std::filesystem::path currentExecutable();

}  // namespace pelage::codegen
