// The median of measured values.
#pragma once

#include <algorithm>
#include <vector>

namespace bench {

/// \param none  what it is of no values
inline double medianOf(std::vector<double> values, double none = 0) {
  if (values.empty()) return none;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace bench
