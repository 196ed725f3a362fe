#include "codegen/collect.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "codegen/hash.h"
#include "codegen/names.h"

namespace pelage::codegen {
namespace {

// Guaranteed by Vulkan, GL and GLES for one constant block.
constexpr uint32_t kUniformBlockBytes = 16384;

// A struct, and the first unit that has it.
struct FoundStruct {
  StructLayout layout;
  SourceLocation where;
  const Unit* unit;
};

// PK601: one name for two structs.
std::map<std::string, FoundStruct> findStructs(const std::vector<Unit>& units,
                                               Diagnostics& diagnostics) {
  std::map<std::string, FoundStruct> structs;
  for (const Unit& unit : units) {
    if (!unit.reflection) continue;
    for (const std::string& name : unit.reflection->structConflicts) {
      diagnostics.error(unit.locate(name), "PK601",
                        fmt::format("struct '{}' has two memory layouts in kernel '{}': use one "
                                    "struct for each buffer kind",
                                    name, unit.kernel->name));
    }
    for (const auto& [name, layout] : unit.reflection->structs) {
      const SourceLocation where = unit.locate(name);
      const auto [found, added] = structs.emplace(name, FoundStruct{layout, where, &unit});
      const FoundStruct& other = found->second;
      if (added || other.layout == layout) continue;
      diagnostics.error(
          where, "PK601",
          fmt::format("struct '{}' of kernel '{}' differs from the one of kernel '{}' at {}:{}",
                      name, unit.kernel->name, other.unit->kernel->name, other.where.file,
                      other.where.line));
    }
  }
  return structs;
}

VariantOutput makeVariant(const Unit& unit, const SpirvReader& module, bool keepNames,
                          LayoutPlan& plan) {
  VariantOutput variant;
  variant.permutations.push_back(unit.permutation);
  variant.spirv = keepNames ? unit.back.optimised : unit.back.spirv;
  variant.glsl = unit.back.glsl;
  variant.essl = unit.back.essl;
  // Two manifests may have one kernel, with the same SPIR-V and other numbers in its GLSL.
  Sha256 hash;
  hash.words(unit.back.spirv);
  if (unit.firstStorageBinding != 0) hash.field(uint64_t{unit.firstStorageBinding});
  variant.hash = shortHash(hash.finish());
  const ModuleReflection reflection = reflectModule(module);
  std::copy_n(reflection.groupSize, 3, variant.groupSize);
  variant.sharedBytes = reflection.sharedBytes;
  variant.tier = unit.kernel->tierOf(unit.permutation);
  if (const std::string* why = unit.kernel->whyNotWebgpu(unit.permutation)) variant.noWebgpu = *why;
  for (const Resource& resource : unit.reflection->resources)
    variant.registers.push_back(
        {resource.name, resource.registerClass, resource.registerNumber, resource.space});
  const auto numbers = storageBufferNumbers(module, unit.firstStorageBinding);
  for (const auto& [id, access] : resourceAccess(module)) {
    const uint32_t set = module.decoration(id, SpvDecorationDescriptorSet).value_or(0);
    const uint32_t binding = module.decoration(id, SpvDecorationBinding).value_or(0);
    std::vector<PlannedEntry>& entries = plan.layout(unit.kernel->group, set).entries;
    if (binding >= entries.size()) continue;
    entries[binding].access = entries[binding].access | access;
    const auto number = numbers.find({set, binding});
    variant.bindings.push_back(
        {set, binding, access,
         number != numbers.end() ? number->second : entries[binding].glBinding});
  }
  std::sort(variant.bindings.begin(), variant.bindings.end(),
            [](const BindingUse& a, const BindingUse& b) {
              return std::tie(a.set, a.entry) < std::tie(b.set, b.entry);
            });
  return variant;
}

void collectSpecConstants(const Unit& unit, std::vector<SpecConstantInfo>& constants,
                          Diagnostics& diagnostics) {
  for (const SpecConstantInfo& constant : unit.reflection->specConstants) {
    const SourceLocation where = unit.locate(constant.name);
    bool known = false;
    for (const SpecConstantInfo& other : constants) {
      if (other != constant && other.id != constant.id && other.name != constant.name) continue;
      known = true;
      if (other == constant) continue;
      diagnostics.error(
          where, "PK508",
          fmt::format("specialization constants '{}' (id {}) and '{}' (id {}) of "
                      "kernel '{}' have the same id, name or another default",
                      constant.name, constant.id, other.name, other.id, unit.kernel->name));
    }
    if (known) continue;
    if (constant.type == ScalarType::kOther || !isIdentifier(hostName(constant.name))) {
      diagnostics.error(where, "PK509",
                        "specialization constant '" + constant.name +
                            "' must be a named bool, int, uint or float");
      continue;
    }
    constants.push_back(constant);
  }
}

// The vertex stage's inputs, one for each offset of the manifest and the same in all permutations.
void collectInputs(const Unit& unit, KernelOutput& output, Diagnostics& diagnostics) {
  const ManifestKernel& kernel = *unit.kernel;
  const std::vector<StageInput>& inputs = unit.reflection->inputs;
  const size_t known = kernel.vertexInput ? kernel.vertexInput->offsets.size() : 0;
  const auto error = [&](const std::string& message) {
    diagnostics.error(unit.locate(kernel.name), "PK513", "kernel '" + kernel.name + "' " + message);
  };
  bool fits = inputs.size() == known;
  for (size_t i = 0; i < inputs.size(); ++i) {
    fits = fits && inputs[i].location == i;
    if (inputs[i].scalar != ScalarType::kFloat && inputs[i].scalar != ScalarType::kUint)
      error("has an input '" + inputs[i].name + "' that is no float or uint, or a vector of them");
  }
  if (!fits) {
    error(
        fmt::format("has {} vertex inputs, but \"vertexInput\" in the manifest has {} offsets: "
                    "locations from 0 on, an offset each",
                    inputs.size(), known));
  } else if (output.variants.empty() && output.inputs.empty()) {
    output.inputs = inputs;
  } else if (output.inputs != inputs) {
    error("has other vertex inputs in other permutations");
  }
}

}  // namespace

std::vector<HostStruct> collectStructs(const std::vector<Unit>& units, Diagnostics& diagnostics) {
  const std::map<std::string, FoundStruct> structs = findStructs(units, diagnostics);
  std::vector<HostStruct> result;
  std::set<std::string> done;
  const std::function<void(const std::string&)> add = [&](const std::string& name) {
    const auto found = structs.find(name);
    if (found == structs.end() || !done.insert(name).second) return;
    const auto& [layout, where, unit] = found->second;
    for (const StructMember& member : layout.members) {
      if (!member.structName.empty()) add(member.structName);
    }
    if (layout.isBlock && layout.size > kUniformBlockBytes) {
      diagnostics.error(where, "PK701",
                        fmt::format("'{}' has {} bytes, devices guarantee {} for a constant block: "
                                    "use a StructuredBuffer",
                                    name, layout.size, kUniformBlockBytes));
    }
    Diagnostics problems;
    std::optional<HostStruct> host = makeHostStruct(layout, where, problems);
    for (const Diagnostic& diagnostic : problems.items()) {
      // The source checks name the member's line, when they understand the source.
      if (diagnostic.code == "PK607" && unit->front.diagnostics.hasCode("PK125")) continue;
      if (diagnostic.code == "PK608" && unit->front.diagnostics.hasCode("PK124")) continue;
      diagnostics.add(diagnostic);
    }
    if (host) result.push_back(std::move(*host));
  };
  for (const auto& [name, found] : structs) add(name);
  return result;
}

std::vector<KernelOutput> collectKernels(const Manifest& manifest, const std::vector<Unit>& units,
                                         bool keepNames, LayoutPlan& plan,
                                         Diagnostics& diagnostics) {
  std::vector<KernelOutput> kernels;
  for (const ManifestKernel& kernel : manifest.kernels) {
    KernelOutput output;
    output.kernel = kernel;
    std::map<std::vector<uint32_t>, size_t> known;
    for (const Unit& unit : units) {
      if (unit.kernel != &kernel || !unit.reflection) continue;
      collectSpecConstants(unit, output.specConstants, diagnostics);
      if (kernel.stage == Stage::kVertex) collectInputs(unit, output, diagnostics);
      const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
      if (!module || unit.back.spirv.empty()) continue;
      const auto [found, added] = known.emplace(unit.back.spirv, output.variants.size());
      if (!added) {
        VariantOutput& same = output.variants[found->second];
        if (kernel.whyNotWebgpu(unit.permutation) == nullptr) same.noWebgpu.clear();
        same.permutations.push_back(unit.permutation);
        same.tier = std::min(same.tier, kernel.tierOf(unit.permutation));
        continue;
      }
      output.variants.push_back(makeVariant(unit, *module, keepNames, plan));
    }
    std::sort(output.specConstants.begin(), output.specConstants.end(),
              [](const SpecConstantInfo& a, const SpecConstantInfo& b) { return a.id < b.id; });
    kernels.push_back(std::move(output));
  }
  return kernels;
}

}  // namespace pelage::codegen
