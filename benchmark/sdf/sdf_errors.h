// Errors of a distance field against the oracle.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"
#include "reference/sdf/distance_oracle.h"

namespace bench {

/// State of a node after a build.
enum class NodeState : uint8_t {
  kUnwritten,  ///< nothing
  kUnfilled,   ///< which side it is on
  kNear,       ///< its distance, in the band
  kFar,        ///< its distance, beyond the band
};

struct NodeValue {
  NodeState state = NodeState::kUnwritten;
  float distance = 0;  ///< [cell], negative inside
};

/// The nodes that are compared, x fastest.
struct NodeGrid {
  pelage::Float3 origin = {};
  float cellSize = 0;
  uint32_t nodes[3] = {};
  uint64_t count() const { return uint64_t{nodes[0]} * nodes[1] * nodes[2]; }
};

/// True distances at the nodes [cell]: exact near the surface and inside, at least `reach` outside.
std::vector<float> trueDistances(const pelage::reference::DistanceOracle& oracle,
                                 const NodeGrid& grid, double range);

struct SdfErrors {
  uint64_t wrongSigns = 0;  ///< of nodes with a sign, further than 1e-4 cell from the surface
  double nearMax = 0, nearRms = 0;  ///< of distances in the band, whatever the sign [cell]
  double farMax = 0, farRms = 0;    ///< of distances beyond the band [cell]
  double unsetInterior = 0;         ///< share of the inside nodes without a distance, 0..1
};
SdfErrors compareSdf(std::span<const NodeValue> values, std::span<const float> truth);

}  // namespace bench
