// A signed distance field as the kernels read it, made on the host by looking at every node: what
// the kernels that collide with fields are tested on, whoever builds them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/types.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"

namespace pelage::reference {

struct FieldOptions {
  double cell = 0.01;      ///< [m]
  double band = 2;         ///< [cell]
  double padding = 3;      ///< [cell] between the mesh and the grid's end
  bool interior = true;    ///< far keys of the coarse nodes inside; else they are left unset
  bool allInside = false;  ///< far keys of all nodes inside, as older files have them
  float margin = 0;        ///< [m]
  float friction = 0;
  /// The vertices a frame before, for records with motion.
  const std::vector<Float3>* before = nullptr;
};

/// Keys and records of one or more fields, as they lie in the buffers.
struct SdfBuffers {
  std::vector<Sdf> sdfs;
  std::vector<uint32_t> keys;
  std::vector<Uint4> surface;
};

/// Appends the field of a mesh. Keys have the nearest triangle and its distance from the oracle.
void addSdf(SdfBuffers& buffers, const TriangleMesh& mesh, const DistanceOracle& oracle,
            const FieldOptions& options);

/// A unit vector in 32 bits, as kernels/base/octahedral.hlsli unpacks it.
uint32_t packDirection(const Vector3d& direction);

}  // namespace pelage::reference
