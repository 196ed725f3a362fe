// Hair as curves, each with any number of vertices: the form in which modeling programs store it,
// and from which HairAsset is made.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// How a modeling program labels a curve.
struct CurveLabel {
  uint64_t id = 0;       ///< Unreal's groom_id; the index of the curve where a file has none
  uint32_t group = 0;    ///< Unreal's groom_group_id; below 2^24
  bool isGuide = false;  ///< Unreal's groom_guide
  bool operator==(const CurveLabel&) const = default;
};

/// Curves of hair, root first. Per-vertex arrays hold the vertices of curve 0, then of curve 1, and
/// so on; optional arrays may be empty.
struct HairCurves {
  std::vector<uint32_t> vertexCounts;  ///< [curve] >= 2
  std::vector<Float3> positions;  ///< [vertex] [m] after scaling; before, in the unit of the file
  std::vector<float> inverseMasses;  ///< [vertex] >= 0, 0 = kinematic; optional
  std::vector<float> radii;          ///< [vertex] of the fiber, in the unit of positions; optional
  std::vector<Float4> colors;        ///< [vertex] linear RGBA, A = opacity; optional
  std::vector<Float2> vertexUv;      ///< [vertex]; optional
  std::vector<Float2> strandUv;      ///< [curve] UV on the scalp's texture; optional
  std::vector<CurveLabel> labels;    ///< [curve]; optional, only .usda has them

  uint32_t curveCount() const { return static_cast<uint32_t>(vertexCounts.size()); }
};

/// Fiber radius for a HairAsset::strandThickness of 1, where curves become strands or the other way
/// [m]; thus also the StrandMaterial::fiberRadius of such hair.
inline constexpr float kUnitFiberRadius = 4e-5f;

/// Checks that the arrays match and the values are in range: coordinates finite and within
/// kMaxCoordinate, everything else finite. Errors name curve and vertex.
Result<void> validate(const HairCurves& curves);

}  // namespace pelage
