#include "codegen/checks/line_module.h"

#include <algorithm>
#include <limits>

#include <spirv/unified1/spirv.hpp>

#include "codegen/spirv_reader.h"

namespace pelage::codegen::checks {
namespace {

// Types and constants nest; a module that nests deeper than this is malformed.
constexpr uint32_t kMaximumDepth = 64;
// The universal limit on ids of the SPIR-V specification (2.17).
constexpr uint32_t kMaximumBound = 0x3fffff;

bool contains(const std::unordered_map<uint32_t, std::vector<uint32_t>>& table, uint32_t id,
              uint32_t value) {
  const auto found = table.find(id);
  return found != table.end() &&
         std::find(found->second.begin(), found->second.end(), value) != found->second.end();
}

std::string_view textOf(const std::unordered_map<uint32_t, std::string_view>& table, uint32_t id) {
  const auto found = table.find(id);
  return found == table.end() ? std::string_view{} : found->second;
}

uint64_t saturatingMultiply(uint64_t a, uint64_t b) {
  return b != 0 && a > std::numeric_limits<uint64_t>::max() / b
             ? std::numeric_limits<uint64_t>::max()
             : a * b;
}

}  // namespace

std::optional<LineModule> LineModule::parse(std::span<const uint32_t> words) {
  if (words.size() < kHeaderWords || words[0] != spv::MagicNumber) return std::nullopt;
  const uint32_t bound = words[3];
  if (bound > kMaximumBound) return std::nullopt;
  LineModule module;
  module.definitions_.resize(bound);

  uint32_t fileId = 0, line = 0;
  for (size_t at = kHeaderWords; at < words.size();) {
    const std::optional<SpirvInstruction> decoded = decodeInstruction(words.subspan(at));
    if (!decoded || decoded->resultType >= bound || decoded->result >= bound) return std::nullopt;
    at += words[at] >> 16;
    Instruction instruction = {.opcode = static_cast<uint16_t>(decoded->op),
                               .type = decoded->resultType,
                               .result = decoded->result,
                               .operands = decoded->operands};
    const std::span<const uint32_t> operands = instruction.operands;
    switch (instruction.opcode) {
      case spv::OpLine:
        fileId = instruction.operand(0);
        line = instruction.operand(1);
        continue;
      case spv::OpNoLine:
        fileId = line = 0;
        continue;
      case spv::OpName:
        if (operands.size() > 1 && operands[0] < bound) {
          module.names_[operands[0]] = literalString(operands.subspan(1));
        }
        break;
      case spv::OpString:
        module.strings_[instruction.result] = literalString(operands);
        break;
      case spv::OpDecorate:
        if (operands.size() > 1 && operands[0] < bound) {
          module.decorations_[operands[0]].push_back(operands[1]);
        }
        break;
      default:
        break;
    }
    instruction.fileId = fileId;
    instruction.line = line;
    module.instructions_.push_back(instruction);
    if (instruction.result != 0) {
      module.definitions_[instruction.result] = static_cast<uint32_t>(module.instructions_.size());
    }
    // The line of a block ends with it.
    if (instruction.opcode == spv::OpFunctionEnd) fileId = line = 0;
  }
  return module;
}

const Instruction* LineModule::definition(uint32_t id) const {
  if (id >= definitions_.size() || definitions_[id] == 0) return nullptr;
  return &instructions_[definitions_[id] - 1];
}

uint32_t LineModule::typeOf(uint32_t id) const {
  const Instruction* found = definition(id);
  return found ? found->type : 0;
}

std::string_view LineModule::name(uint32_t id) const { return textOf(names_, id); }

std::string_view LineModule::file(uint32_t stringId) const { return textOf(strings_, stringId); }

bool LineModule::hasDecoration(uint32_t id, uint32_t decoration) const {
  return contains(decorations_, id, decoration);
}

uint32_t LineModule::pointee(uint32_t pointerType) const {
  const Instruction* type = definition(pointerType);
  return type && type->opcode == spv::OpTypePointer ? type->operand(1) : 0;
}

uint32_t LineModule::scalarType(uint32_t type) const {
  for (uint32_t depth = 0; depth < 2; ++depth) {
    const Instruction* found = definition(type);
    if (!found || (found->opcode != spv::OpTypeVector && found->opcode != spv::OpTypeMatrix)) {
      break;
    }
    type = found->operand(0);
  }
  return type;
}

bool LineModule::isFloat(uint32_t type) const {
  const Instruction* found = definition(scalarType(type));
  return found && found->opcode == spv::OpTypeFloat;
}

uint32_t LineModule::width(uint32_t type) const {
  const Instruction* found = definition(type);
  return found && (found->opcode == spv::OpTypeInt || found->opcode == spv::OpTypeFloat)
             ? found->operand(0)
             : 0;
}

std::optional<uint32_t> LineModule::constant(uint32_t id) const { return constantAt(id, 0); }

std::optional<uint32_t> LineModule::constantAt(uint32_t id, uint32_t depth) const {
  const Instruction* found = definition(id);
  if (!found || depth > kMaximumDepth) return std::nullopt;
  if (found->opcode == spv::OpConstant || found->opcode == spv::OpSpecConstant) {
    return found->operand(0);
  }
  if (found->opcode != spv::OpSpecConstantOp || found->operands.size() < 2) return std::nullopt;
  const auto a = constantAt(found->operand(1), depth + 1);
  const auto b = found->operands.size() > 2 ? constantAt(found->operand(2), depth + 1)
                                            : std::optional<uint32_t>(0);
  if (!a || !b) return std::nullopt;
  switch (found->operand(0)) {
    case spv::OpIAdd:
      return *a + *b;
    case spv::OpISub:
      return *a - *b;
    case spv::OpIMul:
      return *a * *b;
    case spv::OpUDiv:
      return *b == 0 ? std::nullopt : std::optional<uint32_t>(*a / *b);
    case spv::OpShiftLeftLogical:
      return *b > 31 ? 0 : *a << *b;
    case spv::OpShiftRightLogical:
      return *b > 31 ? 0 : *a >> *b;
    default:
      return std::nullopt;
  }
}

uint64_t LineModule::count(uint32_t type, bool vectorsAsOne, uint32_t depth) const {
  const Instruction* found = definition(type);
  if (!found || depth > kMaximumDepth) return 0;
  switch (found->opcode) {
    case spv::OpTypeBool:
      return 1;
    case spv::OpTypeInt:
    case spv::OpTypeFloat:
      // Two of 32 bits for 64.
      return std::max(found->operand(0) / 32, 1u);
    case spv::OpTypeVector:
      if (vectorsAsOne) return 1;
      [[fallthrough]];
    case spv::OpTypeMatrix:
      return saturatingMultiply(count(found->operand(0), vectorsAsOne, depth + 1),
                                found->operand(1));
    case spv::OpTypeArray:
      return saturatingMultiply(count(found->operand(0), vectorsAsOne, depth + 1),
                                constant(found->operand(1)).value_or(0));
    case spv::OpTypeStruct: {
      uint64_t sum = 0;
      for (const uint32_t member : found->operands) {
        const uint64_t part = count(member, vectorsAsOne, depth + 1);
        sum = sum > std::numeric_limits<uint64_t>::max() - part
                  ? std::numeric_limits<uint64_t>::max()
                  : sum + part;
      }
      return sum;
    }
    default:
      return 0;
  }
}

uint32_t LineModule::rootOf(uint32_t pointer) const {
  // Every step goes to an id that was made earlier, in a valid module.
  for (size_t steps = 0; steps < instructions_.size(); ++steps) {
    const Instruction* found = definition(pointer);
    if (!found) return 0;
    switch (found->opcode) {
      case spv::OpVariable:
      case spv::OpFunctionParameter:
        return pointer;
      case spv::OpAccessChain:
      case spv::OpInBoundsAccessChain:
      case spv::OpPtrAccessChain:
      case spv::OpCopyObject:
      case spv::OpImageTexelPointer:
      case spv::OpLoad:  // of an image or sampler
        pointer = found->operand(0);
        break;
      default:
        return 0;
    }
  }
  return 0;
}

std::optional<uint32_t> LineModule::storageClass(uint32_t id) const {
  const Instruction* found = definition(id);
  if (found && found->opcode != spv::OpTypePointer) found = definition(found->type);
  if (!found || found->opcode != spv::OpTypePointer) return std::nullopt;
  return found->operand(0);
}

bool isSumOfProducts(uint16_t opcode) {
  switch (opcode) {
    case spv::OpVectorTimesMatrix:
    case spv::OpMatrixTimesVector:
    case spv::OpMatrixTimesMatrix:
    case spv::OpDot:
      return true;
    default:
      return false;
  }
}

bool isContractable(uint16_t opcode) {
  switch (opcode) {
    case spv::OpFAdd:
    case spv::OpFSub:
    case spv::OpFMul:
    case spv::OpFDiv:
    case spv::OpVectorTimesScalar:
    case spv::OpMatrixTimesScalar:
    case spv::OpOuterProduct:
      return true;
    default:
      return isSumOfProducts(opcode);
  }
}

}  // namespace pelage::codegen::checks
