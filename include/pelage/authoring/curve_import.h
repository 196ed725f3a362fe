// Prepares curves from a file for all other functions: meters, y up.
#pragma once

#include <cstdint>

#include "pelage/authoring/hair_curves.h"
#include "pelage/result.h"

namespace pelage {

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

}  // namespace pelage
