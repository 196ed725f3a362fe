// A curve along the strand that is drawn by hand.
#pragma once

#include "pelage/simulation_settings.h"

namespace viewer {

/// Draws a curve as a field of the given height; where the mouse drags over it, the points follow:
/// root on the left, tip on the right. Returns whether it changed the curve.
/// \param low, high values at the lower and the upper edge.
bool editCurve(const char* id, pelage::ParameterCurve& curve, float low, float high, float width,
               float height);

}  // namespace viewer
