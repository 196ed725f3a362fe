// The data that addCollider() derives from a mesh; caches store it.
#pragma once

#include <cstdint>

#include "assets/collider_topology.h"
#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage::detail {

struct PreparedCollider {
  /// hash64() of its source: if the mesh has changed since, the data is ignored.
  uint64_t positionsHash = 0, indicesHash = 0;
  ColliderTopology topology;
};

/// Returns true if the mesh has prepared data that still match it.
bool isPrepared(const CollisionMesh& mesh);

/// Returns the mesh's own data if they still match, otherwise new ones. Errors: those of
/// makeColliderTopology().
Result<ColliderTopology> topologyOf(const CollisionMesh& mesh);

}  // namespace pelage::detail
