#include "messages.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

#include "program_messages.h"

namespace sample {
namespace {

constexpr int kBarWidth = 32;
constexpr std::chrono::milliseconds kRedraw{100};

volatile std::sig_atomic_t g_interrupted = 0;

void onSignal(int signal) {
  g_interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void printError(std::string_view text) { pelage::program::printError(kProgram, text); }
void printWarning(std::string_view text) { pelage::program::printWarning(kProgram, text); }

Progress::Progress(uint32_t total, bool quiet)
    : total_(total), shown_(!quiet && isatty(STDOUT_FILENO) != 0), start_(Clock::now()) {}

Progress::~Progress() {
  if (shown_) fmt::print("\r\x1b[K");
  std::fflush(stdout);
}

void Progress::update(uint32_t done) {
  if (!shown_) return;
  const Clock::time_point now = Clock::now();
  if (now - last_ < kRedraw && done < total_) return;
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double left = done > 0 ? seconds / done * (total_ - done) : 0;
  const int filled = static_cast<int>(uint64_t{done} * kBarWidth / std::max(total_, 1u));
  fmt::print("\r[{:#<{}}{:.<{}}] {}/{} frames, {:.0f} s left\x1b[K", "", filled, "",
             kBarWidth - filled, done, total_, left);
  std::fflush(stdout);
}

void watchInterrupts() {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

bool interrupted() { return g_interrupted != 0; }

}  // namespace sample
