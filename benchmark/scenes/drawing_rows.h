// The rows of the scene benchmark that draw: what is drawn beside the picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scene_rows.h"

namespace bench {

/// Work of a frame beyond the simulation and a picture of the hair.
enum class DrawingExtra : uint8_t {
  kNone,
  kDepth,          ///< a view of depth alone
  kMotion,         ///< a view of depth and motion vectors
  kInterpolation,  ///< hair is drawn between two states of the simulation
  kStereo,         ///< the picture of the other eye
  kEngineLights,   ///< the lights of sample/engine_lights in place of pelage's
  kPlayback,       ///< guides from caches, decoded meanwhile, in place of a simulation
  kLevelOfDetail,  ///< as many strands, drawn and simulated, as the view needs
};

struct DrawingRow {
  DrawingExtra extra = DrawingExtra::kNone;
  bool tenfold = false;            ///< ten times the hair of the other rows
  float distance = 1;              ///< of the camera, times that of the other rows
  uint32_t guides = 0;             ///< of the character's long hair
  uint32_t width = 0, height = 0;  ///< of the picture [pixels]
  uint32_t shadowSize = 0;         ///< of the shadow map [texels]
  uint32_t characters = 1;         ///< beside and behind each other
  bool ratBoy = false;             ///< SceneAssets::ratBoy() in place of the character

  /// "draw/alone", "draw/depth", ..., "draw_10x/alone", "draw_10x/playback", "draw_far/alone",
  /// "draw_12/level_of_detail", "draw_rat_boy_far/alone"
  std::string name() const;
};

/// All rows; those with anything extra are compared with the one without before them.
std::vector<DrawingRow> drawingRows(SceneSize size);

}  // namespace bench
