// The UV of roots, and how much of the surface each stands for.
#pragma once

#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/types.h"

namespace pelage::detail {

/// HairBuffers::strandUvs of an asset with HairAsset::strandUv. The distance between roots is the
/// edge of a square with the area that a root has: r sqrt(pi / 4) with the distance r to the fourth
/// neighbor. The change of the UV is the lower median over these four, so that neighbors across a
/// seam do not count. Roots without a neighbor, or all at one point, have 0.
/// Cost: n log n for n roots.
std::vector<Float4> rootUvsOf(const HairAsset& asset);

}  // namespace pelage::detail
