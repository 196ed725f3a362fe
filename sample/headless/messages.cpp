#include "messages.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

#include "program_messages.h"

namespace sample {
namespace {

constexpr std::chrono::milliseconds kRedraw{100}, kNextLine{5000};

volatile std::sig_atomic_t g_interrupted = 0;

void onSignal(int signal) {
  g_interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void printError(std::string_view text) { pelage::program::printError(kProgram, text); }
void printWarning(std::string_view text) { pelage::program::printWarning(kProgram, text); }

Progress::Progress(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDOUT_FILENO) != 0), start_(Clock::now()) {}

void Progress::begin(std::string_view text) {
  if (quiet_) return;
  last_ = Clock::now();
  const double seconds = std::chrono::duration<double>(last_ - start_).count();
  if (terminal_)
    fmt::print("\r{}, {:.0f} s\x1b[K", text, seconds);
  else
    fmt::print("{:4.0f} s  {}\n", seconds, text);
  std::fflush(stdout);
}

void Progress::update(std::string_view text) {
  if (Clock::now() - last_ >= (terminal_ ? kRedraw : kNextLine)) begin(text);
}

void Progress::clear() {
  if (terminal_ && !quiet_) fmt::print("\r\x1b[K");
  std::fflush(stdout);
}

void watchInterrupts() {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

bool interrupted() { return g_interrupted != 0; }

}  // namespace sample
