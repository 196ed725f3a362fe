// Messages of a program on stderr, one line each.
#pragma once

#include <string_view>

namespace pelage::program {

/// Prints "PROGRAM: error: TEXT"; line ends in the text become spaces. What was printed on stdout
/// comes before it.
void printError(std::string_view program, std::string_view text);
/// Prints "PROGRAM: warning: TEXT" in the same way.
void printWarning(std::string_view program, std::string_view text);

}  // namespace pelage::program
