// The command line of pelage-viewer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pelage/headless.h"
#include "stage/stage.h"

namespace viewer {

inline constexpr const char* kProgram = "pelage-viewer";

struct Options {
  std::optional<pelage::Api> api;  ///< nothing: Vulkan, or OpenGL where there is none
  int device = -1;
  bool validation = false;
  uint32_t width = 1280, height = 800;  ///< window coordinates
  bool fixedClock = false;
  bool vsync = true;
  bool printsStart = false;
  std::filesystem::path script, record;
  std::filesystem::path kernels;   ///< folder of their source, compiled at the start; empty: none
  std::filesystem::path frames;    ///< folder for the pictures of all frames; empty: none
  std::filesystem::path video;     ///< file for a video of all frames; empty: none
  std::filesystem::path times;     ///< CSV for the times of all passes; empty: none
  std::filesystem::path settings;  ///< JSON of pelage::SettingsFile; empty: none
  std::filesystem::path cache;     ///< folder; empty: none
  StageSource source;
  /// Nothing: what suits the device.
  std::optional<pelage::Transparency> transparency;
  std::optional<pelage::HairShadow> shadow;
  std::optional<float> strandShare;
  std::optional<pelage::Solver> compared;  ///< shown at the right; nothing: one side
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;
};

/// The options, or the exit status of a program that is to end: 0 behind --help, 2 for options
/// that are wrong, which stderr has in one line.
std::variant<Options, int> parseOptions(int argc, const char* const* argv);

}  // namespace viewer
