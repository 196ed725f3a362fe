// The command line of pelage-viewer, and the names of its choices.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "capture/captures.h"
#include "demo_scene.h"
#include "groom_presets.h"
#include "pelage/demo/character.h"
#include "pelage/simulation_settings.h"
#include "pelage/transparency.h"
#include "pelage/view.h"
#include "screen.h"
#include "stage/stage.h"

namespace viewer {

/// A value with the name that a user chooses it by.
template <class T>
struct Choice {
  const char* name;
  T value;
};

inline constexpr Choice<sample::GroomPreset> kGrooms[] = {
    {"parted", sample::GroomPreset::kParted},
    {"straight", sample::GroomPreset::kStraight},
    {"curly", sample::GroomPreset::kCurly},
    {"fur", sample::GroomPreset::kFur},
    {"mohawk", sample::GroomPreset::kMohawk}};
inline constexpr Choice<pelage::CharacterMotion> kMotions[] = {
    {"all", pelage::CharacterMotion::kAll},         {"walk", pelage::CharacterMotion::kWalk},
    {"shake", pelage::CharacterMotion::kHeadShake}, {"jump", pelage::CharacterMotion::kJump},
    {"idle", pelage::CharacterMotion::kIdle},       {"bind", pelage::CharacterMotion::kBind}};
inline constexpr Choice<pelage::Solver> kSolvers[] = {{"exact", pelage::Solver::kExact},
                                                      {"classic", pelage::Solver::kClassic}};
inline constexpr Choice<pelage::Transparency> kTransparencies[] = {
    {"windowed", pelage::Transparency::kWindowed},
    {"tiles", pelage::Transparency::kTiles},
    {"hybrid4", pelage::Transparency::kHybrid4},
    {"hybrid8", pelage::Transparency::kHybrid8},
    {"hybrid16", pelage::Transparency::kHybrid16},
    {"shortcut", pelage::Transparency::kShortCut},
    {"stochastic", pelage::Transparency::kStochastic},
    {"alpha-test", pelage::Transparency::kAlphaTest}};
inline constexpr Choice<pelage::HairShadow> kShadows[] = {{"deep", pelage::HairShadow::kDeep},
                                                          {"depth", pelage::HairShadow::kDepth},
                                                          {"none", pelage::HairShadow::kNone}};
inline constexpr Choice<sample::HeadCollider> kHeadColliders[] = {
    {"capsules", sample::HeadCollider::kCapsules}, {"mesh", sample::HeadCollider::kMesh}};

/// Joins the names: "a, b or c".
template <class T, size_t N>
std::string namesOf(const Choice<T> (&choices)[N]) {
  std::string names;
  for (size_t i = 0; i < N; ++i)
    names += std::string(i == 0 ? "" : i + 1 == N ? " or " : ", ") + choices[i].name;
  return names;
}

inline constexpr const char* kProgram = "pelage-viewer";

struct Options {
  ScreenDef screen;
  CaptureFiles captures;
  bool fixedClock = false;
  bool printsStart = false;
  std::filesystem::path script, record;
  std::filesystem::path kernels;   ///< folder of HLSL to compile at the start; empty: none
  std::filesystem::path settings;  ///< JSON of pelage::SettingsFile; empty: none
  StageSource source;
  /// The device decides where these have no value.
  std::optional<pelage::Transparency> transparency;
  std::optional<pelage::HairShadow> shadow;
  std::optional<float> strandShare;
  float detailPixels = pelage::kDetailPixels;
  std::optional<uint32_t> coarseness;
  std::optional<pelage::Solver> compared;  ///< solver of the right side; nothing: one side
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;
};

/// Parses the command line. \return the options, or the exit status of a program that ends: 0 after
/// --help, 2 for wrong options, which one line on stderr names.
std::variant<Options, int> parseOptions(int argc, const char* const* argv);

}  // namespace viewer
