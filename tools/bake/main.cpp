// pelage-bake: simulates the hair of shots into files, on one machine or many.
#include "commands.h"

int main(int argc, char** argv) {
  using namespace pelage::bake;
  return pelage::program::runCommands(
      kProgram, "Simulates the hair of shots into files, on one machine or many.",
      PELAGE_BAKE_VERSION, argc, argv, [](CLI::App& app, Session& session, int& exitCode) {
        addPlanCommand(app, session);
        addRunCommand(app, session, exitCode);
        addStatusCommand(app, session);
        addVerifyCommand(app, session, exitCode);
      });
}
