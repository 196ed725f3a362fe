// pelage-convert: from the files of modeling programs to hair, bones and collision meshes.
#include <CLI/CLI.hpp>
#include <exception>
#include <string_view>

#include "commands.h"
#include "program_messages.h"

namespace {

constexpr const char* kProgram = "pelage-convert";
constexpr int kFailure = 1, kBadArguments = 2;

void printError(std::string_view text) { pelage::program::printError(kProgram, text); }

int runProgram(int argc, char** argv) {
  pelage::convert::Session session(kProgram);
  CLI::App app{"Prepares hair, bone weights and collision meshes for pelage."};
  app.name(kProgram);
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
    printError(error.what());
    return kBadArguments;
  }
  if (const auto done = session.command(); !done) {
    printError(done.error().message);
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
    printError(error.what());
    return kFailure;
  }
}
