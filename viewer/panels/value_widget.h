// The widget of one parameter, its slider and the curve that is drawn by hand.
#pragma once

#include <string>
#include <string_view>

#include "pelage/settings/parameter.h"
#include "pelage/simulation_settings.h"

namespace viewer {

/// Returns the position of a value on a slider, 0..1: 0 below its low end, 1 above its high end.
double shareOf(const pelage::Parameter& parameter, double value);

/// Returns the value at a position on a slider, 0..1, in the range of the parameter. Values between
/// the ends are rounded to three digits, counts to whole numbers.
double valueAtShare(const pelage::Parameter& parameter, double share);

/// Draws a curve along the strand, root on the left, tip on the right. Its points follow the mouse
/// that drags over them. \param low, high values at the lower and the upper edge. \return whether
/// the curve changed.
bool editCurve(const char* id, pelage::ParameterCurve& curve, float low, float high, float width,
               float height);

/// Draws the widget that sets a value, ImGui::CalcItemWidth() wide. Numbers are beside their
/// slider, with their unit. \return whether the user changed the value, which stays in range.
bool editValue(const pelage::Parameter& parameter, pelage::ParameterValue& value);

/// Returns the name of a member in words: "bend length" for bendLength.
std::string wordsOf(std::string_view name);

/// Returns the text of a value with its unit: "0.05 m".
std::string valueText(const pelage::Parameter& parameter, const pelage::ParameterValue& value);

/// Returns the tooltip of a parameter: its meaning, unit and range.
std::string tooltipText(const pelage::Parameter& parameter);

}  // namespace viewer
