// Vertices that agree become one.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/authoring/skinned_mesh.h"

namespace pelage::detail {

/// Attributes that must be equal bit by bit, except for the sign of zero.
enum class WeldBy : uint8_t {
  kPosition,
  kPositionAndBones,
  kPositionNormalAndBones,
};

/// [vertex] the first vertex that it agrees with; itself when there is none before it.
std::vector<uint32_t> weldVertices(const SkinnedMesh& mesh, WeldBy by);

}  // namespace pelage::detail
