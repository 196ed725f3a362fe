// The size of a groom, and whether its unit can be the meter. Files of hair name no unit: one in
// centimeters loads without an error, as hair of 28 m.
#pragma once

#include <string>
#include <vector>

#include "pelage/export.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// Mean strand lengths [m] within which a groom is taken for one in meters.
inline constexpr double kMinMeanLength = 0.001, kMaxMeanLength = 3;

struct HairSize {
  double meanLength = 0;  ///< mean length of the strands, along their vertices [m]
  double maxLength = 0;   ///< length of the longest strand [m]
  Float3 low, high;       ///< bounds of the vertices [m]
};

/// Returns the size of a groom, as loaded or processed. Vertices beyond HairAsset::vertexCounts do
/// not count. Costs one pass over the positions. Errors: an asset that validate() refuses.
PELAGE_API Result<HairSize> measureHair(const HairAsset& asset);

/// A unit that a groom may be in.
struct UnitGuess {
  const char* unit = "";  ///< "centimeters"
  float scale = 1;        ///< meters per unit, for scaleHair()
  double meanLength = 0;  ///< mean length of the strands with this scale [m]
};

/// Returns the units with which strands of this mean length would be of a size that hair has, the
/// likeliest first; empty if the length is within kMinMeanLength..kMaxMeanLength, or if no usual
/// unit explains it. \param meanLength HairSize::meanLength.
PELAGE_API std::vector<UnitGuess> guessUnits(double meanLength);

/// Returns one line about strands that are too long or too short for meters, with the likely units
/// and their scales; empty if nothing is wrong.
PELAGE_API std::string unitWarning(const HairSize& size);

/// Multiplies all positions, and clears what process() has derived from them: call it again. Scale
/// follow hairs and collision meshes with it: FollowHair::offset.x, y and z, and
/// CollisionMesh::positions. \param scale meters per unit, 1e-9..1e9. Errors, after which the asset
/// is as it was: a scale out of range, a coordinate beyond kMaxCoordinate.
PELAGE_API Result<void> scaleHair(HairAsset& asset, float scale);

}  // namespace pelage
