// Where on a slider a value is.
#pragma once

#include "pelage/settings/parameter.h"

namespace viewer {

/// Share of a slider, 0..1, at which a value is: 0 below its low end, 1 above its high end.
double shareOf(const pelage::Parameter& parameter, double value);

/// The value at a share of a slider, 0..1, rounded to three digits, but for its ends; of counts to
/// whole numbers. It is in the range of the parameter.
double valueAtShare(const pelage::Parameter& parameter, double share);

}  // namespace viewer
