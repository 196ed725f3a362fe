// run: simulates shots, or goes on with them.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "json_members.h"
#include "plan.h"
#include "shot_run.h"

namespace pelage::bake {
namespace {

struct RunArguments {
  std::string project, frames, device, errorBound;
  std::vector<std::string> shots;
  uint32_t threads = 0, jobs = 4;
  double errorShare = 0, grace = 10;
  bool noWait = false, restart = false;
};

std::atomic<bool> g_interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "signal handlers write it");

// Schedulers send SIGTERM some time before SIGKILL. Who presses Ctrl-C once more has no time.
void watchSignals() {
  std::signal(SIGTERM, [](int) { g_interrupted = true; });
  std::signal(SIGINT, [](int) {
    if (g_interrupted.exchange(true)) ::_exit(kRunAgain);
  });
  // A file that grows over a limit is an error of the write.
  std::signal(SIGXFSZ, SIG_IGN);
}

const char* toString(RunOutcome outcome) {
  switch (outcome) {
    case RunOutcome::kComplete:
      return "complete";
    case RunOutcome::kRangeDone:
      return "range done";
    case RunOutcome::kInterrupted:
      return "interrupted";
    case RunOutcome::kBusy:
      return "busy";
  }
  return "unknown";
}

void report(const RunReport& run, const Shot& shot, Session& session) {
  session.add("shot", shot.name, "shot", shot.name);
  session.add("outcome", toString(run.outcome), "outcome",
              run.wasComplete ? "complete already" : toString(run.outcome));
  session.add("was_complete", run.wasComplete, "", "");
  session.add("frames_written", run.framesWritten, "frames written",
              fmt::format("{}", run.framesWritten));
  session.add("steps_run", run.stepsRun, "frames simulated", fmt::format("{}", run.stepsRun));
  session.add("resumed_from", run.resumedSteps, run.resumedSteps > 0 ? "went on from" : "",
              fmt::format("a checkpoint behind {} frames", run.resumedSteps));
  if (!run.device.empty()) session.add("device", run.device, "device", run.device);
  if (run.subSteps > 0)
    session.add("sub_steps", run.subSteps, "sub-steps", fmt::format("{}", run.subSteps));
  if (run.choice) {
    const SubStepError& chosen = run.choice->tried.back();
    const SubStepError& first = run.choice->tried.front();
    session.add(
        "error_bound", toJson(*run.choice), "error",
        fmt::format("{:.3g} mm for {}, {:.3g} mm in the mean, {:.3g} mm at most; {:.3g} mm "
                    "is asked for",
                    1e3 * chosen.error, textOfShare(run.choice->bound.share), 1e3 * chosen.mean,
                    1e3 * chosen.largest, 1e3 * run.choice->bound.length));
    session.add("", {}, "cost",
                fmt::format("{:.3g} ms a frame, {:.3g} times that of {} sub-step",
                            1e3 * chosen.secondsPerFrame,
                            chosen.secondsPerFrame / first.secondsPerFrame, first.subSteps));
  }
  if (run.stepsRun == 0) return;
  const double rate = static_cast<double>(run.stepsRun) / run.seconds;
  session.add("strands", run.strands, "strands",
              fmt::format("{} with {} vertices", run.strands, run.vertices));
  session.add("seconds", run.seconds, "time",
              fmt::format("{:.2f} s, {:.4g} frames/s, {:.4g} strands x frames/s", run.seconds, rate,
                          rate * static_cast<double>(run.strands)));
  const double frames = static_cast<double>(run.stepsRun);
  session.add("encoding_seconds", run.encodingSeconds, "encoding",
              fmt::format("{:.3g} ms a frame, for which the simulation waited {:.3g} ms",
                          1e3 * run.encodingSeconds / frames, 1e3 * run.waitingSeconds / frames));
  session.add("waiting_seconds", run.waitingSeconds, "", "");
  session.add("reading_seconds", run.readingSeconds, "", "");
}

// The shots that the command line names, with its settings; all of the project if it names none.
Result<std::vector<Shot>> shotsOf(const RunArguments& arguments, const Project& project) {
  std::vector<Shot> shots;
  for (const std::string& name : arguments.shots) {
    const Shot* found = project.find(name);
    if (found == nullptr)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: has no shot '{}'", arguments.project, name)};
    if (std::count(arguments.shots.begin(), arguments.shots.end(), name) > 1)
      return Error{ErrorCode::kInvalidArgument, fmt::format("--shot: '{}' is given twice", name)};
    shots.push_back(*found);
  }
  if (shots.empty()) shots = project.shots;
  for (Shot& shot : shots) {
    if (!arguments.errorBound.empty()) {
      const auto bound = parseMeters(arguments.errorBound);
      if (!bound || !(*bound >= 1e-7 && *bound <= 1))
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("--error-bound: '{}' is no length from 1e-7 to 1 m: 0.5mm",
                                 arguments.errorBound)};
      shot.errorBound = bound;
      shot.subSteps.reset();
    }
    if (arguments.errorShare > 0) shot.errorShare = arguments.errorShare;
  }
  return shots;
}

