// The widget of one parameter.
#pragma once

#include <string>

#include "pelage/settings/parameter.h"

namespace viewer {

/// Draws the widget that sets a value, as wide as ImGui::CalcItemWidth() says. Returns whether the
/// user changed it; it is then in range.
bool editValue(const pelage::Parameter& parameter, pelage::ParameterValue& value);

/// The value as a user reads it, with its unit: "0.05 m".
std::string valueText(const pelage::Parameter& parameter, const pelage::ParameterValue& value);

/// A sentence on the parameter, with unit and range, for a tooltip.
std::string tooltipText(const pelage::Parameter& parameter);

}  // namespace viewer
