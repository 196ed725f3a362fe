#include "codegen/reflect.h"

#include <algorithm>
#include <set>
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

class Reflector {
 public:
  explicit Reflector(const SpirvReader& module) : module_(module) {}

  ModuleReflection run() {
    findReachable();
    for (const SpirvInstruction& instruction : module_.instructions()) {
      switch (instruction.op) {
        case SpvOpVariable:
          variable(instruction);
          break;
        case SpvOpExecutionMode:
          if (instruction.operands.size() == 5 &&
              instruction.operands[1] == static_cast<uint32_t>(SpvExecutionModeLocalSize)) {
            std::copy_n(instruction.operands.begin() + 2, 3, output_.groupSize);
          }
          break;
        case SpvOpSpecConstant:
        case SpvOpSpecConstantTrue:
        case SpvOpSpecConstantFalse:
          specConstant(instruction);
          break;
        default:
          break;
      }
    }
    std::sort(output_.resources.begin(), output_.resources.end(),
              [](const Resource& a, const Resource& b) {
                return std::tie(a.space, a.registerClass, a.registerNumber, a.name) <
                       std::tie(b.space, b.registerClass, b.registerNumber, b.name);
              });
    std::sort(output_.inputs.begin(), output_.inputs.end(),
              [](const StageInput& a, const StageInput& b) { return a.location < b.location; });
    std::sort(output_.specConstants.begin(), output_.specConstants.end(),
              [](const SpecConstantInfo& a, const SpecConstantInfo& b) { return a.id < b.id; });
    return std::move(output_);
  }

 private:
  const SpirvInstruction* type(uint32_t id) const { return module_.definition(id); }

  // Marks the ids that functions called from the entry point mention.
  void findReachable() {
    std::map<uint32_t, std::vector<const SpirvInstruction*>> bodies;
    uint32_t current = 0;
    for (const SpirvInstruction& instruction : module_.instructions()) {
      if (instruction.op == SpvOpFunction) current = instruction.result;
      if (current != 0) bodies[current].push_back(&instruction);
      if (instruction.op == SpvOpFunctionEnd) current = 0;
    }
    std::vector<uint32_t> pending;
    if (module_.entryPoint()) pending.push_back(*module_.entryPoint());
    std::set<uint32_t> seen;
    while (!pending.empty()) {
      const uint32_t function = pending.back();
      pending.pop_back();
      if (!seen.insert(function).second) continue;
      for (const SpirvInstruction* instruction : bodies[function]) {
        // Operands that are literals may add a wrong id. That would at worst keep a resource which
        // the front end declared and nothing uses, and it declares only what is used.
        reachable_.insert(instruction->operands.begin(), instruction->operands.end());
        if (instruction->op == SpvOpFunctionCall) pending.push_back(instruction->operands[0]);
        if (instruction->op == SpvOpStore || instruction->op == SpvOpImageWrite ||
            instruction->op == SpvOpFunctionCall || instruction->op == SpvOpKill) {
          output_.hasBody = true;
        }
      }
    }
  }

  void variable(const SpirvInstruction& instruction) {
    const auto storage = static_cast<SpvStorageClass>(instruction.operands[0]);
    const SpirvInstruction* pointer = type(instruction.resultType);
    if (pointer == nullptr || pointer->op != SpvOpTypePointer) return;
    uint32_t typeId = pointer->operands[1];
    if (storage == SpvStorageClassWorkgroup) {
      output_.sharedBytes = roundUp(output_.sharedBytes, alignment(typeId)) + size(typeId);
      return;
    }
    if (storage == SpvStorageClassInput) {
      input(instruction.result, typeId);
      return;
    }
    if (storage != SpvStorageClassUniform && storage != SpvStorageClassStorageBuffer &&
        storage != SpvStorageClassUniformConstant) {
      return;
    }
    if (!reachable_.contains(instruction.result)) return;

    Resource resource;
    resource.id = instruction.result;
    const SpirvInstruction* object = type(typeId);
    while (object != nullptr &&
           (object->op == SpvOpTypeArray || object->op == SpvOpTypeRuntimeArray)) {
      resource.isArray = true;
      typeId = object->operands[0];
      object = type(typeId);
    }
    if (object == nullptr) return;
    resource.name = module_.name(instruction.result);
    if (resource.name.empty()) resource.name = module_.name(typeId);
    switch (object->op) {
      case SpvOpTypeStruct:
        buffer(typeId, storage, resource);
        break;
      case SpvOpTypeImage:
      case SpvOpTypeSampledImage:
        texture(*object, resource);
        break;
      case SpvOpTypeSampler:
        resource.kind = ResourceKind::kSampler;
        resource.structName = "SamplerState";
        break;
      default:
        return;
    }
    slot(instruction.result, resource);
    output_.resources.push_back(std::move(resource));
  }

