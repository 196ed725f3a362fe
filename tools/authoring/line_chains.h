// Polylines out of segments that share vertices.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace pelage::detail {

struct LineChains {
  std::vector<uint32_t> counts;    ///< [chain] vertices
  std::vector<uint32_t> vertices;  ///< of chain 0, then of chain 1, ...
};

/// Joins segments where exactly two of them meet; vertices where more meet end a chain. A chain
/// runs the way most of its segments do. Chains come in the order of their first segment. A ring
/// begins at the start of its first segment and ends there again.
/// \param vertexCount above all indices.
LineChains joinSegments(const std::vector<std::pair<uint32_t, uint32_t>>& segments,
                        uint32_t vertexCount);

}  // namespace pelage::detail
