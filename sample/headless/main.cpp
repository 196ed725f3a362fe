// pelage-headless: hair on a character that moves, simulated and rendered without a window.
#include <exception>

#include "messages.h"
#include "options.h"
#include "run.h"

int main(int argc, char** argv) {
  // The library throws nothing; the standard library may, when memory is short.
  try {
    const auto parsed = sample::parseOptions(argc, argv);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    sample::watchInterrupts();
    const auto done = sample::run(std::get<sample::Options>(parsed));
    if (!done) {
      sample::printError(done.error().message);
      return sample::kFailure;
    }
    return sample::interrupted() ? sample::kInterrupted : 0;
  } catch (const std::exception& error) {
    sample::printError(error.what());
    return sample::kFailure;
  }
}
