// The largest and the smallest of the values that a test measures. std::max(worst, NaN) is `worst`:
// a result that is no number would pass every bound.
#pragma once

#include <type_traits>

namespace pelage::test {

/// Makes `largest` the larger of both, and NaN once one of them is NaN.
template <typename T>
void keepLargest(T& largest, std::type_identity_t<T> value) {
  if (largest == largest && !(value <= largest)) largest = value;
}

/// Makes `smallest` the smaller of both, and NaN once one of them is NaN.
template <typename T>
void keepSmallest(T& smallest, std::type_identity_t<T> value) {
  if (smallest == smallest && !(value >= smallest)) smallest = value;
}

}  // namespace pelage::test
