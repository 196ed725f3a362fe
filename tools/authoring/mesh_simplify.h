// Fewer triangles within an error bound that is measured.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"

namespace pelage::detail {

struct SimplifiedMesh {
  std::vector<uint32_t> indices;  ///< into the same vertices
  double error = 0;               ///< upper bound of the two-sided Hausdorff distance [m]
};

/// Simplifies until the two-sided Hausdorff distance would exceed `errorBound` > 0 [m]. Vertices of
/// the result are some of the given ones. A mesh that is closed and consistently oriented stays so.
/// When nothing can go, the result is what was given, but for triangles with two corners at one
/// vertex.
/// \param positions  finite, within kMaxCoordinate; no two the same
/// \param keepRims   open edges stay what they are
SimplifiedMesh simplifyMesh(std::span<const Float3> positions, std::span<const uint32_t> indices,
                            double errorBound, bool keepRims);

}  // namespace pelage::detail
