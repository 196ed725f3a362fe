// How deep points are inside what hair collides with.
#pragma once

#include <span>
#include <vector>

#include "pelage/collider.h"
#include "pelage/types.h"
#include "reference/sdf/mesh_shapes.h"

namespace bench {

/// Distance from the surface of a capsule, negative inside [m].
double capsuleDistance(const pelage::CapsuleCollider& capsule, const pelage::Float3& point);

/// Points that are deeper in a mesh count as this deep [m].
inline constexpr double kDeepest = 0.05;

/// Depth of each point below the surface, 0 outside [m], by the double-precision oracle.
std::vector<double> depthsInMesh(const pelage::reference::TriangleMesh& mesh,
                                 std::span<const pelage::Float3> points);

}  // namespace bench
