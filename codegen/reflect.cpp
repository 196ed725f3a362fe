#include "codegen/reflect.h"

#include <algorithm>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_set>

#include "codegen/enum_names.h"
#include "codegen/front_end.h"

namespace pelage::codegen {
namespace {

uint32_t roundUp(uint32_t value, uint32_t alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

ScalarType scalarType(const SpirvInstruction& type) {
  switch (type.op) {
    case SpvOpTypeFloat:
      return type.operands[0] == 32 ? ScalarType::kFloat : ScalarType::kOther;
    case SpvOpTypeInt:
      if (type.operands[0] != 32) return ScalarType::kOther;
      return type.operands[1] != 0 ? ScalarType::kInt : ScalarType::kUint;
    case SpvOpTypeBool:
      return ScalarType::kBool;
    default:
      return ScalarType::kOther;
  }
}

bool isResourceStorage(uint32_t storage) {
  switch (static_cast<SpvStorageClass>(storage)) {
    case SpvStorageClassUniform:
    case SpvStorageClassStorageBuffer:
    case SpvStorageClassUniformConstant:
      return true;
    default:
      return false;
  }
}

// Sizes and alignments with std430's rules, for groupshared memory and tails of structs.
uint32_t alignmentOf(const SpirvReader& module, uint32_t typeId);

uint32_t sizeOf(const SpirvReader& module, uint32_t typeId) {
  const SpirvInstruction& t = *module.definition(typeId);
  const auto padded = [&](uint32_t id) {
    return roundUp(sizeOf(module, id), alignmentOf(module, id));
  };
  switch (t.op) {
    case SpvOpTypeVector:
      return t.operands[1] * sizeOf(module, t.operands[0]);
    case SpvOpTypeMatrix:
      return t.operands[1] * padded(t.operands[0]);
    case SpvOpTypeArray:
      return module.constant(t.operands[1]).value_or(0) * padded(t.operands[0]);
    case SpvOpTypeStruct: {
      uint32_t end = 0;
      for (const uint32_t member : t.operands)
        end = roundUp(end, alignmentOf(module, member)) + sizeOf(module, member);
      return roundUp(end, alignmentOf(module, typeId));
    }
    case SpvOpTypeFloat:
    case SpvOpTypeInt:
      return t.operands[0] / 8;
    default:
      return 4;
  }
}

uint32_t alignmentOf(const SpirvReader& module, uint32_t typeId) {
  const SpirvInstruction& t = *module.definition(typeId);
  switch (t.op) {
    case SpvOpTypeVector:
      return sizeOf(module, t.operands[0]) * (t.operands[1] == 3 ? 4 : t.operands[1]);
    case SpvOpTypeMatrix:
    case SpvOpTypeArray:
      return alignmentOf(module, t.operands[0]);
    case SpvOpTypeStruct: {
      uint32_t largest = 4;
      for (const uint32_t member : t.operands)
        largest = std::max(largest, alignmentOf(module, member));
      return largest;
    }
    default:
      return std::max(sizeOf(module, typeId), 4u);
  }
}

// The ids that functions called from the entry point mention.
std::unordered_set<uint32_t> reachableIds(const SpirvReader& module) {
  std::map<uint32_t, std::vector<const SpirvInstruction*>> bodies;
  uint32_t current = 0;
  for (const SpirvInstruction& instruction : module.instructions()) {
    if (instruction.op == SpvOpFunction) current = instruction.result;
    if (current != 0) bodies[current].push_back(&instruction);
    if (instruction.op == SpvOpFunctionEnd) current = 0;
  }
  std::vector<uint32_t> pending;
  if (module.entryPoint()) pending.push_back(*module.entryPoint());
  std::set<uint32_t> seen;
  std::unordered_set<uint32_t> reachable;
  while (!pending.empty()) {
    const uint32_t function = pending.back();
    pending.pop_back();
    if (!seen.insert(function).second) continue;
    for (const SpirvInstruction* instruction : bodies[function]) {
      // Operands that are literals may add a wrong id. That would at worst keep a resource which
      // the front end declared and nothing uses, and it declares only what is used.
      reachable.insert(instruction->operands.begin(), instruction->operands.end());
      if (instruction->op == SpvOpFunctionCall) pending.push_back(instruction->operands[0]);
    }
  }
  return reachable;
}

// Name of a texture's type in HLSL.
std::string textureName(const SpirvInstruction& image, bool isStorage) {
  std::string name = isStorage ? "RWTexture" : "Texture";
  switch (static_cast<SpvDim>(image.operands[1])) {
    case SpvDim1D:
      name += "1D";
      break;
    case SpvDim3D:
      name += "3D";
      break;
    case SpvDimCube:
      name += "Cube";
      break;
    case SpvDimBuffer:
      name = isStorage ? "RWBuffer" : "Buffer";
      break;
    default:
      name += "2D";
      break;
  }
  if (image.operands[4] != 0) name += "MS";
  if (image.operands[3] != 0) name += "Array";
  return name;
}

void setRegister(const SpirvReader& module, Resource& resource) {
  const uint32_t binding = module.decoration(resource.id, SpvDecorationBinding).value_or(0);
  resource.space = module.decoration(resource.id, SpvDecorationDescriptorSet).value_or(0);
  for (const auto& [registerClass, base] :
       {std::pair(RegisterClass::kUniform, RegisterBase::kUniform),
        std::pair(RegisterClass::kTexture, RegisterBase::kTexture),
        std::pair(RegisterClass::kUav, RegisterBase::kUav),
        std::pair(RegisterClass::kSampler, RegisterBase::kSampler)}) {
    if (binding < base) break;
    resource.registerClass = registerClass;
    resource.registerNumber = binding - base;
    resource.hasRegister = true;
  }
}

std::optional<StageInput> stageInput(const SpirvReader& module, uint32_t id, uint32_t typeId) {
  const std::optional<uint32_t> location = module.decoration(id, SpvDecorationLocation);
  const SpirvInstruction* object = module.definition(typeId);
  if (!location || object == nullptr) return std::nullopt;
  StageInput input;
  input.location = *location;
  input.name = module.name(id);
  if (object->op == SpvOpTypeVector) {
    input.components = object->operands[1];
    object = module.definition(object->operands[0]);
  }
  input.scalar = scalarType(*object);
  return input;
}

std::optional<SpecConstantInfo> specConstant(const SpirvReader& module,
                                             const SpirvInstruction& instruction) {
  const std::optional<uint32_t> id = module.decoration(instruction.result, SpvDecorationSpecId);
  if (!id) return std::nullopt;
  SpecConstantInfo info;
  info.id = *id;
  info.name = module.name(instruction.result);
  info.type = scalarType(*module.definition(instruction.resultType));
  info.defaultBits = module.constant(instruction.result).value_or(0);
  return info;
}

// Collects resources, and the layouts of their structs.
class ResourceReader {
 public:
  ResourceReader(const SpirvReader& module, ModuleReflection& output)
      : module_(module), output_(output) {}

  void read(uint32_t id, SpvStorageClass storage, uint32_t typeId) {
    Resource resource;
    resource.id = id;
    const SpirvInstruction* object = type(typeId);
    while (object != nullptr &&
           (object->op == SpvOpTypeArray || object->op == SpvOpTypeRuntimeArray)) {
      resource.isArray = true;
      typeId = object->operands[0];
      object = type(typeId);
    }
    if (object == nullptr) return;
    resource.name = module_.name(id);
    if (resource.name.empty()) resource.name = module_.name(typeId);
    switch (object->op) {
      case SpvOpTypeStruct:
        readBuffer(typeId, storage, resource);
        break;
      case SpvOpTypeImage:
      case SpvOpTypeSampledImage: {
        const bool sampled = object->op == SpvOpTypeSampledImage;
        const SpirvInstruction& image = sampled ? *type(object->operands[0]) : *object;
        const bool isStorage = image.operands[5] == 2;
        resource.kind = isStorage ? ResourceKind::kStorageTexture : ResourceKind::kSampledTexture;
        resource.structName = textureName(image, isStorage);
        break;
      }
      case SpvOpTypeSampler:
        resource.kind = ResourceKind::kSampler;
        resource.structName = "SamplerState";
        break;
      default:
        return;
    }
    setRegister(module_, resource);
    output_.resources.push_back(std::move(resource));
  }

 private:
  const SpirvInstruction* type(uint32_t id) const { return module_.definition(id); }

  void readBuffer(uint32_t typeId, SpvStorageClass storage, Resource& resource) {
    const bool isStorage = storage == SpvStorageClassStorageBuffer ||
                           module_.decoration(typeId, SpvDecorationBufferBlock).has_value();
    resource.kind = isStorage ? ResourceKind::kStorageBuffer : ResourceKind::kUniformBuffer;
    const SpirvInstruction& block = *type(typeId);
    if (!isStorage) {
      resource.structName = module_.name(typeId);
      StructLayout layout = structLayout(typeId, true);
      layout.size = roundUp(std::max(layout.size, 16u), 16);
      resource.stride = layout.size;
      addStruct(std::move(layout));
      return;
    }
    // A structured buffer is a block with one runtime array.
    const uint32_t last = block.operands.empty() ? 0 : block.operands.back();
    const SpirvInstruction* array = type(last);
    if (array == nullptr || array->op != SpvOpTypeRuntimeArray) {
      resource.structName = module_.name(typeId);
      return;
    }
    resource.stride = module_.decoration(last, SpvDecorationArrayStride).value_or(0);
    const uint32_t elementId = array->operands[0];
    const SpirvInstruction* element = type(elementId);
    if (element->op == SpvOpTypeStruct) {
      resource.structName = module_.name(elementId);
      StructLayout layout = structLayout(elementId, false);
      layout.size = resource.stride;
      addStruct(std::move(layout));
    } else if (element->op == SpvOpTypeVector) {
      resource.structName =
          word(scalarType(*type(element->operands[0]))) + std::to_string(element->operands[1]);
    } else {
      resource.structName = word(scalarType(*element));
    }
  }

  void addStruct(StructLayout layout) {
    const auto [found, added] = output_.structs.emplace(layout.name, layout);
    if (added) return;
    // The same element type in two buffers: same offsets. Nested, it has no stride of its own.
    if (found->second != layout) output_.structConflicts.push_back(layout.name);
  }

  StructLayout structLayout(uint32_t typeId, bool isBlock) {
    StructLayout layout;
    layout.name = module_.name(typeId);
    layout.isBlock = isBlock;
    const SpirvInstruction& structType = *type(typeId);
    uint32_t end = 0;
    for (uint32_t i = 0; i < structType.operands.size(); ++i) {
      StructMember member;
      member.name = module_.memberName(typeId, i);
      member.offset = module_.memberDecoration(typeId, i, SpvDecorationOffset).value_or(end);
      const uint32_t memberType = structType.operands[i];
      describe(memberType, member, isBlock);
      end = std::max(end, member.offset + memberBytes(memberType, member));
      layout.members.push_back(std::move(member));
    }
    layout.size = end;
    return layout;
  }

  void describe(uint32_t typeId, StructMember& member, bool inBlock) {
    const SpirvInstruction* t = type(typeId);
    if (t->op == SpvOpTypeArray) {
      member.arraySize = module_.constant(t->operands[1]).value_or(0);
      member.arrayStride = module_.decoration(typeId, SpvDecorationArrayStride).value_or(0);
      t = type(t->operands[0]);
      if (t->op == SpvOpTypeArray) {
        member.nestedArray = true;
        return;
      }
      typeId = module_.definition(typeId)->operands[0];
    }
    if (t->op == SpvOpTypeMatrix) {
      member.columns = t->operands[1];
      t = type(t->operands[0]);
    }
    if (t->op == SpvOpTypeVector) {
      member.components = t->operands[1];
      t = type(t->operands[0]);
    }
    member.scalar = scalarType(*t);
    if (t->op == SpvOpTypeStruct) {
      member.structName = module_.name(typeId);
      StructLayout nested = structLayout(typeId, false);
      nested.size = member.arrayStride != 0
                        ? member.arrayStride
                        : roundUp(nested.size, inBlock ? 16 : alignmentOf(module_, typeId));
      addStruct(std::move(nested));
    }
  }

  uint32_t memberBytes(uint32_t typeId, const StructMember& member) {
    if (member.arraySize > 0) return member.arraySize * member.arrayStride;
    if (!member.structName.empty()) return output_.structs.at(member.structName).size;
    return sizeOf(module_, typeId);
  }

  const SpirvReader& module_;
  ModuleReflection& output_;
};

void readVariable(const SpirvReader& module, const SpirvInstruction& instruction,
                  const std::unordered_set<uint32_t>& reachable, ModuleReflection& output) {
  const auto storage = static_cast<SpvStorageClass>(instruction.operands[0]);
  const SpirvInstruction* pointer = module.definition(instruction.resultType);
  if (pointer == nullptr || pointer->op != SpvOpTypePointer) return;
  const uint32_t typeId = pointer->operands[1];
  if (storage == SpvStorageClassWorkgroup) {
    output.sharedBytes =
        roundUp(output.sharedBytes, alignmentOf(module, typeId)) + sizeOf(module, typeId);
  } else if (storage == SpvStorageClassInput) {
    if (const auto input = stageInput(module, instruction.result, typeId))
      output.inputs.push_back(*input);
  } else if (isResourceStorage(storage) && reachable.contains(instruction.result)) {
    ResourceReader(module, output).read(instruction.result, storage, typeId);
  }
}

// A value that names a texture or sampler instead of holding its content.
bool isHandle(const SpirvReader& module, uint32_t typeId) {
  const SpirvInstruction* type = module.definition(typeId);
  return type != nullptr && (type->op == SpvOpTypeImage || type->op == SpvOpTypeSampler ||
                             type->op == SpvOpTypeSampledImage);
}

}  // namespace

char registerLetter(RegisterClass registerClass) {
  return "btus"[static_cast<size_t>(registerClass)];
}

ModuleReflection reflectModule(const SpirvReader& module) {
  ModuleReflection output;
  const std::unordered_set<uint32_t> reachable = reachableIds(module);
  for (const SpirvInstruction& instruction : module.instructions()) {
    switch (instruction.op) {
      case SpvOpVariable:
        readVariable(module, instruction, reachable, output);
        break;
      case SpvOpExecutionMode:
        if (instruction.operands.size() == 5 &&
            instruction.operands[1] == static_cast<uint32_t>(SpvExecutionModeLocalSize)) {
          std::copy_n(instruction.operands.begin() + 2, 3, output.groupSize);
        }
        break;
      case SpvOpSpecConstant:
      case SpvOpSpecConstantTrue:
      case SpvOpSpecConstantFalse:
        if (const auto constant = specConstant(module, instruction))
          output.specConstants.push_back(*constant);
        break;
      default:
        break;
    }
  }
  std::sort(output.resources.begin(), output.resources.end(),
            [](const Resource& a, const Resource& b) {
              return std::tie(a.space, a.registerClass, a.registerNumber, a.name) <
                     std::tie(b.space, b.registerClass, b.registerNumber, b.name);
            });
  std::sort(output.inputs.begin(), output.inputs.end(),
            [](const StageInput& a, const StageInput& b) { return a.location < b.location; });
  std::sort(output.specConstants.begin(), output.specConstants.end(),
            [](const SpecConstantInfo& a, const SpecConstantInfo& b) { return a.id < b.id; });
  return output;
}

using Origins = std::map<uint32_t, std::set<uint32_t>>;

// The variables that an id may refer to: the variable itself, pointers into it, images loaded from
// it. Parameters collect those of their callers, so it iterates until nothing changes.
Origins originsOf(const SpirvReader& module) {
  Origins origins;
  std::map<uint32_t, std::vector<uint32_t>> parameters;
  uint32_t function = 0;
  for (const SpirvInstruction& instruction : module.instructions()) {
    if (instruction.op == SpvOpFunction) function = instruction.result;
    if (instruction.op == SpvOpFunctionParameter)
      parameters[function].push_back(instruction.result);
    if (instruction.op == SpvOpVariable && isResourceStorage(instruction.operands[0])) {
      origins[instruction.result] = {instruction.result};
    }
  }
  bool changed = true;
  const auto flow = [&](uint32_t from, uint32_t to) {
    const auto found = origins.find(from);
    if (found == origins.end()) return;
    const std::set<uint32_t> source = found->second;
    std::set<uint32_t>& target = origins[to];
    const size_t before = target.size();
    target.insert(source.begin(), source.end());
    changed |= target.size() != before;
  };
  while (changed) {
    changed = false;
    for (const SpirvInstruction& instruction : module.instructions()) {
      switch (instruction.op) {
        case SpvOpAccessChain:
        case SpvOpInBoundsAccessChain:
        case SpvOpPtrAccessChain:
        case SpvOpInBoundsPtrAccessChain:
        case SpvOpCopyObject:
        case SpvOpImageTexelPointer:
        case SpvOpImage:
          flow(instruction.operands[0], instruction.result);
          break;
        case SpvOpLoad:
          // Loading an image or a sampler touches nothing yet; loading anything else is a read.
          if (isHandle(module, instruction.resultType)) {
            flow(instruction.operands[0], instruction.result);
          }
          break;
        case SpvOpSampledImage:
        case SpvOpSelect:
        case SpvOpPhi:
          for (const uint32_t operand : instruction.operands) flow(operand, instruction.result);
          break;
        case SpvOpFunctionCall: {
          const std::vector<uint32_t>& formal = parameters[instruction.operands[0]];
          for (size_t i = 0; i < formal.size() && i + 1 < instruction.operands.size(); ++i) {
            flow(instruction.operands[i + 1], formal[i]);
          }
          break;
        }
        default:
          break;
      }
    }
  }
  return origins;
}

// How an instruction accesses what its first operand refers to.
Access accessOfFirstOperand(SpvOp op) {
  switch (op) {
    case SpvOpStore:
    case SpvOpAtomicStore:
    case SpvOpCopyMemory:
    case SpvOpImageWrite:
      return Access::kWrite;
    case SpvOpAtomicExchange:
    case SpvOpAtomicCompareExchange:
    case SpvOpAtomicIIncrement:
    case SpvOpAtomicIDecrement:
    case SpvOpAtomicIAdd:
    case SpvOpAtomicISub:
    case SpvOpAtomicSMin:
    case SpvOpAtomicUMin:
    case SpvOpAtomicSMax:
    case SpvOpAtomicUMax:
    case SpvOpAtomicAnd:
    case SpvOpAtomicOr:
    case SpvOpAtomicXor:
      return Access::kReadWrite;
    case SpvOpLoad:
    case SpvOpAtomicLoad:
    case SpvOpArrayLength:
    case SpvOpSampledImage:
    case SpvOpImageRead:
    case SpvOpImageFetch:
    case SpvOpImageGather:
    case SpvOpImageDrefGather:
    case SpvOpImageSampleImplicitLod:
    case SpvOpImageSampleExplicitLod:
    case SpvOpImageSampleDrefImplicitLod:
    case SpvOpImageSampleDrefExplicitLod:
    case SpvOpImageQuerySizeLod:
    case SpvOpImageQuerySize:
    case SpvOpImageQueryLevels:
    case SpvOpImageQuerySamples:
    case SpvOpImageQueryLod:
      return Access::kRead;
    default:
      return Access::kNone;
  }
}

std::map<uint32_t, Access> resourceAccess(const SpirvReader& module) {
  const Origins origins = originsOf(module);
  std::map<uint32_t, Access> accesses;
  const auto touch = [&](uint32_t id, Access access) {
    const auto found = origins.find(id);
    if (found == origins.end()) return;
    for (const uint32_t variable : found->second) {
      accesses[variable] = accesses[variable] | access;
    }
  };
  for (const SpirvInstruction& instruction : module.instructions()) {
    const std::span<const uint32_t> operands = instruction.operands;
    const Access access = accessOfFirstOperand(instruction.op);
    if (access == Access::kNone) continue;
    // Loading an image or a sampler touches nothing yet.
    if (instruction.op == SpvOpLoad && isHandle(module, instruction.resultType)) continue;
    touch(operands[0], access);
    if (instruction.op == SpvOpCopyMemory || instruction.op == SpvOpSampledImage)
      touch(operands[1], Access::kRead);
  }
  return accesses;
}

std::map<std::pair<uint32_t, uint32_t>, uint32_t> storageBufferNumbers(const SpirvReader& module,
                                                                       uint32_t first) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> numbers;
  for (const SpirvInstruction& instruction : module.instructions()) {
    if (instruction.op != SpvOpVariable || instruction.operands[0] != SpvStorageClassStorageBuffer)
      continue;
    const uint32_t id = instruction.result;
    numbers[{module.decoration(id, SpvDecorationDescriptorSet).value_or(0),
             module.decoration(id, SpvDecorationBinding).value_or(0)}] = 0;
  }
  for (auto& [slot, number] : numbers) number = first++;
  return numbers;
}

}  // namespace pelage::codegen