Result<void> run(const RunArguments& arguments, Session& session, int& exitCode) {
  const auto start = std::chrono::steady_clock::now();
  auto project = loadProject(arguments.project);
  if (!project) return project.error();
  const auto shots = shotsOf(arguments, *project);
  if (!shots) return shots.error();
  RunOptions options;
  if (!arguments.frames.empty()) {
    options.range = parseFrames(arguments.frames);
    if (!options.range)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("--frames: '{}' is no range: 1-48", arguments.frames)};
  }
  options.device = arguments.device;
  options.wait = !arguments.noWait;
  options.restart = arguments.restart;
  options.threads = arguments.threads;
  options.graceSeconds = arguments.grace;
  options.progress = [&](uint64_t done, uint64_t total) {
    session.progress(fmt::format("{}/{} frames", done, total), done, total);
  };
  options.warn = [&](const std::string& text) { session.warn(text); };
  options.interrupted = [] { return g_interrupted.load(); };
  watchSignals();
  const RunsReport runs = runShots(*project, *shots, options, arguments.jobs);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const bool several = shots->size() > 1;
  uint64_t frames = 0;
  std::vector<std::string> failed;
  for (size_t i = 0; i < shots->size(); ++i) {
    const auto& one = runs.shots[i];
    const std::string& name = (*shots)[i].name;
    if (!one && !several) return one.error();
    session.beginFile();
    if (one) {
      report(*one, (*shots)[i], session);
      frames += one->stepsRun;
      if (one->outcome == RunOutcome::kInterrupted || one->outcome == RunOutcome::kBusy)
        exitCode = kRunAgain;
    } else {
      session.add("shot", name, "shot", name);
      session.add("outcome", "failed", "outcome", "failed");
      session.fail(fmt::format("{}: {}", name, one.error().message));
      failed.push_back(name);
    }
  }
  if (several) {
    session.endFiles("shots");
    session.add("failed", failed, failed.empty() ? "" : "failed",
                fmt::format("{}", fmt::join(failed, ", ")));
    session.add("frames_simulated", frames, "frames simulated", fmt::format("{}", frames));
  }
  session.add("wall_seconds", seconds, "", "");
  session.add("busy_seconds", runs.busySeconds, runs.busySeconds > 0 ? "GPU" : "",
              fmt::format("busy {:.2f} s of {:.2f} s, {:.0f} %", runs.busySeconds, seconds,
                          100 * runs.busySeconds / seconds));
  return {};
}

}  // namespace

void addRunCommand(CLI::App& app, Session& session, int& exitCode) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand(
      "run", "Simulates the frames of shots that are not there yet, and writes their files");
  command->add_option("PROJECT", arguments->project, "Project, .json")->required();
  command
      ->add_option(
          "--shot", arguments->shots,
          "Name of a shot, or several: --shot a,b or --shot a --shot b; all of the project "
          "if it is not given")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--jobs", arguments->jobs,
                   "Shots in flight at once, which share the GPU; 4 if it is not given")
      ->check(CLI::Range(1, 64).description(""));
  command->add_option("--frames", arguments->frames,
                      "Frames A-B alone, whole chunks; those before are simulated, too, or come "
                      "from a checkpoint");
  command
      ->add_option("--device", arguments->device,
                   "Index of the device, or its UUID; before that of the project")
      ->envname("PELAGE_BAKE_DEVICE");
  command->add_option("--error-bound", arguments->errorBound,
                      "Length such as 0.5mm: chooses the sub-steps, in place of those of the "
                      "project");
  command
      ->add_option("--error-share", arguments->errorShare,
                   "Share of the vertices that are to be within --error-bound, 0.01..1; that of "
                   "the project, or 0.99")
      ->check(CLI::Range(0.01, 1.0).description(""));
  command
      ->add_option("--threads", arguments->threads,
                   "Threads that encode frames while the next ones are simulated, for all shots in "
                   "flight; as many as the machine has cores if it is not given")
      ->check(CLI::Range(1, 1024).description(""));
  command
      ->add_option(
          "--grace", arguments->grace,
          "Seconds that it may go on to the end of a chunk when it is interrupted (SIGINT, "
          "SIGTERM), so that the next run repeats nothing; 10 if it is not given")
      ->check(CLI::Range(0.0, 3600.0).description(""));
  command->add_flag("--no-wait", arguments->noWait,
                    "Exit with 75 if another process has these frames, in place of waiting for it");
  command->add_flag("--restart", arguments->restart, "Remove what the shot has, and begin anew");
  command->callback([arguments, &session, &exitCode] {
    session.command = [arguments, &session, &exitCode] {
      return run(*arguments, session, exitCode);
    };
  });
}

}  // namespace pelage::bake
