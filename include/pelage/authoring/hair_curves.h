// Hair as curves, each with any number of vertices: the form in which modeling programs store it,
// and from which HairAsset is made.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pelage/hair_asset.h"
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

/// The axis of a file that points up; pelage has y up.
enum class UpAxis {
  kX,  ///< rotated about z: (x, y, z) -> (-y, x, z)
  kY,
  kZ  ///< rotated about x: (x, y, z) -> (x, z, -y)
};

/// The changes of prepareCurves(), in this order.
struct CurveImportDef {
  float scale = 1;                ///< meters per unit of the file, 1e-9..1e9
  UpAxis upAxis = UpAxis::kY;     ///< up axis of the file
  bool invertZ = false;           ///< z -> -z, after the rotation: mirrors the groom
  bool invertV = false;           ///< v -> 1 - v in all UV
  float minCurveLength = 0;       ///< shorter curves are dropped [m], 0..1e6
  bool randomizeStrands = false;  ///< shuffles the curves: the first n are then a fair sample
  uint64_t seed = 1;              ///< seed of the shuffle; gives the same order on every machine
  bool operator==(const CurveImportDef&) const = default;
};

/// The results of prepareCurves(). It counts everything that it drops or changes.
struct CurveImportReport {
  uint64_t curvesRead = 0, verticesRead = 0;
  uint64_t curvesKept = 0, verticesKept = 0;
  /// Curves dropped: fewer than two vertices in the file, fewer than two with usable coordinates,
  /// no length, shorter than minCurveLength. A curve counts at the first that applies.
  uint64_t droppedSingleVertex = 0, droppedUnusable = 0, droppedNoLength = 0, droppedShort = 0;
  /// Vertices removed because a coordinate was not finite, or beyond +-1e6 m once scaled.
  uint64_t removedVertices = 0;
  /// Numbers replaced: a UV, color, radius or inverse mass that was not finite by 0; a negative
  /// radius or inverse mass by 0.
  uint64_t repairedValues = 0;
  double minLength = 0, meanLength = 0, maxLength = 0;  ///< [m] of the curves kept

  uint64_t curvesDropped() const {
    return droppedSingleVertex + droppedUnusable + droppedNoLength + droppedShort;
  }
};

/// Changes curves according to `def` and removes degenerate ones; validate() accepts the result.
/// Errors: a value of `def` out of range, arrays that do not match, no curve left.
Result<void> prepareCurves(HairCurves& curves, const CurveImportDef& def,
                           CurveImportReport* report = nullptr);

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
