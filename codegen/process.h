// Child processes, so that a crash of a compiler is a message and not the end of the build.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace pelage::codegen {

struct ProcessResult {
  enum class End { kExited, kCrashed, kTimedOut, kNotStarted };
  End end = End::kNotStarted;
  int exitStatus = 0;  ///< kExited
  std::string reason;  ///< otherwise: "signal 11 (Segmentation fault)"
};

/// Runs a program and waits for it. What it prints goes to `logFile`.
ProcessResult runProcess(const std::vector<std::string>& arguments,
                         const std::filesystem::path& logFile, std::chrono::seconds timeout);

/// The running executable; empty when the system does not say.
std::filesystem::path currentExecutable();

}  // namespace pelage::codegen
