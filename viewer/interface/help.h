// The window of help for keys and mouse.
#pragma once

#include <span>

namespace viewer {

/// A line of the help; docs/viewer.md has the same lines.
struct HelpLine {
  const char* keys;
  const char* action;
};

std::span<const HelpLine> helpLines();
/// Builds the window. \return false if the user has closed it.
bool buildHelp();

}  // namespace viewer
