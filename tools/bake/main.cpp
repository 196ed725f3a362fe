// pelage-bake: simulates the hair of shots into files, on one machine or many.
#include <CLI/CLI.hpp>
#include <exception>
#include <string_view>

#include "commands.h"
#include "program_messages.h"

namespace {

using pelage::bake::kProgram;

void printError(std::string_view text) { pelage::program::printError(kProgram, text); }

int runProgram(int argc, char** argv) {
  pelage::bake::Session session(kProgram);
  int exitCode = 0;
  CLI::App app{"Simulates the hair of shots into files, on one machine or many."};
  app.name(kProgram);
  app.set_version_flag("--version", PELAGE_BAKE_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_flag("--json", session.json, "Print the report as one JSON object");
  app.add_flag("-q,--quiet", session.quiet, "Print nothing but errors, and the report of --json");
  pelage::bake::addPlanCommand(app, session);
  pelage::bake::addRunCommand(app, session, exitCode);
  pelage::bake::addStatusCommand(app, session);
  pelage::bake::addVerifyCommand(app, session, exitCode);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // help, version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    printError(error.what());
    return pelage::bake::kBadArguments;
  }
  if (const auto done = session.command(); !done) {
    printError(done.error().message);
    return pelage::bake::kFailure;
  }
  session.print();
  return exitCode;
}

}  // namespace

int main(int argc, char** argv) {
  // The library throws nothing; the standard library may, when memory is short.
  try {
    return runProgram(argc, argv);
  } catch (const std::exception& error) {
    printError(error.what());
    return pelage::bake::kFailure;
  }
}
