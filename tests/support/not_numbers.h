// Values that tests hand over in place of numbers.
#pragma once

#include <limits>

namespace pelage::test {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInf = std::numeric_limits<float>::infinity();

}  // namespace pelage::test
