// The holes that cutting a piece out of a closed surface leaves.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pelage::detail {

/// Edges of a whole mesh, by how often its triangles run along them one way more than the other.
class EdgeBalance {
 public:
  explicit EdgeBalance(std::span<const uint32_t> indices);
  /// Whether the triangles at the edge close it.
  bool isClosed(uint32_t from, uint32_t to) const;
  /// Whether they do at every edge.
  bool isClosed() const { return open_.empty(); }
  /// The same edges are open.
  bool operator==(const EdgeBalance&) const = default;

 private:
  std::vector<std::array<uint32_t, 2>> open_;  ///< ascending vertices, sorted
};

/// Rims of the holes that a piece has where the whole has none: vertices in the order in which the
/// triangles that close the hole run along them. A rim passes a vertex once. Edges that do not add
/// up to a ring stay open.
std::vector<std::vector<uint32_t>> cutRims(std::span<const uint32_t> indices,
                                           const EdgeBalance& whole);

}  // namespace pelage::detail
