// Characters of one scene, as a game has them: side by side, each in its own pose.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "demo_scene.h"
#include "pelage/demo/character.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace bench {

/// Adds characters to DemoDef::scene, in rows of four behind each other. The hair of each collides
/// with its own body. \param count 1 or more. Errors: those of the scene.
pelage::Result<std::vector<sample::DemoScene>> makeCharacters(const pelage::Character& character,
                                                              sample::DemoDef def, uint32_t count);

/// Poses all characters for the next frame, and writes its simulation into a list, which is cleared
/// first. \param demos of makeCharacters(), or one other scene
pelage::Result<void> advanceAll(std::span<sample::DemoScene> demos, pelage::PassList& list);

}  // namespace bench
