#include "codegen/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

extern char** environ;

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The parent sends a stem with its final zero, the child answers with kDone. The child's end of the
// socket is its standard input.
constexpr int kSocket = STDIN_FILENO;
constexpr char kDone = '.';

bool sendAll(int socket, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket, data, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    data += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

// One character; false when the other end is closed.
bool receive(int socket, char& character) {
  while (true) {
    const ssize_t got = recv(socket, &character, 1, 0);
    if (got >= 0 || errno != EINTR) return got == 1;
  }
}

// Returns false when nothing came until the deadline. The end of the other side is something, too.
bool waitForInput(int socket, Clock::time_point deadline) {
  pollfd wanted{socket, POLLIN, 0};
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
    const int ready = poll(&wanted, 1, static_cast<int>(std::clamp<long long>(left, 0, INT_MAX)));
    if (ready > 0) return true;
    if (ready == 0 && Clock::now() >= deadline) return false;
    if (ready < 0 && errno != EINTR) return true;  // the read that follows says what is wrong
  }
}

fs::path withExtension(const fs::path& stem, const char* extension) {
  fs::path path = stem;
  path += extension;
  return path;
}

}  // namespace

Worker::~Worker() { finish(); }

bool Worker::start(std::string& reason) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    reason = "cannot make a socket: " + std::string(std::strerror(errno));
    return false;
  }
  std::string program = program_.string();
  char name[] = "worker";
  char* const argv[] = {program.data(), name, nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], kSocket);
  const int error = posix_spawn(&child_, argv[0], &actions, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error != 0) {
    close(ends[0]);
    child_ = -1;
    reason = "cannot start " + program + ": " + std::strerror(error);
    return false;
  }
  socket_ = ends[0];
  used_ = false;
  return true;
}

namespace {

ProcessResult waitForEnd(pid_t child) {
  ProcessResult result;
  int status = 0;
  pid_t ended = 0;
  do {
    ended = waitpid(child, &status, 0);
  } while (ended < 0 && errno == EINTR);
  if (ended < 0) {
    result.reason = "cannot wait for the child process: " + std::string(std::strerror(errno));
  } else if (WIFEXITED(status)) {
    const int exitStatus = WEXITSTATUS(status);
    result.end = exitStatus == 0 ? ProcessResult::End::kDone : ProcessResult::End::kFailed;
    if (exitStatus != 0) result.reason = "exit status " + std::to_string(exitStatus);
  } else {
    result.end = ProcessResult::End::kCrashed;
    const int signal = WTERMSIG(status);
    result.reason = "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  return result;
}

}  // namespace

ProcessResult Worker::collect() {
  close(socket_);
  socket_ = -1;
  return waitForEnd(std::exchange(child_, -1));
}

ProcessResult Worker::finish() {
  if (child_ < 0) return {ProcessResult::End::kDone, {}};
  return collect();
}

ProcessResult Worker::runOnce(const fs::path& stem, std::chrono::seconds timeout) {
  ProcessResult result;
  if (child_ < 0 && !start(result.reason)) return result;
  const auto deadline = Clock::now() + timeout;
  const std::string& text = stem.native();
  // If the child is gone already, the answer is missing, too.
  const bool sent = sendAll(socket_, text.c_str(), text.size() + 1);
  if (sent && !waitForInput(socket_, deadline)) {
    kill(child_, SIGKILL);
    collect();
    return {ProcessResult::End::kTimedOut,
            "no result after " + std::to_string(timeout.count()) + " s"};
  }
  char answer = 0;
  if (sent && receive(socket_, answer) && answer == kDone) {
    used_ = true;
    return {ProcessResult::End::kDone, {}};
  }
  result = collect();
  if (result.end == ProcessResult::End::kDone) {
    result = {ProcessResult::End::kFailed, "the child process ended without a result"};
  }
  return result;
}

ProcessResult Worker::run(const fs::path& stem, std::chrono::seconds timeout) {
  const bool shared = child_ >= 0 && used_;
  const ProcessResult result = runOnce(stem, timeout);
  const bool ended =
      result.end == ProcessResult::End::kFailed || result.end == ProcessResult::End::kCrashed;
  if (!shared || !ended) return result;
  std::error_code ignored;
  fs::remove(withExtension(stem, ".result"), ignored);
  return runOnce(stem, timeout);
}

int serveJobs(const std::function<int(const fs::path& stem)>& work) {
  std::string stem;
  for (char character = 0; receive(kSocket, character);) {
    if (character != '\0') {
      stem += character;
      continue;
    }
    std::fflush(stdout);
    const int log =
        open(withExtension(stem, ".log").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (log < 0 || dup2(log, STDOUT_FILENO) < 0 || dup2(log, STDERR_FILENO) < 0) return 1;
    close(log);
    if (const int status = work(stem); status != 0) return status;
    std::fflush(stdout);
    stem.clear();
    if (!sendAll(kSocket, &kDone, 1)) return 1;
  }
  return 0;
}

ProcessResult runProgram(std::vector<std::string> arguments, const fs::path& log) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr mode_t kMode = 0644;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, kMode);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = -1;
  const int error = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    return {ProcessResult::End::kNotStarted,
            "cannot start " + arguments[0] + ": " + std::strerror(error)};
  }
  return waitForEnd(child);
}

fs::path currentExecutable() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error);
}

}  // namespace pelage::codegen
