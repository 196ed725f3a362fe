// The settings of a stage as one value that a user edits, and the last ones that worked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pelage/settings/scene_settings.h"
#include "stage/stage.h"

namespace viewer {

/// Returns the settings of a hair object, with those that all hair shares. \param hair index in
/// Stage::hairs().
pelage::SceneSettings settingsOf(const Stage& stage, size_t hair);

/// Applies settings to the stage. Simulation, material and object apply to one hair object; the
/// view, and the wind, shadow and share of strands of Stage::look, apply to all. If `creation` or
/// `follow` differ, the hair is made again in its bind shape; a simulatedShare below 1 switches
/// levelOfDetail on. \param hair index in Stage::hairs(). Errors: validate()'s, and those of making
/// the hair again; nothing is set then.
pelage::Result<void> apply(const pelage::SceneSettings& settings, size_t hair, Stage& stage);

class GoodSettings {
 public:
  /// Keeps the settings of all sides. Call it after a frame has run with them.
  void keep(Stage& stage);
  /// Restores the settings of all sides that show the same hair as then. \return whether one had
  /// others.
  bool restore(Stage& stage) const;

 private:
  struct Side {
    uint64_t shown = 0;                        // Stage::shown() at that time
    std::vector<pelage::SceneSettings> hairs;  // [hair]
  };
  std::array<Side, 2> sides_;
};

/// Gives all hair of all sides the default material and one default light. It helps if refused
/// settings came together with the hair: no good ones were kept then. \return whether a side had
/// others.
bool applyDefaultLook(Stage& stage);

/// The ways back from settings that were refused: the last good ones, another target, the memory of
/// the device for a larger window, the default look. Each is taken once: the first one would undo
/// what a later one has changed.
class WaysBack {
 public:
  WaysBack(const GoodSettings& good, Stage& stage) : good_(good), stage_(stage) {}
  /// Takes the next way that changes a setting. \return false: there is none.
  bool take();

 private:
  const GoodSettings& good_;
  Stage& stage_;
  int taken_ = 0;
};

}  // namespace viewer
