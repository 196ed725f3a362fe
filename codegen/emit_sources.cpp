// The C++ that a manifest becomes.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <set>

#include "codegen/enum_names.h"
#include "codegen/key_completion.h"
#include "codegen/names.h"
#include "codegen/program.h"

namespace pelage::codegen {
namespace {

std::string hex64(uint64_t value) { return fmt::format("0x{:016x}ull", value); }

const char* specType(ScalarType type) {
  switch (type) {
    case ScalarType::kFloat:
      return "float";
    case ScalarType::kInt:
      return "int32_t";
    case ScalarType::kBool:
      return "bool";
    default:
      return "uint32_t";
  }
}

std::string specDefault(const SpecConstantInfo& constant) {
  switch (constant.type) {
    case ScalarType::kFloat:
      return fmt::format("std::bit_cast<float>(0x{:08x}u)", constant.defaultBits);
    case ScalarType::kInt:
      return std::to_string(std::bit_cast<int32_t>(constant.defaultBits));
    case ScalarType::kBool:
      return constant.defaultBits != 0 ? "true" : "false";
    default:
      return std::to_string(constant.defaultBits) + "u";
  }
}

std::string specBits(const SpecConstantInfo& constant) {
  const std::string name = hostName(constant.name);
  switch (constant.type) {
    case ScalarType::kBool:
      return name + " ? 1u : 0u";
    case ScalarType::kUint:
      return name;
    default:
      return "std::bit_cast<uint32_t>(" + name + ")";
  }
}

std::string openSpace(const CppNames& names) { return "namespace " + names.space + " {\n\n"; }
std::string closeSpace(const CppNames& names) { return "}  // namespace " + names.space + "\n"; }

std::string layoutsHeader(const Program& program, const CppNames& names) {
  std::string text = generatedHead(program, "The layouts: one table for each descriptor set.");
  text += "#pragma once\n\n#include <cstdint>\n#include <span>\n\n#include \"pelage/layout.h\"\n\n";
  text += openSpace(names);
  for (const PlannedLayout& layout : program.layouts) {
    text += fmt::format("/// Set {} of {}.\nextern const {}LayoutTable k{}Layout;\n\n", layout.set,
                        groupsOf(program, layout), names.prefix, layout.name);
    text += fmt::format("/// Indices into k{0}Layout.entries.\nstruct {0}Entry {{\n", layout.name);
    if (!layout.entries.empty()) {
      text += "  enum : uint8_t {\n";
      for (const PlannedEntry& entry : layout.entries) {
        text += fmt::format("    {},\n", hostName(entry.name));
      }
      text += "  };\n";
    }
    text += "};\n\n";
    text += fmt::format(
        "/// Passes k{0}Layout to an engine's layout manager and returns the result of\n"
        "/// `manager.createLayout(const pelage::LayoutTable&)`.\n"
        "template <class LayoutManager>\n"
        "decltype(auto) Create{0}Layout(LayoutManager&& manager) {{\n"
        "  return manager.createLayout(k{0}Layout);\n"
        "}}\n\n",
        layout.name);
  }
  text += fmt::format(
      "/// Returns all layouts, in the order of the manifest.\n"
      "std::span<const {}LayoutTable* const> allLayouts();\n\n",
      names.prefix);
  return text + closeSpace(names);
}

std::string layoutsSource(const Program& program, const CppNames& names) {
  std::string text = generatedHead(program, "The tables of layouts.h.");
  text += fmt::format("#include \"{}/layouts.h\"\n\n", names.folder);
  text += openSpace(names);
  text += "namespace {\n\n";
  for (const PlannedLayout& layout : program.layouts) {
    if (layout.entries.empty()) continue;
    text +=
        fmt::format("constinit const {}LayoutEntry k{}Entries[] = {{\n", names.prefix, layout.name);
    for (const PlannedEntry& entry : layout.entries) {
      text += fmt::format(
          "    {{\"{}\", \"{}\", {}ResourceKind::{},\n     {}Access::{}, {}, {}, {}, {}}},\n",
          entry.name, entry.structName, names.prefix, enumerator(entry.kind), names.prefix,
          enumerator(entry.access), static_cast<unsigned>(entry.stages), entry.stride,
          entry.binding, entry.glBinding);
    }
    text += "};\n\n";
  }
  text += "}  // namespace\n\n";
  std::string all;
  for (const PlannedLayout& layout : program.layouts) {
    text += fmt::format("constinit const {}LayoutTable k{}Layout{{\"{}\", \"{}\", {}, {}}};\n",
                        names.prefix, layout.name, layout.name, layout.group, layout.set,
                        layout.entries.empty() ? "{}" : "k" + layout.name + "Entries");
    all += fmt::format("      &k{}Layout,\n", layout.name);
  }
  text += "\n" + listFunction(names, "LayoutTable", "allLayouts", all);
  return text + closeSpace(names);
}

std::string structsHeader(const Program& program, const CppNames& names) {
  std::string text =
      generatedHead(program, "Structs and constant blocks as the kernels read them.");
  text +=
      "#pragma once\n\n#include <cstddef>\n#include <cstdint>\n#include <type_traits>\n\n"
      "#include \"pelage/types.h\"\n\n";
  text += openSpace(names);
  static const std::set<std::string> kPelageTypes = {"Float2", "Float3", "Float4",
                                                     "Uint2",  "Uint4",  "Int4"};
  for (const HostStruct& type : program.structs) {
    text += "struct " + type.name + " {\n";
    for (const HostField& field : type.fields) {
      const std::string cpp =
          kPelageTypes.contains(field.type) ? names.prefix + field.type : field.type;
      const std::string array =
          field.arraySize > 0 ? "[" + std::to_string(field.arraySize) + "]" : "";
      const bool isScalar = field.type == "float" || field.type.ends_with("_t");
      const char* value = !array.empty() ? " = {}" : isScalar ? " = 0" : "";
      text += fmt::format("  {} {}{}{};\n", cpp, field.name, array, value);
    }
    text += "};\n";
    text += fmt::format("static_assert(sizeof({}) == {});\n", type.name, type.size);
    for (const HostField& field : type.fields) {
      if (field.isPadding) continue;
      text += fmt::format("static_assert(offsetof({}, {}) == {});\n", type.name, field.name,
                          field.offset);
    }
    text += fmt::format("static_assert(std::is_trivially_copyable_v<{}>);\n\n", type.name);
  }
  return text + closeSpace(names);
}

std::string axisEnum(const ManifestKernel& kernel, const Axis& axis) {
  return pascalCase(kernel.name) + pascalCase(axis.name);
}

// How a value of an axis is written in C++.
std::string axisValue(const ManifestKernel& kernel, const Axis& axis, int32_t value) {
  if (axis.isBool) return value != 0 ? "true" : "false";
  return axisEnum(kernel, axis) + "::k" + std::to_string(value);
}

void keyTypes(const ManifestKernel& kernel, std::string& text) {
  const std::string name = pascalCase(kernel.name);
  for (const Axis& axis : kernel.axes) {
    if (axis.isBool) continue;
    text += fmt::format("enum class {} : int32_t {{\n", axisEnum(kernel, axis));
    for (const int32_t value : axis.values) text += fmt::format("  k{0} = {0},\n", value);
    text += "};\n\n";
  }
  text += fmt::format("/// The permutation axes of {}.\nstruct {}Key {{\n", kernel.name, name);
  for (const Axis& axis : kernel.axes) {
    text += fmt::format("  {} {} = {};\n", axis.isBool ? "bool" : axisEnum(kernel, axis), axis.name,
                        axisValue(kernel, axis, axis.values.front()));
  }
  text += fmt::format("  auto operator<=>(const {}Key&) const = default;\n}};\n\n", name);
}

// "key.wind && !key.dense && key.taps == KernelTaps::k4".
std::string keyHas(const ManifestKernel& kernel, const std::vector<AxisValue>& conditions) {
  std::string text;
  for (const auto& [index, value] : conditions) {
    const Axis& axis = kernel.axes[index];
    if (!text.empty()) text += " && ";
    text += axis.isBool ? (value != 0 ? "key." : "!key.") + axis.name
                        : "key." + axis.name + " == " + axisValue(kernel, axis, value);
  }
  return text;
}

std::string anyApplies(const ManifestKernel& kernel, const std::vector<CompletionRule>& rules,
                       uint32_t axis) {
  std::vector<std::string> conditions;
  for (const CompletionRule& rule : rules) {
    if (rule.axis == axis) conditions.push_back(keyHas(kernel, rule.conditions));
  }
  std::string text;
  for (const std::string& condition : conditions) {
    if (!text.empty()) text += " || ";
    const bool isProduct = conditions.size() > 1 && condition.find("&&") != std::string::npos;
    text += isProduct ? "(" + condition + ")" : condition;
  }
  return text;
}

void completionFunction(const ManifestKernel& kernel, std::string& text) {
  const std::string key = pascalCase(kernel.name) + "Key";
  text +=
      "/// Returns the smallest existing key with all features of this one: it also turns on the "
      "features\n/// that the manifest requires with them.\n";
  if (!kernel.conflicts.empty())
    text += "/// Keys with conflicting features have none: exists() is false for the result.\n";
  text += fmt::format("constexpr {0} completeKey(const {0}& key) {{\n  {0} complete = key;\n", key);
  const std::vector<CompletionRule> rules = completeKeys(kernel).rules;
  for (uint32_t axis = 0; axis < kernel.axes.size(); ++axis) {
    const std::string condition = anyApplies(kernel, rules, axis);
    if (condition.empty()) continue;
    text += fmt::format("  if ({}) complete.{} = true;\n", condition, kernel.axes[axis].name);
  }
  text += "  return complete;\n}\n\n";
}

// Permutations may have groups of different sizes: then there is no one size to name.
void groupSizeConstant(const KernelOutput& output, const CppNames& names, std::string& text) {
  if (output.kernel.stage != Stage::kCompute || output.variants.empty()) return;
  const auto& size = output.variants.front().groupSize;
  for (const VariantOutput& variant : output.variants) {
    if (!std::equal(std::begin(size), std::end(size), std::begin(variant.groupSize))) return;
  }
  text += fmt::format(
      "/// Threads of a group of {}.\ninline constexpr {}GroupSize k{}GroupSize = {{{}, {}, {}}};"
      "\n\n",
      output.kernel.name, names.prefix, pascalCase(output.kernel.name), size[0], size[1], size[2]);
}

void specializationStruct(const KernelOutput& output, const CppNames& names, std::string& text) {
  const std::string name = pascalCase(output.kernel.name);
  text += fmt::format("/// The specialization constants of {}.\nstruct {}Specialization {{\n",
                      output.kernel.name, name);
  std::string values;
  for (const SpecConstantInfo& constant : output.specConstants) {
    text += fmt::format("  {} {} = {};\n", specType(constant.type), hostName(constant.name),
                        specDefault(constant));
    values += fmt::format("        {}SpecValue{{{}, {}}},\n", names.prefix, constant.id,
                          specBits(constant));
  }
  text += fmt::format(
      "  /// For Pass::firstSpecValue: Vulkan and GL use the same values.\n"
      "  std::array<{}SpecValue, {}> values() const {{\n    return {{{{\n{}    }}}};\n  "
      "}}\n}};\n\n",
      names.prefix, output.specConstants.size(), values);
}

std::string kernelsHeader(const Program& program, const CppNames& names) {
  std::string text =
      generatedHead(program, "The kernels, with a typed key for the permutations of each.");
  text +=
      "#pragma once\n\n#include <array>\n#include <bit>\n#include <compare>\n#include <cstdint>\n"
      "#include <span>\n\n#include \"pelage/kernel.h\"\n\n";
  text += openSpace(names);
  for (const KernelOutput& output : program.kernels) {
    const ManifestKernel& kernel = output.kernel;
    const std::string name = pascalCase(kernel.name);
    const std::string function = camelCase(kernel.name) + "Variant";
    text += fmt::format("extern const {}Kernel k{}Kernel;\n\n", names.prefix, name);
    groupSizeConstant(output, names, text);
    keyTypes(kernel, text);
    if (kernel.excludes.empty()) {
      text += fmt::format("const {0}KernelVariant& {1}(const {2}Key& key{3});\n\n", names.prefix,
                          function, name, " = {}");
    } else {
      text += fmt::format(
          "/// Returns false for combinations that the manifest excludes.\n"
          "constexpr bool exists(const {}Key& key) {{\n  return !(",
          name);
      for (size_t i = 0; i < kernel.excludes.size(); ++i) {
        text += (i > 0 ? " || (" : "(") + keyHas(kernel, kernel.excludes[i]) + ")";
      }
      text += ");\n}\n\n";
      text += fmt::format(
          "/// Returns nullptr for an excluded key.\nconst {0}KernelVariant* {1}(const {2}Key& "
          "key);\n\n"
          "/// The same for a key that is known at compile time: an excluded key does not "
          "compile.\n"
          "template <{2}Key K>\n  requires(exists(K))\nconst {0}KernelVariant& {1}() {{\n"
          "  return *{1}(K);\n}}\n\n",
          names.prefix, function, name);
    }
    if (!kernel.axes.empty()) completionFunction(kernel, text);
    if (!output.specConstants.empty()) specializationStruct(output, names, text);
  }
  text += fmt::format(
      "/// Returns all kernels, in the order of the manifest.\n"
      "std::span<const {}Kernel* const> allKernels();\n\n",
      names.prefix);
  return text + closeSpace(names);
}

// Lists the resources of each distinct variant.
void variantBindings(const KernelOutput& output, const CppNames& names, std::string& out) {
  const std::string name = pascalCase(output.kernel.name);
  for (size_t v = 0; v < output.variants.size(); ++v) {
    const VariantOutput& variant = output.variants[v];
    if (variant.bindings.empty()) continue;
    out += fmt::format("constexpr {}VariantBinding k{}{}Bindings[] = {{\n", names.prefix, name, v);
    for (const BindingUse& use : variant.bindings) {
      out += fmt::format("    {{{}, {}, {}Access::{}, {}}},\n", use.set, use.entry, names.prefix,
                         enumerator(use.access), use.glBinding);
    }
    out += "};\n\n";
  }
}

void vertexInputTable(const KernelOutput& output, const CppNames& names, std::string& out) {
  const std::string name = pascalCase(output.kernel.name);
  const ManifestVertexInput& input = *output.kernel.vertexInput;
  out += fmt::format("constexpr {0}VertexAttribute k{1}Attributes[] = {{\n", names.prefix, name);
  for (const StageInput& attribute : output.inputs) {
    out += fmt::format("    {{{}, {}VertexFormat::k{}, {}}},\n", attribute.location, names.prefix,
                       vertexFormat(attribute), input.offsets[attribute.location]);
  }
  out += fmt::format(
      "}};\n\nconstexpr {0}VertexInput k{1}VertexInput = {{k{1}Attributes, {2}, {3}}};\n\n",
      names.prefix, name, input.stride, input.perInstance);
}

void variantTables(const KernelOutput& output, const CppNames& names, std::string& out) {
  const ManifestKernel& kernel = output.kernel;
  const std::string name = pascalCase(kernel.name);
  out += fmt::format("constinit const {0}KernelVariant k{1}Variants[] = {{\n", names.prefix, name);
  for (size_t v = 0; v < output.variants.size(); ++v) {
    const VariantOutput& variant = output.variants[v];
    const std::string stem = fmt::format("k{}{}", name, v);
    out +=
        fmt::format("    {{&k{}Kernel, \"{}\", {}, {{{}, {}, {}}}, {},\n     {}Tier::{}, {}}},\n",
                    name, permutationKey(kernel, variant.permutations.front()),
                    variant.bindings.empty() ? "{}" : stem + "Bindings", variant.groupSize[0],
                    variant.groupSize[1], variant.groupSize[2], hex64(variant.hash), names.prefix,
                    enumerator(variant.tier), variant.sharedBytes);
  }
  out += "};\n\n";
  out += fmt::format("constexpr const {0}KernelVariant* k{1}Distinct[] = {{\n", names.prefix, name);
  for (size_t v = 0; v < output.variants.size(); ++v) {
    out += fmt::format("    &k{}Variants[{}],\n", name, v);
  }
  out += "};\n\n";

  // By key: the last axis varies fastest.
  std::map<Permutation, size_t> index;
  for (size_t v = 0; v < output.variants.size(); ++v) {
    for (const Permutation& permutation : output.variants[v].permutations) index[permutation] = v;
  }
  ManifestKernel everything = kernel;
  everything.excludes.clear();
  out += fmt::format("constexpr const {0}KernelVariant* k{1}ByKey[] = {{\n", names.prefix, name);
  for (const Permutation& permutation : everything.permutations()) {
    const auto found = index.find(permutation);
    out += found == index.end() ? std::string("    nullptr,\n")
                                : fmt::format("    &k{}Variants[{}],\n", name, found->second);
  }
  out += "};\n\n";
}

void kernelTables(const KernelOutput& output, const Program& program, const CppNames& names,
                  std::string& out) {
  const ManifestKernel& kernel = output.kernel;
  const std::string name = pascalCase(kernel.name);
  const ManifestGroup& group = program.manifest.groups[kernel.group];
  out += fmt::format("constexpr const {0}LayoutTable* k{1}Layouts[] = {{\n", names.prefix, name);
  for (const std::string& layout : group.layouts) out += fmt::format("    &k{}Layout,\n", layout);
  out += "};\n\n";
  if (!output.specConstants.empty()) {
    out += fmt::format("constexpr {0}SpecConstant k{1}SpecConstants[] = {{\n", names.prefix, name);
    for (const SpecConstantInfo& constant : output.specConstants) {
      out += fmt::format("    {{\"{}\", {}, 0x{:x}}},\n", constant.name, constant.id,
                         constant.defaultBits);
    }
    out += "};\n\n";
  }
  if (kernel.vertexInput) vertexInputTable(output, names, out);
}

void kernelObject(const KernelOutput& output, const CppNames& names, std::string& out) {
  const ManifestKernel& kernel = output.kernel;
  const std::string name = pascalCase(kernel.name);
  out += fmt::format(
      "constinit const {0}Kernel k{1}Kernel{{\"{2}\", {0}Stage::{3}, k{1}Layouts,\n    {4}, "
      "k{1}Distinct, {5}, {6}}};\n\n",
      names.prefix, name, kernel.name, enumerator(kernel.stage),
      output.specConstants.empty() ? "{}" : "k" + name + "SpecConstants",
      kernel.vertexInput ? "&k" + name + "VertexInput" : "nullptr", kernel.commutes);
}

void variantFunction(const ManifestKernel& kernel, const CppNames& names, std::string& out) {
  const std::string name = pascalCase(kernel.name);
  const bool optional = !kernel.excludes.empty();
  out += fmt::format("const {}KernelVariant{} {}Variant(const {}Key&{}) {{\n", names.prefix,
                     optional ? "*" : "&", camelCase(kernel.name), name,
                     kernel.axes.empty() ? "" : " key");
  out += "  size_t index = 0;\n";
  for (const Axis& axis : kernel.axes) {
    if (axis.isBool) {
      out += fmt::format("  index = index * 2 + (key.{} ? 1 : 0);\n", axis.name);
      continue;
    }
    out += fmt::format("  index *= {};\n  switch (key.{}) {{\n", axis.values.size(), axis.name);
    for (size_t i = 0; i < axis.values.size(); ++i) {
      out += fmt::format("    case {}:\n", axisValue(kernel, axis, axis.values[i]));
      if (i > 0) out += fmt::format("      index += {};\n", i);
      out += "      break;\n";
    }
    // Only a cast can make another value.
    out += "    default:\n      std::abort();\n  }\n";
  }
  out += fmt::format("  return {}k{}ByKey[index];\n}}\n\n", optional ? "" : "*", name);
}

std::string kernelsSource(const Program& program, const CppNames& names) {
  std::string out = generatedHead(program, "The tables of kernels.h.");
  out += fmt::format(
      "#include \"{}/kernels.h\"\n\n#include <cstdlib>\n\n#include \"{}/layouts.h\"\n\n",
      names.folder, names.folder);
  out += openSpace(names);
  out += "namespace {\n\n";
  for (const KernelOutput& output : program.kernels) variantBindings(output, names, out);
  out += "}  // namespace\n\n";
  std::string all;
  for (const KernelOutput& output : program.kernels) {
    out += "namespace {\n\n";
    variantTables(output, names, out);
    kernelTables(output, program, names, out);
    out += "}  // namespace\n\n";
    kernelObject(output, names, out);
    variantFunction(output.kernel, names, out);
    all += fmt::format("      &k{}Kernel,\n", pascalCase(output.kernel.name));
  }
  return out + listFunction(names, "Kernel", "allKernels", all) + closeSpace(names);
}

}  // namespace

std::string generatedHead(const Program& program, const std::string& what) {
  return "// " + what + "\n// Made by pelage-codegen from " + program.manifest.file +
         ". Edits are lost.\n";
}

std::string vertexFormat(const StageInput& input) {
  return (input.scalar == ScalarType::kUint ? "Uint" : "Float") + std::to_string(input.components);
}

std::string groupsOf(const Program& program, const PlannedLayout& layout) {
  std::string names;
  size_t count = 0;
  for (const ManifestGroup& group : program.manifest.groups) {
    if (std::find(group.layouts.begin(), group.layouts.end(), layout.name) == group.layouts.end())
      continue;
    names += (count++ > 0 ? ", \"" : "\"") + group.name + "\"";
  }
  return (count > 1 ? "groups " : "group ") + names;
}

CppNames cppNames(const Manifest& manifest) {
  const std::string space = manifest.namespaceName();
  return {space, manifest.namespaceFolder(), space == "pelage" ? "" : "::pelage::"};
}

std::string listFunction(const CppNames& names, const std::string& type, const std::string& name,
                         const std::string& items, const std::string& result) {
  std::string text = (result.empty() ? "std::span<const " + names.prefix + type + "* const>"
                                     : names.prefix + result) +
                     " " + name + "() {\n";
  text += items.empty() ? "  return {};\n"
                        : fmt::format(
                              "  static constexpr const {}{}* kAll[] = {{\n{}  }};\n"
                              "  return kAll;\n",
                              names.prefix, type, items);
  return text + "}\n\n";
}

std::map<std::string, std::string> emitSources(const Program& program) {
  const CppNames names = cppNames(program.manifest);
  const std::string folder = "include/" + names.folder;
  return {{folder + "/layouts.h", layoutsHeader(program, names)},
          {folder + "/kernels.h", kernelsHeader(program, names)},
          {folder + "/gpu_structs.h", structsHeader(program, names)},
          {folder + "/constants.h", constantsHeader(program)},
          {folder + "/bindings.h", bindingsHeader(program)},
          {"layouts.cpp", layoutsSource(program, names)},
          {"kernels.cpp", kernelsSource(program, names)}};
}

}  // namespace pelage::codegen
