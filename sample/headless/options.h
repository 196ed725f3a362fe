// The command line of pelage-headless.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "asset_files.h"
#include "demo_scene.h"
#include "groom_presets.h"
#include "pelage/demo/character.h"
#include "pelage/hair_object.h"
#include "pelage/headless.h"
#include "pelage/settings/settings_file.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace sample {

/// The scene that is generated unless files are given.
enum class GeneratedScene : uint8_t { kCharacter, kHead };

/// How much is simulated and drawn where options do not say it.
enum class Quality : uint8_t {
  kFull,
  kFast,  ///< for software drivers: 6 pictures, no supersampling, half of the fur's guides
};

struct Options {
  pelage::Api api = pelage::Api::kVulkan;
  int device = -1;
  bool validation = false;
  pelage::Tier tier = pelage::Tier::kWide;  ///< as which the device counts at most
  bool listDevices = false;

  pelage::program::AssetFiles files;
  std::filesystem::path animation;  ///< of the bones of these files
  std::string clip;                 ///< empty takes the first one
  GeneratedScene scene = GeneratedScene::kCharacter;
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;  ///< of the character
  uint64_t seed = 1;
  GroomPreset preset = GroomPreset::kParted;  ///< of the generated groom
  /// Guides of the generated groom, or of the character's long hair; a default when not given.
  std::optional<uint32_t> guides;
  uint32_t repeat = 1;
  std::optional<uint32_t> follow;  ///< hairs a guide; a default for each asset when not given
  pelage::SkinningMethod skinning = pelage::SkinningMethod::kMatrices;
  HeadCollider headCollider = HeadCollider::kCapsules;
  /// Options that are given go before `settings`.
  std::optional<pelage::Solver> solver;
  std::optional<uint32_t> subSteps;
  std::optional<pelage::Float3> wind;
  std::optional<pelage::SettingsFile> settings;

  uint32_t frames = 240;
  uint32_t width = 640, height = 640;
  std::optional<Quality> quality;              ///< that of the device when not given
  std::optional<uint32_t> every, supersample;  ///< those of the quality when not given
  std::optional<uint32_t> samples;  ///< what the kind of transparency wants when not given
  pelage::Transparency transparency = pelage::Transparency::kWindowed;
  pelage::HairShadow shadow = pelage::HairShadow::kDeep;
  CameraPlace camera;
  std::optional<std::array<uint8_t, 3>> background;  ///< sRGB; a gradient when not given
  float detailPixels = pelage::kDetailPixels;        ///< 0: all strands are drawn
  bool images = true;
  bool drawSdf = false, drawContacts = false;
  std::filesystem::path out = "out";

  std::filesystem::path writeAsset, csv;
  std::string commit;
  bool quiet = false;
};

/// Whether the scene is made of files.
bool showsFiles(const Options& options);

/// Whether the scene is that of the character.
bool showsCharacter(const Options& options);

/// Samples a pixel of the target.
uint32_t samplesOf(const Options& options);

/// Gives quality, `every` and `supersample` their values where they are not given.
/// \param software the device is a software driver (DeviceInfo::software).
void chooseQuality(Options& options, bool software);

/// The options, or the exit code of a program that has said what there was to say: help, the
/// version, or one line on stderr about what is wrong.
std::variant<Options, int> parseOptions(int argc, const char* const* argv);

}  // namespace sample
