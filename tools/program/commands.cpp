#include <CLI/CLI.hpp>
#include <exception>
#include <string>
#include <vector>

#include "program_messages.h"
#include "session.h"

namespace pelage::program {
namespace {

// Says which commands there are, and names the word that is none of them.
std::string missingCommand(const CLI::App& app) {
  const std::vector<std::string> words = app.remaining();
  std::string text =
      words.empty() ? "a command is missing" : "'" + words.front() + "' is no command";
  const std::vector<const CLI::App*> commands = app.get_subcommands({});
  for (size_t i = 0; i < commands.size(); ++i)
    text += (i == 0                     ? "; there are "
             : i + 1 == commands.size() ? " and "
                                        : ", ") +
            commands[i]->get_name();
  return text + "; see --help";
}

int run(CLI::App& app, Session& session, int argc, char** argv, const int& exitCode) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // help, version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    printError(app.get_name(), app.get_subcommands().empty() ? missingCommand(app) : error.what());
    return kBadArguments;
  }
  if (const auto done = session.command(); !done) {
    printError(app.get_name(), done.error().message);
    return kFailure;
  }
  session.print();
  for (const std::string& error : session.errors()) printError(app.get_name(), error);
  return session.errors().empty() ? exitCode : kFailure;
}

}  // namespace

int runCommands(const char* program, const char* description, const char* version, int argc,
                char** argv,
                const std::function<void(CLI::App&, Session&, int& exitCode)>& addCommands) {
  // The library throws nothing; the standard library may, when memory is short.
  try {
    Session session(program);
    int exitCode = 0;
    CLI::App app{description};
    app.name(program);
    app.set_version_flag("--version", version);
    app.require_subcommand(1);
    app.fallthrough();
    app.add_flag("--json", session.json, "Print the report as one JSON object");
    app.add_flag("-q,--quiet", session.quiet, "Print nothing but errors, and the report of --json");
    addCommands(app, session, exitCode);
    return run(app, session, argc, argv, exitCode);
  } catch (const std::exception& error) {
    printError(program, error.what());
    return kFailure;
  }
}

}  // namespace pelage::program
