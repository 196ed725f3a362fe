// Depth maps of opaque triangles, which an engine would draw on the GPU.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"

namespace engine_lights {

/// Opaque triangles in world space [m].
struct OpaqueGeometry {
  std::vector<pelage::Float3> positions;
  std::vector<uint32_t> indices;  ///< three a triangle
};

/// Draws the nearest depths of triangles into a square map, [row][column]; 1 where there is none.
/// Row 0 is the upper one, where clip y is 1. Triangles that reach behind the eye are left out.
/// \param size texels an edge, > 0.
std::vector<float> drawDepthMap(const OpaqueGeometry& geometry, const pelage::Matrix4& worldToClip,
                                uint32_t size);

}  // namespace engine_lights
