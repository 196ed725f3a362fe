// The tier as which the devices of tests count.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "pelage/tier.h"

namespace pelage::test {

/// The one that PELAGE_TIER in the environment names (es, base, wide): ctest runs some programs
/// once for each. Else Tier::kWide.
inline Tier tierOfTests() {
  const char* name = std::getenv("PELAGE_TIER");
  const std::optional<Tier> tier = name != nullptr ? tierFromName(name) : Tier::kWide;
  if (!tier) ADD_FAILURE() << "PELAGE_TIER is '" << name << "', but must be es, base or wide";
  return tier.value_or(Tier::kWide);
}

}  // namespace pelage::test
