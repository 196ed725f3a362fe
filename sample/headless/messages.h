// What pelage-headless says: errors in one line, and its progress on a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

namespace sample {

inline constexpr const char* kProgram = "pelage-headless";
inline constexpr int kFailure = 1;
inline constexpr int kBadArguments = 2;
inline constexpr int kInterrupted = 130;  ///< as shells report SIGINT

/// Prints `pelage-headless: error: ...` to stderr; line ends in the text become spaces.
void printError(std::string_view text);
/// Prints `pelage-headless: warning: ...` likewise, with --quiet, too.
void printWarning(std::string_view text);

/// A bar with the time that is left, drawn on stdout while it is a terminal, and not at all
/// otherwise.
class Progress {
 public:
  Progress(uint32_t total, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(uint32_t done);

 private:
  using Clock = std::chrono::steady_clock;
  uint32_t total_;
  bool shown_;
  Clock::time_point start_, last_;
};

/// Makes Ctrl-C and SIGTERM set a flag, so that the program can finish what it is writing; a second
/// one ends it at once.
void watchInterrupts();
bool interrupted();

}  // namespace sample
