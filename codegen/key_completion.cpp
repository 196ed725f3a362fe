#include "codegen/key_completion.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace pelage::codegen {
namespace {

// True if a permutation has the values of another one and all that is switched on there.
bool contains(const ManifestKernel& kernel, const Permutation& larger, const Permutation& smaller) {
  for (size_t i = 0; i < kernel.axes.size(); ++i) {
    const bool fits = kernel.axes[i].isBool ? larger[i] >= smaller[i] : larger[i] == smaller[i];
    if (!fits) return false;
  }
  return true;
}

// The existing permutations that contain a key, without those that contain another one of them.
std::vector<Permutation> smallestAround(const ManifestKernel& kernel, const Permutation& wanted,
                                        const std::vector<Permutation>& existing) {
  std::vector<Permutation> around;
  for (const Permutation& permutation : existing) {
    if (contains(kernel, permutation, wanted)) around.push_back(permutation);
  }
  std::vector<Permutation> smallest;
  for (const Permutation& permutation : around) {
    const bool isSmallest =
        std::none_of(around.begin(), around.end(), [&](const Permutation& other) {
          return other != permutation && contains(kernel, permutation, other);
        });
    if (isSmallest) smallest.push_back(permutation);
  }
  return smallest;
}

// A key that exists or is completed.
struct Completed {
  Permutation wanted;
  Permutation given;
};

// Finds the rules of one axis: a disjunction that is true for just the keys that need it.
class RuleFinder {
 public:
  RuleFinder(const ManifestKernel& kernel, const std::vector<Completed>& keys, uint32_t axis)
      : kernel_(kernel), keys_(keys), axis_(axis) {}

  std::vector<CompletionRule> find() const {
    std::vector<CompletionRule> rules;
    for (const Completed& key : keys_) {
      if (!needsRule(key) || isCovered(key, rules)) continue;
      rules.push_back(shortened(ruleOf(key.wanted)));
    }
    // A rule that several others cover together is not needed.
    for (size_t i = rules.size(); i-- > 0;) {
      std::vector<CompletionRule> others = rules;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const bool isNeeded = std::any_of(keys_.begin(), keys_.end(), [&](const Completed& key) {
        return needsRule(key) && !isCovered(key, others);
      });
      if (!isNeeded) rules = std::move(others);
    }
    std::sort(rules.begin(), rules.end());
    return rules;
  }

 private:
  bool needsRule(const Completed& key) const { return key.given[axis_] != key.wanted[axis_]; }

  static bool isCovered(const Completed& key, const std::vector<CompletionRule>& rules) {
    return std::any_of(rules.begin(), rules.end(),
                       [&](const CompletionRule& rule) { return rule.appliesTo(key.wanted); });
  }

  // True if the rule switches nothing on that would stay off.
  bool holds(const CompletionRule& rule) const {
    return std::all_of(keys_.begin(), keys_.end(), [&](const Completed& key) {
      return key.given[axis_] != 0 || !rule.appliesTo(key.wanted);
    });
  }

  // A larger key has a larger completion, so what is off is no condition.
  CompletionRule ruleOf(const Permutation& wanted) const {
    CompletionRule rule{axis_, {}};
    for (uint32_t i = 0; i < wanted.size(); ++i) {
      if (!kernel_.axes[i].isBool || wanted[i] != 0) rule.conditions.emplace_back(i, wanted[i]);
    }
    return rule;
  }

  // Without the conditions that need not be; values go first.
  CompletionRule shortened(CompletionRule rule) const {
    for (const bool isBool : {false, true}) {
      for (size_t i = rule.conditions.size(); i-- > 0;) {
        if (kernel_.axes[rule.conditions[i].first].isBool != isBool) continue;
        CompletionRule shorter = rule;
        shorter.conditions.erase(shorter.conditions.begin() + static_cast<std::ptrdiff_t>(i));
        if (holds(shorter)) rule = std::move(shorter);
      }
    }
    return rule;
  }

  const ManifestKernel& kernel_;
  const std::vector<Completed>& keys_;
  uint32_t axis_;
};

}  // namespace

bool CompletionRule::appliesTo(const Permutation& permutation) const {
  return std::all_of(conditions.begin(), conditions.end(), [&](const AxisValue& condition) {
    return permutation[condition.first] == condition.second;
  });
}

Permutation KeyCompletion::complete(const Permutation& wanted) const {
  Permutation given = wanted;
  for (const CompletionRule& rule : rules) {
    if (rule.appliesTo(wanted)) given[rule.axis] = 1;
  }
  return given;
}

KeyCompletion completeKeys(const ManifestKernel& kernel) {
  KeyCompletion completion;
  if (kernel.excludes.empty()) return completion;
  const std::vector<Permutation> existing = kernel.permutations();
  std::vector<Completed> keys;
  for (const Permutation& wanted : kernel.combinations()) {
    if (kernel.isConflict(wanted)) continue;
    if (!kernel.isExcluded(wanted)) {
      keys.push_back({wanted, wanted});
      continue;
    }
    const std::vector<Permutation> smallest = smallestAround(kernel, wanted, existing);
    if (smallest.empty()) {
      if (!completion.incomplete) completion.incomplete = wanted;
    } else if (smallest.size() > 1) {
      if (completion.ambiguous.empty()) completion.ambiguous = {wanted, smallest[0], smallest[1]};
    } else {
      keys.push_back({wanted, smallest[0]});
    }
  }
  if (completion.incomplete || !completion.ambiguous.empty()) return completion;
  // Small keys first: their rules are those of larger ones as well.
  const auto switchedOn = [&](const Permutation& permutation) {
    size_t count = 0;
    for (size_t i = 0; i < permutation.size(); ++i)
      count += kernel.axes[i].isBool && permutation[i] != 0 ? 1 : 0;
    return count;
  };
  std::stable_sort(keys.begin(), keys.end(), [&](const Completed& a, const Completed& b) {
    return switchedOn(a.wanted) < switchedOn(b.wanted);
  });
  for (uint32_t axis = 0; axis < kernel.axes.size(); ++axis) {
    if (!kernel.axes[axis].isBool) continue;
    for (CompletionRule& rule : RuleFinder(kernel, keys, axis).find())
      completion.rules.push_back(std::move(rule));
  }
  return completion;
}

}  // namespace pelage::codegen
