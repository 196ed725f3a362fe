#include "program_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace pelage::program {
namespace {

void print(std::string_view program, const char* kind, std::string_view text) {
  std::string line(text);
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fflush(stdout);
  fmt::print(stderr, "{}: {}: {}\n", program, kind, line);
}

}  // namespace

void printError(std::string_view program, std::string_view text) { print(program, "error", text); }

void printWarning(std::string_view program, std::string_view text) {
  print(program, "warning", text);
}

}  // namespace pelage::program
