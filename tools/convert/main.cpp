// pelage-convert: from the files of modeling programs to hair, bones and collision meshes.
#include "commands.h"

int main(int argc, char** argv) {
  using namespace pelage::convert;
  return pelage::program::runCommands(
      "pelage-convert", "Prepares hair, bone weights and collision meshes for pelage.",
      PELAGE_CONVERT_VERSION, argc, argv, [](CLI::App& app, Session& session, int& /*exitCode*/) {
        addBindCommand(app, session);
        addCacheCommand(app, session);
        addCollisionCommand(app, session);
        addGroomCommand(app, session);
        addInfoCommand(app, session);
        addUsdCommand(app, session);
      });
}
