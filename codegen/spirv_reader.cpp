#include "codegen/spirv_reader.h"

#include <algorithm>

namespace pelage::codegen {
namespace {

const std::string kEmpty;

}  // namespace

std::optional<SpirvInstruction> decodeInstruction(std::span<const uint32_t> words) {
  const size_t count = words[0] >> 16;
  if (count == 0 || count > words.size()) return std::nullopt;
  SpirvInstruction instruction;
  instruction.op = static_cast<SpvOp>(words[0] & 0xffff);
  bool hasResult = false, hasResultType = false;
  SpvHasResultAndType(instruction.op, &hasResult, &hasResultType);
  size_t next = 1;
  if (count < 1u + hasResult + hasResultType) return std::nullopt;
  if (hasResultType) instruction.resultType = words[next++];
  if (hasResult) instruction.result = words[next++];
  instruction.operands = words.subspan(next, count - next);
  return instruction;
}

std::string_view literalString(std::span<const uint32_t> words) {
  const std::string_view text(reinterpret_cast<const char*>(words.data()), words.size() * 4);
  return text.substr(0, std::min(text.find('\0'), text.size()));
}

std::optional<SpirvReader> SpirvReader::parse(std::span<const uint32_t> words) {
  if (words.size() < kHeaderWords || words[0] != SpvMagicNumber) return std::nullopt;
  SpirvReader module;
  module.words_ = words;
  for (size_t i = kHeaderWords; i < words.size();) {
    std::optional<SpirvInstruction> decoded = decodeInstruction(words.subspan(i));
    if (!decoded) return std::nullopt;
    SpirvInstruction& instruction = *decoded;
    instruction.wordOffset = i;
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
    if (instruction.result != 0)
      module.definitions_[instruction.result] = module.instructions_.size();
    module.instructions_.push_back(instruction);
    i += words[i] >> 16;
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
