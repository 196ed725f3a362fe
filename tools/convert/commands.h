// The commands of pelage-convert, a file each. Each function adds a subcommand with its options to
// the command line; when it is chosen, it sets Session::command.
#pragma once

#include "session.h"

namespace CLI {
class App;
}

namespace pelage::convert {

using program::Session;

void addBindCommand(CLI::App& app, Session& session);
void addCacheCommand(CLI::App& app, Session& session);
void addCollisionCommand(CLI::App& app, Session& session);
void addGroomCommand(CLI::App& app, Session& session);
void addInfoCommand(CLI::App& app, Session& session);
void addUsdCommand(CLI::App& app, Session& session);

}  // namespace pelage::convert
