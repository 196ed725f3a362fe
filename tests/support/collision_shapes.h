// Shapes of the references as meshes of colliders.
#pragma once

#include "pelage/collision_mesh.h"
#include "reference/sdf/mesh_shapes.h"

namespace pelage::test {

inline CollisionMesh toMesh(const reference::TriangleMesh& shape) {
  CollisionMesh mesh;
  mesh.positions = shape.positions;
  mesh.normals.resize(shape.positions.size());
  mesh.indices = shape.indices;
  return mesh;
}

}  // namespace pelage::test
