// Which permutation a key gets that the manifest excludes. docs: codegen/README.md.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "codegen/manifest.h"

namespace pelage::codegen {

/// Keys that fulfil all conditions get a bool axis switched on.
struct CompletionRule {
  uint32_t axis = 0;
  std::vector<AxisValue> conditions;

  bool appliesTo(const Permutation& permutation) const;
  auto operator<=>(const CompletionRule&) const = default;
};

/// The smallest existing permutation that has everything a key asks for, for all keys of a kernel
/// that do not conflict. Bool axes are only switched on; the value of another axis stays.
struct KeyCompletion {
  std::vector<CompletionRule> rules;  ///< by axis; all read the key as it was asked for

  /// The first key that no existing permutation contains.
  std::optional<Permutation> incomplete;
  /// The first key with several smallest permutations, and two of those.
  std::vector<Permutation> ambiguous;

  Permutation complete(const Permutation& wanted) const;
};

/// Rules are made only where every key has a completion.
KeyCompletion completeKeys(const ManifestKernel& kernel);

}  // namespace pelage::codegen
