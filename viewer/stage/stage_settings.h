// The settings of what is on a stage, as one value that a user edits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pelage/settings/scene_settings.h"
#include "stage/stage.h"

namespace viewer {

/// Sections of SceneSettings that a stage takes: bit i is that of the i-th of
/// pelage::settingsSections(). The others are the window's own.
uint32_t stageSections();

/// Settings of a hair object, and of what all are drawn with. \param hair index in Stage::hairs().
pelage::SceneSettings settingsOf(const Stage& stage, size_t hair);

/// Gives them to the stage. The simulation, the material and the object are those of this hair;
/// wind, shadow and share of the strands, which Stage::look has, and the view count for all hair.
/// Hair begins in its bind shape again where `creation` or `follow` differ; a simulatedShare below
/// 1 switches levelOfDetail on. Errors: validate()'s, and those of making the hair again; nothing
/// is set then.
pelage::Result<void> apply(const pelage::SceneSettings& settings, size_t hair, Stage& stage);

}  // namespace viewer
