// The numbers of a light: which are wrong.
#pragma once

#include <string>

#include "pelage/view.h"

namespace pelage::detail {

/// What of a light's shadow is out of range, by the field's name; empty: nothing.
std::string numberFaultOf(const Light& light);

}  // namespace pelage::detail
