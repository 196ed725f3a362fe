// Selects a permutation for a key that the manifest excludes. docs: codegen/README.md.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codegen/manifest.h"

namespace pelage::codegen {

/// In keys that fulfill all conditions a bool axis is switched on.
struct CompletionRule {
  uint32_t axis = 0;
  std::vector<AxisValue> conditions;

  bool appliesTo(const Permutation& permutation) const;
  auto operator<=>(const CompletionRule&) const = default;
};

/// The smallest existing permutation with all features of a key, for all keys of a kernel that do
/// not conflict. Bool axes are only switched on; the value of another axis stays.
struct KeyCompletion {
  std::vector<CompletionRule> rules;  ///< by axis; all read the requested key

  /// The first key for which no existing permutation has all features.
  std::optional<Permutation> incomplete;
  /// The first key with several smallest permutations, and two of those.
  std::vector<Permutation> ambiguous;

  Permutation complete(const Permutation& wanted) const;
};

/// Rules are made only where every key has a completion.
KeyCompletion completeKeys(const ManifestKernel& kernel);

}  // namespace pelage::codegen
