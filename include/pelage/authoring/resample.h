// From curves with any number of vertices to strands that all have the same number.
#pragma once

#include <cstdint>
#include <functional>

#include "pelage/authoring/hair_curves.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace pelage {

/// Where on its curve a strand has its vertices. The ends are always kept.
enum class VertexPlacement : uint8_t {
  /// The same arc length between all of them. What simulates best, and what to take unless the
  /// vertices must be few.
  kEven,
  /// Dense where the curve bends, so that the largest deviation is as small as it can be; where
  /// that leaves a choice, as even as it can be. Segments are 1/3 to 2 times as long as even ones,
  /// and the first one, which is kinematic, is no longer than that of kEven. See resampleCurves().
  kFitted,
};

struct ResampleDef {
  uint32_t verticesPerStrand = 16;  ///< 2..256; not used with an errorBound
  /// > 0: the smallest number of vertices with which no curve deviates by more [m]; >= 0.
  float errorBound = 0;
  VertexPlacement placement = VertexPlacement::kEven;
  /// The last two vertices are kinematic as well as the first two (a braid, a lash on two bones).
  bool bothEndsImmovable = false;
};

/// How far the strands are from their curves. The deviation of a strand is the Hausdorff distance
/// of the two polylines: no point of either, vertex or not, is farther than this from the other
/// one. It is exact to 2^-30 of the curve's size.
struct ResampleReport {
  uint32_t strands = 0;
  uint32_t verticesPerStrand = 0;
  float maxDeviation = 0;         ///< [m]
  float meanDeviation = 0;        ///< of all strands [m]
  uint32_t worstCurve = 0;        ///< the curve that deviates most
  float maxLengthChange = 0;      ///< largest change of a strand's length, relative to its curve's
  uint32_t zeroLengthCurves = 0;  ///< all vertices in one place; kept as they are
  /// Mean radius of the curves, by length of curve [m]: the fibre radius to which
  /// HairAsset::strandThickness is relative; 0 where the curves have no radii.
  float fibreRadius = 0;
};

struct ResampleResult {
  HairAsset asset;  ///< process() has not been called, but accepts it
  ResampleReport report;
};

/// Called now and then, from the calling thread.
using AuthoringProgress = std::function<void(uint64_t done, uint64_t total)>;

/// Makes a strand of each curve, in their order. Its vertices lie on the polyline that the curve
/// is, the first and the last at its ends. Repeated vertices of a curve do not matter.
/// - Inverse masses are interpolated, or 1 without any, and 0 on vertices 0 and 1 (and on the last
///   two, see bothEndsImmovable). Colours and vertex UV are interpolated, strand UV are kept.
/// - Radii become strandThickness: a strand's mean radius relative to that of all.
/// - kFitted chooses among points of the curve that are a twelfth of an even segment apart, first
///   for the least deviation (the min-epsilon problem of Imai and Iri 1988, "Polygonal
///   approximations of a curve", by dynamic programming), then for the least sum of squared
///   differences from even segments.
/// Errors: what validate(HairCurves) refuses, no curves, a radius below 0, a value of `def` out of
/// range, an errorBound that 256 vertices do not hold (the message says what they reach), more than
/// 2^31 vertices.
Result<ResampleResult> resampleCurves(const HairCurves& curves, const ResampleDef& def = {},
                                      const AuthoringProgress& progress = {});

}  // namespace pelage
