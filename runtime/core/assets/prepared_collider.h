// What addCollider() derives from a mesh, kept with it by caches.
#pragma once

#include <cstdint>

#include "assets/collider_topology.h"
#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage::detail {

struct PreparedCollider {
  /// hash64() of what it was derived from: a mesh that was changed since does without it.
  uint64_t positionsHash = 0, indicesHash = 0;
  ColliderTopology topology;
};

/// Whether the mesh has one, and still is the mesh that it was derived from.
bool isPrepared(const CollisionMesh& mesh);

/// The mesh's own one when it still fits, else a new one. Errors: those of makeColliderTopology().
Result<ColliderTopology> topologyOf(const CollisionMesh& mesh);

}  // namespace pelage::detail
