#include "codegen/wgsl_module.h"

#include <map>
#include <optional>
#include <unordered_map>

#include "codegen/reflect.h"
#include "codegen/spirv_reader.h"

namespace pelage::codegen {
namespace {

constexpr size_t kIdBoundWord = 3;  // of the header: all ids are smaller

// Operations that return what was there, and change it by a value.
bool isAtomicChange(SpvOp op) {
  switch (op) {
    case SpvOpAtomicExchange:
    case SpvOpAtomicIAdd:
    case SpvOpAtomicISub:
    case SpvOpAtomicUMin:
    case SpvOpAtomicUMax:
    case SpvOpAtomicSMin:
    case SpvOpAtomicSMax:
    case SpvOpAtomicAnd:
    case SpvOpAtomicOr:
    case SpvOpAtomicXor:
      return true;
    default:
      return false;
  }
}

// The word of an instruction that has its pointer; 0 for instructions without one.
size_t pointerWord(SpvOp op) {
  switch (op) {
    case SpvOpStore:
    case SpvOpAtomicStore:
      return 1;
    case SpvOpLoad:
    case SpvOpAccessChain:
    case SpvOpAtomicLoad:
    case SpvOpAtomicCompareExchange:
      return 3;
    default:
      return isAtomicChange(op) ? 3 : 0;
  }
}

// The word of an atomic operation that has a value which naga does not look for in other blocks; 0
// for instructions without one.
size_t atomicValueWord(SpvOp op) {
  if (op == SpvOpAtomicStore) return 4;
  return isAtomicChange(op) ? 6 : 0;
}

class WgslRewriter {
 public:
  explicit WgslRewriter(const SpirvReader& module)
      : module_(module), words_(module.words()), bound_(words_[kIdBoundWord]) {}

  std::vector<uint32_t> run() {
    out_.assign(words_.begin(), words_.begin() + kHeaderWords);
    uint32_t block = 0;
    bool decorated = false;
    for (const SpirvInstruction& instruction : module_.instructions()) {
      if (instruction.op == SpvOpLabel) block = instruction.result;
      if (block != 0 && instruction.result != 0) homes_[instruction.result] = block;
      if (instruction.op == SpvOpDecorate && !decorated) {
        decorateReadOnly();
        decorated = true;
      }
      copy(instruction, block);
    }
    out_[kIdBoundWord] = bound_;
    return std::move(out_);
  }

 private:
  std::span<const uint32_t> wordsOf(const SpirvInstruction& instruction) const {
    return words_.subspan(instruction.wordOffset, words_[instruction.wordOffset] >> 16);
  }

  // Appends the instruction, with a chain of its own where its pointer comes from another block.
  // Returns the offset of its first word.
  size_t copy(const SpirvInstruction& instruction, uint32_t block) {
    const std::span<const uint32_t> words = wordsOf(instruction);
    const size_t at = pointerWord(instruction.op);
    uint32_t pointer = at != 0 ? words[at] : 0;
    if (isFar(pointer, block) && module_.definition(pointer)->op == SpvOpAccessChain) {
      const size_t clone = copy(*module_.definition(pointer), block);
      pointer = out_[clone + 2] = bound_++;
    }
    const size_t valueAt = atomicValueWord(instruction.op);
    uint32_t value = valueAt != 0 ? words[valueAt] : 0;
    if (isFar(value, block)) {
      const uint32_t copied = bound_++;
      out_.insert(out_.end(), {4u << 16 | uint32_t{SpvOpCopyObject},
                               module_.definition(value)->resultType, copied, value});
      value = copied;
    }
    const size_t begin = out_.size();
    out_.insert(out_.end(), words.begin(), words.end());
    if (at != 0) out_[begin + at] = pointer;
    if (valueAt != 0) out_[begin + valueAt] = value;
    return begin;
  }

  // Whether an id is of another block than the one that uses it.
  bool isFar(uint32_t id, uint32_t block) const {
    const auto home = homes_.find(id);
    return home != homes_.end() && home->second != block;
  }

  void decorateReadOnly() {
    for (const auto& [id, access] : resourceAccess(module_)) {
      const SpirvInstruction* variable = module_.definition(id);
      if (access != Access::kRead || variable->operands[0] != SpvStorageClassStorageBuffer ||
          module_.decoration(id, SpvDecorationNonWritable))
        continue;
      out_.insert(out_.end(),
                  {3u << 16 | uint32_t{SpvOpDecorate}, id, uint32_t{SpvDecorationNonWritable}});
    }
  }

  const SpirvReader& module_;
  std::span<const uint32_t> words_;
  uint32_t bound_;
  std::vector<uint32_t> out_;
  std::unordered_map<uint32_t, uint32_t> homes_;  // blocks of ids
};

}  // namespace

std::vector<uint32_t> prepareForWgsl(std::span<const uint32_t> spirv) {
  const std::optional<SpirvReader> module = SpirvReader::parse(spirv);
  return module ? WgslRewriter(*module).run() : std::vector<uint32_t>(spirv.begin(), spirv.end());
}

}  // namespace pelage::codegen
