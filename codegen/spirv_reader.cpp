#include "codegen/spirv_reader.h"

namespace pelage::codegen {
namespace {

const std::string kEmpty;

// A SPIR-V literal string: bytes in words, lowest first, zero-terminated.
std::string literalString(std::span<const uint32_t> words) {
  std::string text;
  for (const uint32_t word : words) {
    for (int shift = 0; shift < 32; shift += 8) {
      const char c = static_cast<char>(word >> shift & 0xff);
      if (c == 0) return text;
      text += c;
    }
  }
  return text;
}

}  // namespace

std::optional<SpirvReader> SpirvReader::parse(std::span<const uint32_t> words) {
  if (words.size() < kHeaderWords || words[0] != SpvMagicNumber) return std::nullopt;
  SpirvReader module;
  module.words_ = words;
  for (size_t i = kHeaderWords; i < words.size();) {
    const size_t count = words[i] >> 16;
    if (count == 0 || i + count > words.size()) return std::nullopt;
    SpirvInstruction instruction;
    instruction.op = static_cast<SpvOp>(words[i] & 0xffff);
    instruction.wordOffset = i;
    bool hasResult = false;
    bool hasResultType = false;
    SpvHasResultAndType(instruction.op, &hasResult, &hasResultType);
    size_t next = 1;
    if (count < 1u + hasResult + hasResultType) return std::nullopt;
    if (hasResultType) instruction.resultType = words[i + next++];
    if (hasResult) instruction.result = words[i + next++];
    instruction.operands = words.subspan(i + next, count - next);
    const std::span<const uint32_t> operands = instruction.operands;
    switch (instruction.op) {
      case SpvOpName:
        if (operands.size() < 2) return std::nullopt;
        module.names_[operands[0]] = literalString(operands.subspan(1));
        break;
      case SpvOpMemberName:
        if (operands.size() < 3) return std::nullopt;
        module.memberNames_[{operands[0], operands[1]}] = literalString(operands.subspan(2));
        break;
      case SpvOpDecorate:
        if (operands.size() < 2) return std::nullopt;
        module.decorations_[{operands[0], operands[1]}] = operands.size() > 2 ? operands[2] : 0;
        break;
      case SpvOpMemberDecorate:
        if (operands.size() < 3) return std::nullopt;
        module.memberDecorations_[{operands[0], operands[1], operands[2]}] =
            operands.size() > 3 ? operands[3] : 0;
        break;
      case SpvOpEntryPoint:
        if (operands.size() < 3) return std::nullopt;
        module.entryPoint_ = operands[1];
        break;
      default:
        break;
    }
    if (hasResult) module.definitions_[instruction.result] = module.instructions_.size();
    module.instructions_.push_back(instruction);
    i += count;
  }
  return module;
}

const SpirvInstruction* SpirvReader::definition(uint32_t id) const {
  const auto found = definitions_.find(id);
  return found == definitions_.end() ? nullptr : &instructions_[found->second];
}

const std::string& SpirvReader::name(uint32_t id) const {
  const auto found = names_.find(id);
  return found == names_.end() ? kEmpty : found->second;
}

const std::string& SpirvReader::memberName(uint32_t type, uint32_t member) const {
  const auto found = memberNames_.find({type, member});
  return found == memberNames_.end() ? kEmpty : found->second;
}

std::optional<uint32_t> SpirvReader::decoration(uint32_t id, SpvDecoration decoration) const {
  const auto found = decorations_.find({id, static_cast<uint32_t>(decoration)});
  if (found == decorations_.end()) return std::nullopt;
  return found->second;
}

std::optional<uint32_t> SpirvReader::memberDecoration(uint32_t type, uint32_t member,
                                                      SpvDecoration decoration) const {
  const auto found = memberDecorations_.find({type, member, static_cast<uint32_t>(decoration)});
  if (found == memberDecorations_.end()) return std::nullopt;
  return found->second;
}

std::optional<uint32_t> SpirvReader::constant(uint32_t id) const {
  const SpirvInstruction* instruction = definition(id);
  if (instruction == nullptr) return std::nullopt;
  switch (instruction->op) {
    case SpvOpConstant:
    case SpvOpSpecConstant:
      if (instruction->operands.size() != 1) return std::nullopt;
      return instruction->operands[0];
    case SpvOpConstantTrue:
    case SpvOpSpecConstantTrue:
      return 1u;
    case SpvOpConstantFalse:
    case SpvOpSpecConstantFalse:
      return 0u;
    default:
      return std::nullopt;
  }
}

}  // namespace pelage::codegen
