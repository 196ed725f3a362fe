// The settings that the last frame was made with, for when a device or the library refuses others.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pelage/settings/scene_settings.h"
#include "stage/stage.h"

namespace viewer {

class GoodSettings {
 public:
  /// Keeps the settings of a stage whose frame has run.
  void keep(Stage& stage);
  /// Gives them back to all sides. \return whether one had others; not where none were kept of what
  /// it shows.
  bool restore(Stage& stage) const;

 private:
  struct Side {
    uint64_t shown = 0;                        // Stage::shown() that they belong to
    std::vector<pelage::SceneSettings> hairs;  // [hair]
  };
  std::array<Side, 2> sides_;
};

/// Gives all hair of all sides the default material and one default light: where refused
/// settings came together with the hair, so that there are none to go back to. \return whether it
/// had others.
bool applyDefaultLook(Stage& stage);

}  // namespace viewer
