#include <CLI/CLI.hpp>
#include <exception>

#include "program_messages.h"
#include "session.h"

namespace pelage::program {
namespace {

int run(CLI::App& app, Session& session, int argc, char** argv, const int& exitCode) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // help, version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    printError(app.get_name(), error.what());
    return kBadArguments;
  }
  if (const auto done = session.command(); !done) {
    printError(app.get_name(), done.error().message);
    return kFailure;
  }
  session.print();
  return exitCode;
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
