// pelage-viewer: shows moving hair in a window.
#include <exception>

#include "options.h"
#include "program_messages.h"
#include "viewer.h"

int main(int argc, char** argv) {
  constexpr int kFailure = 1;
  const auto fail = [](std::string_view text) {
    pelage::program::printError(viewer::kProgram, text);
    return kFailure;
  };
  // The library throws nothing; the standard library may, when memory is short.
  try {
    auto options = viewer::parseOptions(argc, argv);
    if (const int* code = std::get_if<int>(&options)) return *code;
    viewer::Viewer program(std::get<viewer::Options>(std::move(options)));
    if (const auto opened = program.open(); !opened) return fail(opened.error().message);
    if (const auto done = program.run(); !done) return fail(done.error().message);
    return 0;
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
