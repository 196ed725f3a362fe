// What a view of errors shows, and the key to its colors.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stage/color_ramp.h"

namespace viewer {

enum class InspectedValue : uint8_t {
  kNone,         ///< hair as it is
  kStretch,      ///< of the guides' edges: length over rest length, less 1
  kPenetration,  ///< depth of vertices in colliders
  kOverdraw,     ///< fragments a pixel
  kSdfSurface,   ///< colliders as their SDFs have them, with the hair
  kSdfSlice,     ///< distances of the SDFs in a plane
  kGuides,       ///< guides and follow hairs in two colors
};
inline constexpr int kInspectedValues = 7;

enum class SliceAxis : uint8_t { kX, kY, kZ };

struct InspectionLook {
  InspectedValue value = InspectedValue::kNone;
  float stretchRange = 0.01f;       ///< that has the color of an end, 1e-6..1
  float penetrationRange = 0.002f;  ///< likewise [m], 1e-6..0.1
  float overdrawRange = 32;         ///< fragments with the color of the end, 1..1024
  float sliceRange = 0.02f;         ///< distance with the color of an end [m], 1e-4..1
  SliceAxis sliceAxis = SliceAxis::kX;
  float slicePosition = 0.5f;  ///< share of the SDF's extent along the axis, 0..1
  /// Goes to the next value, or to the one before.
  void show(bool back);
  bool operator==(const InspectionLook&) const = default;
};

/// Whether hair is drawn as it is, and whether meshes are.
bool drawsHair(InspectedValue value);
bool drawsMeshes(InspectedValue value);

/// What was measured over all hair of a view, some frames ago.
struct InspectionFigures {
  bool known = false;
  float largest = 0;       ///< magnitude, in the unit of the value; fragments of the fullest pixel
  uint64_t beyond = 0;     ///< vertices beyond the range
  uint64_t notFinite = 0;  ///< vertices
  uint64_t measured = 0;   ///< vertices
  uint64_t pixels = 0;     ///< with hair
  uint64_t fragments = 0;
};

/// The key of the colors.
struct InspectionKey {
  std::string title;
  const ColorRamp* ramp = nullptr;
  std::string low, middle, high;   ///< values of the ends and the middle, with units
  std::vector<std::string> lines;  ///< figures
};

/// "Stretch", ...: names for lists, in the order of InspectedValue.
const char* nameOf(InspectedValue value);
/// Ends of the colors in SI units.
float lowOf(const InspectionLook& look);
float highOf(const InspectionLook& look);
/// Its `ramp` is nullptr where there are no colors: kNone, kSdfSurface.
InspectionKey inspectionKey(const InspectionLook& look, const InspectionFigures& figures);

}  // namespace viewer
