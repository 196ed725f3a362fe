// The rows of the scene benchmark that draw: what is drawn beside the picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scene_rows.h"

namespace bench {

/// What a frame has beside the simulation and a picture of the hair.
enum class DrawingExtra : uint8_t {
  kNone,
  kDepth,          ///< a view of depth alone
  kMotion,         ///< a view of depth and motion vectors
  kInterpolation,  ///< hair is drawn between two states of the simulation
  kEngineLights,   ///< the lights of sample/engine_lights in place of pelage's
};

struct DrawingRow {
  DrawingExtra extra = DrawingExtra::kNone;
  uint32_t guides = 0;             ///< of the character's long hair
  uint32_t width = 0, height = 0;  ///< of the picture [pixels]
  uint32_t shadowSize = 0;         ///< of the shadow map [texels]

  /// "draw/alone", "draw/depth", ...
  std::string name() const;
};

/// All rows; the one without anything extra, which the others are compared with, is the first.
std::vector<DrawingRow> drawingRows(SceneSize size);

}  // namespace bench
