// Colors of values: what a view of errors draws with, and what its key in the window shows.
#pragma once

#include <array>

#include "pelage/types.h"

namespace viewer {

/// Linear RGB, 0..0.6, which the picture shows as it is: evenly from the low end to the high one.
struct ColorRamp {
  std::array<pelage::Float3, 5> colors;
};

/// From one color over gray to another: values on both sides of 0.
extern const ColorRamp kSignedRamp;
/// From gray over yellow to red: the more, the worse.
extern const ColorRamp kDepthRamp;
/// From dark blue over green and yellow to red: counts.
extern const ColorRamp kCountRamp;
/// Two colors.
extern const ColorRamp kKindRamp;
/// Three colors, the first of which fades into the second.
extern const ColorRamp kDetailRamp;

/// The color of a value, that of an end beyond it; of NaN that of the low end. \param high > low.
/// As colorOfValue() of viewer/kernels/draw_values.hlsli.
pelage::Float3 colorAt(const ColorRamp& ramp, float low, float high, float value);

}  // namespace viewer
