// The commands of pelage-bake, a function each, which adds a subcommand with its options to the
// command line; when it is chosen, it sets Session::command.
#pragma once

#include <cstdint>

#include "session.h"

namespace CLI {
class App;
}

namespace pelage::bake {

using program::Session;

inline constexpr const char* kProgram = "pelage-bake";
/// Exit code: EX_TEMPFAIL of sysexits.h.
inline constexpr int kRunAgain = 75;

void addPlanCommand(CLI::App& app, Session& session);
/// \param exitCode  receives the exit code of a run that has no error
void addRunCommand(CLI::App& app, Session& session, int& exitCode);
void addStatusCommand(CLI::App& app, Session& session);
void addVerifyCommand(CLI::App& app, Session& session, int& exitCode);

}  // namespace pelage::bake
