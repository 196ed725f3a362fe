// Resamples curves with any number of vertices to strands that all have the same number.
#pragma once

#include <cstdint>
#include <functional>

#include "pelage/authoring/hair_curves.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace pelage {

/// The distribution of a strand's vertices on its curve. The ends are always kept.
enum class VertexPlacement : uint8_t {
  /// The same arc length between all vertices. It simulates best: use it unless there must be few
  /// vertices.
  kEven,
  /// Dense where the curve bends, so that the maximum deviation is as small as possible; among
  /// equal choices, as even as possible. Segments are 1/3 to 2 times as long as even ones, and the
  /// first one, which is kinematic, is no longer than that of kEven. See resampleCurves().
  kFitted,
};

struct ResampleDef {
  uint32_t verticesPerStrand = 16;  ///< 2..256; ignored with an errorBound
  /// Maximum deviation of a curve [m], >= 0. If > 0, uses the minimum number of vertices that holds
  /// it.
  float errorBound = 0;
  VertexPlacement placement = VertexPlacement::kEven;
  /// The last two vertices are kinematic as well as the first two (a braid, a lash on two bones).
  bool bothEndsImmovable = false;
  float unitRadius = kUnitFiberRadius;  ///< radius for a strandThickness of 1 [m], > 0
};

/// The deviation of the strands from their curves. The deviation of a strand is the Hausdorff
/// distance of the two polylines: no point of either, vertex or not, is farther than this from the
/// other polyline. It is exact to 2^-30 of the curve's size.
struct ResampleReport {
  uint32_t strands = 0;
  uint32_t verticesPerStrand = 0;
  float maxDeviation = 0;         ///< [m]
  float meanDeviation = 0;        ///< mean over all strands [m]
  uint32_t worstCurve = 0;        ///< the curve with the maximum deviation
  float maxLengthChange = 0;      ///< maximum change of a strand's length, relative to its curve's
  uint32_t zeroLengthCurves = 0;  ///< curves with all vertices at one position; kept as they are
  /// Mean radius of the curves, by length of curve [m]; 0 if they have none.
  float fiberRadius = 0;
};

struct ResampleResult {
  HairAsset asset;  ///< valid for process(), which has not been called
  ResampleReport report;
};

/// Called repeatedly with the progress, from the calling thread.
using AuthoringProgress = std::function<void(uint64_t done, uint64_t total)>;

/// Makes a strand from each curve, in their order. Its vertices lie on the polyline of the curve,
/// the first and the last at its ends. Repeated vertices of a curve do not matter.
/// - Inverse masses are interpolated, or 1 if there are none, and 0 on vertices 0 and 1 (and on the
///   last two, see bothEndsImmovable). Colors and vertex UV are interpolated; strand UV are kept.
/// - Radii become strandThickness: a strand's mean radius relative to unitRadius.
/// - kFitted chooses among points of the curve that are a twelfth of an even segment apart, first
///   for the minimum deviation (the min-epsilon problem of Imai and Iri 1988, "Polygonal
///   approximations of a curve", by dynamic programming), then for the minimum sum of squared
///   differences from even segments.
///
/// Errors: what validate(HairCurves) refuses, no curves, a radius below 0, a value of `def` out of
/// range, an errorBound that 256 vertices exceed (the message names their error), more than 2^31
/// vertices.
Result<ResampleResult> resampleCurves(const HairCurves& curves, const ResampleDef& def = {},
                                      const AuthoringProgress& progress = {});

}  // namespace pelage
