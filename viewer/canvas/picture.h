// The last step of a frame: the scene over a backdrop, encoded for the screen.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace viewer {

/// Returns a list with the draw, for a view of its own. \param scene the scene's color, registered
/// with the runtime: a 2D array of one layer.
pelage::Result<pelage::PassList> pictureList(pelage::TextureId scene, uint32_t width,
                                             uint32_t height, bool flipsRows);

}  // namespace viewer
