// The grid of an SDF: the positions of its nodes, and its memory.
#pragma once

#include <cstdint>

#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::detail {

struct SdfGridDef {
  Float3 lowest, highest;      ///< box of the mesh [m]; lowest > highest on an axis: no mesh
  float cellSize = 0;          ///< [m], > 0
  float band = 2;              ///< [cell] distance that is exact on both sides, 1..16
  uint32_t triangleCount = 0;  ///< below 2^20
  bool threeAxes = false;      ///< the mesh is open or overlaps
  uint64_t memoryCap = uint64_t{1} << 32;  ///< most bytes of the field, see SdfGridPlan::bytes
};

struct SdfGridPlan {
  Float3 origin;              ///< of node 0 [m], a multiple of the cell but for rounding to float
  float cellSize = 0;         ///< [m]
  uint32_t nodes[3] = {};     ///< x a multiple of 4
  float band = 0;             ///< [cell]
  float farRange = 0;         ///< [cell] Sdf::farRange
  uint32_t triangleBits = 0;  ///< of a key
  bool threeAxes = false;
  uint64_t bytes = 0;  ///< keys and crossings

  uint64_t nodeCount() const { return uint64_t{nodes[0]} * nodes[1] * nodes[2]; }
};

/// Plans a grid that covers the mesh and band + 1 cells on both sides of each axis. Errors: a box,
/// cell size, band or number of triangles out of range; a grid over the memory cap, 2^30 nodes or
/// 60,000 nodes on an axis, with the cell size that would fit.
Result<SdfGridPlan> planSdfGrid(const SdfGridDef& def);

}  // namespace pelage::detail
