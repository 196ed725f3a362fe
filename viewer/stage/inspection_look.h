// The choice of a view of errors, its colors and the key to them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pelage/transparency.h"
#include "pelage/types.h"

namespace viewer {

/// Colors at even steps from the low end to the high end. Linear RGB, 0..0.6: the picture does not
/// change colors up to 0.6.
struct ColorRamp {
  std::array<pelage::Float3, 5> colors;
};

/// From one color over gray to another, for values on both sides of 0.
extern const ColorRamp kSignedRamp;
/// From gray over yellow to red, for depths.
extern const ColorRamp kDepthRamp;
/// From dark blue over green and yellow to red, for counts.
extern const ColorRamp kCountRamp;
/// Two colors.
extern const ColorRamp kKindRamp;
/// Three colors, the first of which fades into the second.
extern const ColorRamp kDetailRamp;

/// Returns the color of a value; beyond an end, and for NaN at the low end, the end's. \param high
/// > low. It is the function colorOfValue() of viewer/kernels/draw_values.hlsli.
pelage::Float3 colorAt(const ColorRamp& ramp, float low, float high, float value);

enum class InspectedValue : uint8_t {
  kNone,         ///< hair as it is
  kStretch,      ///< of the guides' edges: length over rest length, less 1
  kPenetration,  ///< depth of vertices in colliders
  kOverdraw,     ///< fragments a pixel
  kTiles,        ///< fragments in the tiles of the transparency method, over the hair
  kSdfSurface,   ///< colliders as their SDFs have them, with the hair
  kSdfSlice,     ///< distances of the SDFs in a plane
  kGuides,       ///< guides and follow hairs in two colors
  kDetail,       ///< strands that level of detail leaves out, and guides that are not simulated
};
inline constexpr int kInspectedValues = 9;

enum class SliceAxis : uint8_t { kX, kY, kZ };

struct InspectionLook {
  InspectedValue value = InspectedValue::kNone;
  float stretchRange = 0.01f;       ///< value with the color of the ends, 1e-6..1
  float penetrationRange = 0.002f;  ///< likewise [m], 1e-6..0.1
  float overdrawRange = 32;         ///< fragments with the color of the end, 1..1024
  float tileRange = 1024;           ///< entries of a tile with the color of the end, 1..65536
  float sliceRange = 0.02f;         ///< distance with the color of an end [m], 1e-4..1
  SliceAxis sliceAxis = SliceAxis::kX;
  float slicePosition = 0.5f;  ///< share of the SDF's extent along the axis, 0..1
  /// Goes to the next value, or back to the previous one.
  void show(bool back);
  bool operator==(const InspectionLook&) const = default;
};

/// Whether a view of errors draws the hair itself, the meshes, and passes of its own.
bool drawsHair(InspectedValue value);
bool drawsMeshes(InspectedValue value);
bool hasPasses(InspectedValue value);

/// Figures over all hair of a view, measured some frames ago.
struct InspectionFigures {
  bool known = false;
  float largest =
      0;  ///< largest magnitude in the unit of the value; count of the fullest pixel or tile
  uint64_t beyond = 0;     ///< vertices beyond the range
  uint64_t notFinite = 0;  ///< vertices
  uint64_t measured = 0;   ///< vertices
  uint64_t pixels = 0;     ///< with hair
  uint64_t fragments = 0;  ///< of all pixels or tiles
  uint64_t tiles = 0;      ///< with hair
  uint64_t tilesWithoutRoom = 0;
  /// Level of detail.
  uint64_t strands = 0, drawn = 0, fading = 0, guides = 0, simulated = 0;
  float widening = 1;  ///< factor on the widths of strands, the largest of all hair
};

/// The key of the colors.
struct InspectionKey {
  std::string title;
  const ColorRamp* ramp = nullptr;  ///< nullptr: there are no colors
  std::string low, middle, high;    ///< values of the ends and the middle, with units
  std::vector<std::string> lines;   ///< figures
};

/// Returns the name of a value: "stretch".
const char* nameOf(InspectedValue value);
/// Return the ends of the colors in SI units.
float lowOf(const InspectionLook& look);
float highOf(const InspectionLook& look);
/// Returns the key of a look; it has no title for kNone and kSdfSurface. \param method of the view.
InspectionKey inspectionKey(const InspectionLook& look, const InspectionFigures& figures,
                            pelage::Transparency method);

}  // namespace viewer
