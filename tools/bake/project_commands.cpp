// plan, status, verify: what there is to run, how far it is, and whether it is what it was.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "atomic_file.h"
#include "commands.h"
#include "plan.h"

namespace pelage::bake {
namespace {

struct PlanArguments {
  std::string project, out, program;
  uint64_t rangeFrames = 0, shotCount = 1;
};

std::string ownPath() {
  std::error_code code;
  const auto path = std::filesystem::read_symlink("/proc/self/exe", code);
  return code ? kProgram : path.string();
}

Result<void> plan(const PlanArguments& arguments, Session& session) {
  const auto project = loadProject(arguments.project);
  if (!project) return project.error();
  uint64_t frames = 0;
  FileHashes hashes;
  for (const Shot& shot : project->shots) {
    frames += shot.frames.count();
    // Files that are not there are noticed now, and not on the farm.
    if (const auto fingerprint = fingerprintOf(*project, shot, hashes); !fingerprint)
      return Error{fingerprint.error().code,
                   fmt::format("shot '{}': {}", shot.name, fingerprint.error().message)};
  }
  const auto commands =
      planCommands(*project, arguments.program.empty() ? ownPath() : arguments.program,
                   arguments.rangeFrames, arguments.shotCount);
  std::string text;
  for (const std::string& command : commands) text += command + "\n";
  if (auto written = writeAtomic(std::filesystem::absolute(arguments.out), "plan", text); !written)
    return written;
  session.add("shots", project->shots.size(), "shots", fmt::format("{}", project->shots.size()));
  session.add("frames", frames, "frames", fmt::format("{}", frames));
  session.add("commands", commands.size(), "commands", fmt::format("{}", commands.size()));
  session.add("output", arguments.out, "written", arguments.out);
  return {};
}

Result<void> status(const std::string& path, bool check, Session& session) {
  const auto project = loadProject(path);
  if (!project) return project.error();
  nlohmann::json shots = nlohmann::json::array();
  uint64_t complete = 0;
  FileHashes hashes;
  for (const Shot& shot : project->shots) {
    const auto status = statusOf(*project, shot, hashes, check);
    if (!status) return status.error();
    complete += status->state == ShotState::kComplete ? 1 : 0;
    shots.push_back({{"name", shot.name},
                     {"state", toString(status->state)},
                     {"chunks", status->chunks},
                     {"chunks_written", status->chunksWritten},
                     {"checkpoint", status->checkpointSteps},
                     {"bytes", status->bytes},
                     {"steps_run", status->stepsRun},
                     {"seconds", status->seconds},
                     {"starts", status->starts},
                     {"errors", status->errors},
                     {"last_error", status->lastError},
                     {"fault", status->fault}});
    std::string trouble;
    if (!status->fault.empty())
      trouble = ", " + status->fault;
    else if (status->state != ShotState::kComplete && !status->lastError.empty())
      trouble = ", last error: " + status->lastError;
    session.add("", {}, shot.name,
                fmt::format("{:<8}  {}/{} chunks, {:.2f} MB{}", toString(status->state),
                            status->chunksWritten, status->chunks,
                            1e-6 * static_cast<double>(status->bytes), trouble));
  }
  session.add("shots", std::move(shots), "", "");
  session.add("complete", complete, "complete",
              fmt::format("{} of {} shots{}", complete, project->shots.size(),
                          check ? "" : ", by the sizes of files; --check reads them"));
  return {};
}

Result<void> verify(const std::string& path, bool decode, Session& session, int& exitCode) {
  const auto project = loadProject(path);
  if (!project) return project.error();
  nlohmann::json shots = nlohmann::json::array();
  uint64_t fine = 0, bytes = 0;
  for (size_t i = 0; i < project->shots.size(); ++i) {
    const Shot& shot = project->shots[i];
    const auto check = verifyShot(*project, shot, decode);
    const std::string fault = check ? check->fault : check.error().message;
    const bool isFine = check && check->complete && fault.empty();
    const std::string text = isFine           ? "fine"
                             : !fault.empty() ? fault
                                              : "all chunks are fine, but it is not complete; run "
                                                "the shot again";
    fine += isFine ? 1 : 0;
    bytes += check ? check->bytes : 0;
    shots.push_back({{"name", shot.name}, {"fine", isFine}, {"text", text}});
    session.add("", {}, shot.name, text);
    session.progress("verifying", i + 1, project->shots.size());
  }
  session.add("shots", std::move(shots), "", "");
  session.add("bytes", bytes, "bytes", fmt::format("{:.2f} MB", 1e-6 * static_cast<double>(bytes)));
  session.add("fine", fine, "fine", fmt::format("{} of {} shots", fine, project->shots.size()));
  if (fine != project->shots.size()) exitCode = program::kFailure;
  return {};
}

}  // namespace

void addPlanCommand(CLI::App& app, Session& session) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* command = app.add_subcommand(
      "plan", "Checks a project and writes a file with a command line for each shot");
  command->add_option("PROJECT", arguments->project, "Project, .json")->required();
  command->add_option("OUT", arguments->out, "File of command lines")->required();
  CLI::Option* ranges =
      command
          ->add_option("--range-frames", arguments->rangeFrames,
                       "A command for each range of at most so many frames of a shot, in whole "
                       "chunks")
          ->check(CLI::Range(1, 1'000'000).description(""));
  command
      ->add_option("--shots", arguments->shotCount,
                   "Shots of a command, which share a process; 1 if it is not given")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->excludes(ranges);
  command->add_option("--program", arguments->program,
                      "Path of pelage-bake on the machines that run the commands; that of this "
                      "program if it is not given");
  command->callback([arguments, &session] {
    session.command = [arguments, &session] { return plan(*arguments, session); };
  });
}

void addStatusCommand(CLI::App& app, Session& session) {
  auto project = std::make_shared<std::string>();
  auto check = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("status", "Says how far the shots of a project are");
  command->add_option("PROJECT", *project, "Project, .json")->required();
  command->add_flag("--check", *check, "Hash the files, too, in place of comparing their sizes");
  command->callback([project, check, &session] {
    session.command = [project, check, &session] { return status(*project, *check, session); };
  });
}

void addVerifyCommand(CLI::App& app, Session& session, int& exitCode) {
  auto project = std::make_shared<std::string>();
  auto decode = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "verify", "Hashes the files of all shots; exits with 1 if one is missing or has changed");
  command->add_option("PROJECT", *project, "Project, .json")->required();
  command->add_flag("--decode", *decode, "Decode all frames of the caches, too");
  command->callback([project, decode, &session, &exitCode] {
    session.command = [project, decode, &session, &exitCode] {
      return verify(*project, *decode, session, exitCode);
    };
  });
}

}  // namespace pelage::bake
