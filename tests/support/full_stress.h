// How much of a long test runs.
#pragma once

#include <cstdlib>
#include <string_view>

namespace pelage::test {

/// PELAGE_STRESS=full runs everything, as scripts/test_all.sh does in the steps that say so;
/// without it tests run the share of it that a contributor waits for.
inline bool fullStress() {
  const char* const wanted = std::getenv("PELAGE_STRESS");
  return wanted != nullptr && std::string_view(wanted) == "full";
}

}  // namespace pelage::test
