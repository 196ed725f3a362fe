// How far a built field is from the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pelage/sdf_collider.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"

namespace pelage::test {

/// Greatest error of the distances within the band [cell]; counts wrong signs.
inline double sdfError(const SdfData& data, const reference::TriangleMesh& mesh, int& wrongSigns) {
  const double cell = static_cast<double>(data.grid.cellSize);
  const uint32_t nodes[3] = {data.grid.nodes[0], data.grid.nodes[1], data.grid.nodes[2]};
  const Eigen::Vector3d origin = {static_cast<double>(data.grid.origin.x),
                                  static_cast<double>(data.grid.origin.y),
                                  static_cast<double>(data.grid.origin.z)};
  const std::vector<double> truth =
      reference::DistanceOracle(mesh).gridDistances(origin, cell, nodes);
  const double most = std::exp2(30 - static_cast<int>(data.triangleBits)) - 1;
  double largest = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const uint32_t key = data.keys[i];
    const double d = truth[i] / cell;
    if (std::abs(d) > 1e-3 && (key >> 31 != 0) != (d < 0)) ++wrongSigns;
    if ((key & 0x40000000u) != 0) continue;
    const double code = (key & 0x3fffffffu) >> data.triangleBits;
    largest =
        std::max(largest, std::abs(code / most * static_cast<double>(data.band) - std::abs(d)));
  }
  return largest;
}

}  // namespace pelage::test
