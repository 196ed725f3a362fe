// pelage-convert: from the files of modeling programs to hair, bones and collision meshes.
#include <CLI/CLI.hpp>
#include <exception>

#include "commands.h"
#include "session.h"

namespace {

constexpr int kFailure = 1, kBadArguments = 2;

int runProgram(int argc, char** argv) {
  pelage::convert::Session session;
  CLI::App app{"Prepares hair, bone weights and collision meshes for pelage."};
  app.name("pelage-convert");
  app.set_version_flag("--version", PELAGE_CONVERT_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_flag("--json", session.json, "Print the report as one JSON object");
  app.add_flag("-q,--quiet", session.quiet, "Print nothing but errors, and the report of --json");
  pelage::convert::addBindCommand(app, session);
  pelage::convert::addCacheCommand(app, session);
  pelage::convert::addCollisionCommand(app, session);
  pelage::convert::addGroomCommand(app, session);
  pelage::convert::addInfoCommand(app, session);
  pelage::convert::addUsdCommand(app, session);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // help, version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    pelage::convert::printError(error.what());
    return kBadArguments;
  }
  if (const auto done = session.command(); !done) {
    pelage::convert::printError(done.error().message);
    return kFailure;
  }
  session.print();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // The library throws nothing; the standard library may, when memory is short.
  try {
    return runProgram(argc, argv);
  } catch (const std::exception& error) {
    pelage::convert::printError(error.what());
    return kFailure;
  }
}
