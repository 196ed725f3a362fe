// One binding plan per layout, from the resources of all kernels and permutations that use it. A
// layout that several groups share has one plan and the same set number in all of them.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "codegen/back_end.h"
#include "codegen/diagnostics.h"
#include "codegen/manifest.h"
#include "codegen/reflect.h"
#include "codegen/unit.h"

namespace pelage::codegen {

struct PlannedEntry {
  std::string name;  ///< as in HLSL
  std::string structName;
  ResourceKind kind = ResourceKind::kStorageBuffer;
  RegisterClass registerClass = RegisterClass::kUniform;
  uint32_t registerNumber = 0;
  uint32_t stride = 0;
  uint32_t binding = 0;
  uint32_t glBinding = 0;  ///< not of storage buffers
  Access access = Access::kNone;
  StageMask stages = 0;
  SourceLocation location;
};

struct PlannedLayout {
  std::string name;
  std::string group;  ///< the first one that has it
  uint32_t set = 0;
  std::vector<PlannedEntry> entries;  ///< index = Vulkan binding
};

class LayoutPlan {
 public:
  explicit LayoutPlan(const Manifest& manifest);

  /// Adds the resources of a reflected module, and reports their errors, except those that the
  /// front end has reported.
  void add(const Unit& unit, Diagnostics& diagnostics);

  /// Numbers the bindings. Call once, after the last add().
  void assign(Diagnostics& diagnostics);

  /// Returns the bindings of the resources of a reflected module.
  std::vector<BindingPatch> patches(const Unit& unit) const;

  /// In the manifest's order, without duplicates.
  std::vector<PlannedLayout>& layouts() { return layouts_; }
  const std::vector<PlannedLayout>& layouts() const { return layouts_; }
  PlannedLayout& layout(uint32_t group, uint32_t set) { return layouts_[indices_[group][set]]; }
  const PlannedLayout& layout(uint32_t group, uint32_t set) const {
    return layouts_[indices_[group][set]];
  }

 private:
  /// The layouts of all groups that have this one, as indices into layouts_.
  std::set<size_t> boundWith(size_t layout) const;

  const Manifest& manifest_;
  std::vector<std::vector<size_t>> indices_;  ///< [group][set] into layouts_
  std::vector<PlannedLayout> layouts_;
};

/// Raw binding number of a register, as the front end writes it.
uint32_t rawBinding(RegisterClass registerClass, uint32_t registerNumber);

}  // namespace pelage::codegen
