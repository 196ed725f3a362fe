#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "codegen/enum_names.h"
#include "codegen/key_completion.h"
#include "codegen/program.h"

namespace pelage::codegen {
namespace {

using Json = nlohmann::ordered_json;

Json stages(StageMask mask) {
  Json list = Json::array();
  for (const Stage stage : {Stage::kCompute, Stage::kVertex, Stage::kPixel}) {
    if ((mask & stageBit(stage)) != 0) list.push_back(word(stage));
  }
  return list;
}

Json layoutJson(const PlannedLayout& layout) {
  Json entries = Json::array();
  for (const PlannedEntry& entry : layout.entries) {
    entries.push_back(
        {{"name", entry.name},
         {"struct", entry.structName},
         {"kind", word(entry.kind)},
         {"access", word(entry.access)},
         {"stages", stages(entry.stages)},
         {"stride", entry.stride},
         {"register", registerLetter(entry.registerClass) + std::to_string(entry.registerNumber)},
         {"binding", entry.binding},
         {"glBinding", entry.glBinding}});
  }
  return {{"name", layout.name},
          {"group", layout.group},
          {"set", layout.set},
          {"entries", std::move(entries)}};
}

Json structJson(const HostStruct& type) {
  Json members = Json::array();
  for (const HostField& field : type.fields) {
    Json member = {
        {"name", field.name}, {"type", field.type}, {"offset", field.offset}, {"size", field.size}};
    if (field.arraySize > 0) member["count"] = field.arraySize;
    if (field.isPadding) member["padding"] = true;
    members.push_back(std::move(member));
  }
  return {{"name", type.name}, {"size", type.size}, {"members", std::move(members)}};
}

// The conditions that complete each axis of a key; any one of them does.
Json completionJson(const ManifestKernel& kernel) {
  Json json = Json::object();
  for (const CompletionRule& rule : completeKeys(kernel).rules) {
    std::string conditions;
    for (const auto& [axis, value] : rule.conditions) {
      conditions +=
          fmt::format("{}{}={}", conditions.empty() ? "" : " ", kernel.axes[axis].name, value);
    }
    json[kernel.axes[rule.axis].name].push_back(conditions);
  }
  return json;
}

Json vertexInputJson(const KernelOutput& output) {
  const ManifestVertexInput& input = *output.kernel.vertexInput;
  Json attributes = Json::array();
  for (const StageInput& attribute : output.inputs) {
    attributes.push_back({{"location", attribute.location},
                          {"type", word(attribute.scalar)},
                          {"components", attribute.components},
                          {"offset", input.offsets[attribute.location]}});
  }
  return {{"step", input.perInstance ? "instance" : "vertex"},
          {"stride", input.stride},
          {"attributes", std::move(attributes)}};
}

Json slotJson(uint8_t slot) { return slot == MetalKernel::kNone ? Json() : Json(slot); }

Json metalJson(const KernelOutput& output, const VariantOutput& variant) {
  Json bindings = Json::array();
  for (const MetalBinding& binding : variant.msl.bindings) {
    constexpr const char* kTables[] = {"buffer", "texture", "sampler"};
    bindings.push_back({{"set", binding.set},
                        {"entry", binding.entry},
                        {"table", kTables[static_cast<size_t>(binding.table)]},
                        {"slot", binding.slot},
                        {"bytes", binding.bytes}});
  }
  return {{"file", mslFile(output, variant)},
          {"function", variant.msl.function},
          {"bindings", std::move(bindings)},
          {"vertexBuffer", slotJson(variant.msl.vertexBuffer)},
          {"sizes", slotJson(variant.msl.sizes)}};
}

Json hlslJson(const KernelOutput& output, const VariantOutput& variant) {
  Json registers = Json::array();
  for (const HlslRegister& r : variant.registers) {
    registers.push_back({{"name", r.name},
                         {"register", registerLetter(r.registerClass) + std::to_string(r.number)},
                         {"space", r.space}});
  }
  return {{"file", output.kernel.file},
          {"entry", output.kernel.name},
          {"profile", hlslProfile(output.kernel.stage)},
          {"defines", hlslDefines(output, variant)},
          {"registers", std::move(registers)}};
}

Json kernelJson(const KernelOutput& output, const Program& program) {
  const ManifestKernel& kernel = output.kernel;
  Json constants = Json::array();
  for (const SpecConstantInfo& constant : output.specConstants) {
    constants.push_back({{"name", constant.name},
                         {"id", constant.id},
                         {"type", word(constant.type)},
                         {"defaultBits", constant.defaultBits}});
  }
  Json variants = Json::array();
  for (const VariantOutput& variant : output.variants) {
    Json keys = Json::array();
    for (const Permutation& permutation : variant.permutations) {
      keys.push_back(permutationKey(kernel, permutation));
    }
    Json bindings = Json::array();
    for (const BindingUse& use : variant.bindings) {
      const std::string& layoutName = program.manifest.groups[kernel.group].layouts[use.set];
      std::string entryName;
      for (const PlannedLayout& layout : program.layouts) {
        if (layout.name == layoutName) entryName = layout.entries[use.entry].name;
      }
      bindings.push_back({{"set", use.set},
                          {"entry", use.entry},
                          {"name", entryName},
                          {"access", word(use.access)},
                          {"glBinding", use.glBinding}});
    }
    Json json = {{"keys", std::move(keys)},
                 {"tier", tierName(variant.tier)},
                 {"bindings", std::move(bindings)}};
    if (kernel.stage == Stage::kCompute) {
      json["groupSize"] = {variant.groupSize[0], variant.groupSize[1], variant.groupSize[2]};
      json["sharedBytes"] = variant.sharedBytes;
    }
    json["hash"] = fmt::format("{:016x}", variant.hash);
    if (!variant.noWebgpu.empty()) json["noWebgpu"] = variant.noWebgpu;
    if (program.msl) json["metal"] = metalJson(output, variant);
    if (program.hlsl) json["hlsl"] = hlslJson(output, variant);
    variants.push_back(std::move(json));
  }
  Json json = {
      {"name", kernel.name},         {"file", kernel.file},
      {"stage", word(kernel.stage)}, {"layouts", program.manifest.groups[kernel.group].layouts},
      {"precise", kernel.precise},   {"commutes", kernel.commutes}};
  if (kernel.vertexInput) json["vertexInput"] = vertexInputJson(output);
  json["specConstants"] = std::move(constants);
  json["completion"] = completionJson(kernel);
  json["variants"] = std::move(variants);
  return json;
}

}  // namespace

std::string emitReflection(const Program& program) {
  Json root = {{"namespace", program.manifest.namespaceName()}};
  root["layouts"] = Json::array();
  for (const PlannedLayout& layout : program.layouts) root["layouts"].push_back(layoutJson(layout));
  root["structs"] = Json::array();
  for (const HostStruct& type : program.structs) root["structs"].push_back(structJson(type));
  root["kernels"] = Json::array();
  for (const KernelOutput& kernel : program.kernels) {
    root["kernels"].push_back(kernelJson(kernel, program));
  }
  return root.dump(2) + "\n";
}

}  // namespace pelage::codegen
