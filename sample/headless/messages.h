// Messages of pelage-headless: errors in one line, and its progress.
#pragma once

#include <chrono>
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

/// Shows on stdout what the program does, with the seconds since its start: one line that changes
/// on a terminal, else lines at least 5 s apart.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Says what begins. It is shown at once.
  void begin(std::string_view text);
  /// Says how far it is. It may be skipped.
  void update(std::string_view text);
  /// Removes the line of a terminal, for other output.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_;
  Clock::time_point start_, last_;
};

/// Makes Ctrl-C and SIGTERM set a flag, so that the program can finish what it is writing; a second
/// one ends it at once.
void watchInterrupts();
bool interrupted();

}  // namespace sample