  void input(uint32_t id, uint32_t typeId) {
    const std::optional<uint32_t> location = module_.decoration(id, SpvDecorationLocation);
    const SpirvInstruction* object = type(typeId);
    if (!location || object == nullptr) return;
    StageInput input;
    input.location = *location;
    input.name = module_.name(id);
    if (object->op == SpvOpTypeVector) {
      input.components = object->operands[1];
      object = type(object->operands[0]);
    }
    input.scalar = scalarType(*object);
    output_.inputs.push_back(std::move(input));
  }

  void buffer(uint32_t typeId, SpvStorageClass storage, Resource& resource) {
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

  void texture(const SpirvInstruction& object, Resource& resource) {
    const SpirvInstruction& image =
        object.op == SpvOpTypeSampledImage ? *type(object.operands[0]) : object;
    const bool isStorage = image.operands[5] == 2;
    resource.kind = isStorage ? ResourceKind::kStorageTexture : ResourceKind::kSampledTexture;
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
    resource.structName = name;
  }

  void slot(uint32_t id, Resource& resource) {
    const uint32_t binding = module_.decoration(id, SpvDecorationBinding).value_or(0);
    resource.space = module_.decoration(id, SpvDecorationDescriptorSet).value_or(0);
    const auto take = [&](RegisterClass registerClass, uint32_t base) {
      resource.registerClass = registerClass;
      resource.registerNumber = binding - base;
      resource.hasRegister = true;
    };
    if (binding >= RegisterBase::kSampler) {
      take(RegisterClass::kSampler, RegisterBase::kSampler);
    } else if (binding >= RegisterBase::kUav) {
      take(RegisterClass::kUav, RegisterBase::kUav);
    } else if (binding >= RegisterBase::kTexture) {
      take(RegisterClass::kTexture, RegisterBase::kTexture);
    } else if (binding >= RegisterBase::kUniform) {
      take(RegisterClass::kUniform, RegisterBase::kUniform);
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
                        : roundUp(nested.size, inBlock ? 16 : alignment(typeId));
      addStruct(std::move(nested));
    }
  }

  uint32_t memberBytes(uint32_t typeId, const StructMember& member) {
    if (member.arraySize > 0) return member.arraySize * member.arrayStride;
    if (!member.structName.empty()) return output_.structs.at(member.structName).size;
    return size(typeId);
  }

  // Sizes and alignments with std430's rules, for groupshared memory and tails of structs.
  uint32_t size(uint32_t typeId) {
    const SpirvInstruction& t = *type(typeId);
    switch (t.op) {
      case SpvOpTypeVector:
        return t.operands[1] * size(t.operands[0]);
      case SpvOpTypeMatrix:
        return t.operands[1] * roundUp(size(t.operands[0]), alignment(t.operands[0]));
      case SpvOpTypeArray:
        return module_.constant(t.operands[1]).value_or(0) *
               roundUp(size(t.operands[0]), alignment(t.operands[0]));
      case SpvOpTypeStruct: {
        uint32_t end = 0;
        for (const uint32_t member : t.operands) {
          end = roundUp(end, alignment(member)) + size(member);
        }
        return roundUp(end, alignment(typeId));
      }
      case SpvOpTypeFloat:
      case SpvOpTypeInt:
        return t.operands[0] / 8;
      default:
        return 4;
    }
  }

  uint32_t alignment(uint32_t typeId) {
    const SpirvInstruction& t = *type(typeId);
    switch (t.op) {
      case SpvOpTypeVector:
        return size(t.operands[0]) * (t.operands[1] == 3 ? 4 : t.operands[1]);
      case SpvOpTypeMatrix:
      case SpvOpTypeArray:
        return alignment(t.operands[0]);
      case SpvOpTypeStruct: {
        uint32_t largest = 4;
        for (const uint32_t member : t.operands) largest = std::max(largest, alignment(member));
        return largest;
      }
      default:
        return std::max(size(typeId), 4u);
    }
  }

  void specConstant(const SpirvInstruction& instruction) {
    const std::optional<uint32_t> id = module_.decoration(instruction.result, SpvDecorationSpecId);
    if (!id) return;
    SpecConstantInfo info;
    info.id = *id;
    info.name = module_.name(instruction.result);
    info.type = scalarType(*type(instruction.resultType));
    info.defaultBits = module_.constant(instruction.result).value_or(0);
    output_.specConstants.push_back(std::move(info));
  }

  const SpirvReader& module_;
  ModuleReflection output_;
  std::unordered_set<uint32_t> reachable_;
};

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

ModuleReflection reflectModule(const SpirvReader& module) { return Reflector(module).run(); }

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
