#include "codegen/process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <thread>

extern char** environ;

namespace pelage::codegen {

ProcessResult runProcess(const std::vector<std::string>& arguments,
                         const std::filesystem::path& logFile, std::chrono::seconds timeout) {
  ProcessResult result;
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, logFile.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    result.reason = "cannot start " + arguments[0] + ": " + std::strerror(error);
    return result;
  }

  const auto deadline = std::chrono::steady_clock::now() + timeout;
  auto pause = std::chrono::milliseconds(1);
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) {
      result.reason = "cannot wait for the child process: " + std::string(std::strerror(errno));
      return result;
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      result.end = ProcessResult::End::kTimedOut;
      result.reason = "no result after " + std::to_string(timeout.count()) + " s";
      return result;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 2, std::chrono::milliseconds(16));
  }
  if (WIFEXITED(status)) {
    result.end = ProcessResult::End::kExited;
    result.exitStatus = WEXITSTATUS(status);
  } else {
    result.end = ProcessResult::End::kCrashed;
    const int signal = WTERMSIG(status);
    result.reason = "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  return result;
}

std::filesystem::path currentExecutable() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error);
}

}  // namespace pelage::codegen
