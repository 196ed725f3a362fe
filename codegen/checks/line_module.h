// Reader for SPIR-V: instructions with their source lines, and the few facts about ids that the
// module checks need. It also reads modules that spirv-val refuses. (Reflection has its own reader,
// which keeps names of members and values of decorations but no lines.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace pelage::codegen::checks {

/// One instruction of a module.
struct Instruction {
  uint16_t opcode = 0;
  uint32_t type = 0;                   ///< id of the result type, 0 when it has none
  uint32_t result = 0;                 ///< id, 0 when it has none
  std::span<const uint32_t> operands;  ///< after the result
  uint32_t fileId = 0;                 ///< OpString of the current OpLine, 0 if there is none
  uint32_t line = 0;

  /// Returns 0 if there is no such operand.
  uint32_t operand(size_t index) const { return index < operands.size() ? operands[index] : 0; }
};

/// A parsed module; keeps views into the words it was parsed from.
class LineModule {
 public:
  /// Returns nothing if the words are not SPIR-V (magic number, an instruction beyond the end, or
  /// ids beyond the bound).
  static std::optional<LineModule> parse(std::span<const uint32_t> words);

  const std::vector<Instruction>& instructions() const { return instructions_; }

  /// Returns the instruction that defines `id`; nullptr if none does.
  const Instruction* definition(uint32_t id) const;
  /// Type of the value `id`, 0 if it has none.
  uint32_t typeOf(uint32_t id) const;
  /// OpName of an id, empty when it has none.
  std::string_view name(uint32_t id) const;
  /// Text of the OpString, empty when there is none.
  std::string_view file(uint32_t stringId) const;

  bool hasDecoration(uint32_t id, uint32_t decoration) const;

  /// Follows OpTypePointer once; 0 if the type is no pointer.
  uint32_t pointee(uint32_t pointerType) const;
  /// Component type of a vector or matrix (to the scalar), or `type` itself.
  uint32_t scalarType(uint32_t type) const;
  bool isFloat(uint32_t type) const;
  /// Bits of an OpTypeInt or OpTypeFloat, 0 for another type.
  uint32_t width(uint32_t type) const;
  /// Value of a 32-bit OpConstant, of the default of an OpSpecConstant or of an integer
  /// OpSpecConstantOp on them; nothing for another id.
  std::optional<uint32_t> constant(uint32_t id) const;
  /// Number of 32-bit scalars in a value of this type; 0 for opaque and runtime-sized ones,
  /// saturating.
  uint64_t scalarCount(uint32_t type) const { return count(type, false, 0); }
  /// The same, a vector counted as one.
  uint64_t elementCount(uint32_t type) const { return count(type, true, 0); }
  /// Returns the variable or function parameter that a pointer refers to; 0 if it is not known.
  uint32_t rootOf(uint32_t pointer) const;
  /// Storage class of a pointer type or of the type of a pointer; nothing for another id.
  std::optional<uint32_t> storageClass(uint32_t id) const;

 private:
  std::optional<uint32_t> constantAt(uint32_t id, uint32_t depth) const;
  uint64_t count(uint32_t type, bool vectorsAsOne, uint32_t depth) const;

  std::vector<Instruction> instructions_;
  std::vector<uint32_t> definitions_;  // by id: index into instructions_ + 1
  std::unordered_map<uint32_t, std::string_view> names_, strings_;
  std::unordered_map<uint32_t, std::vector<uint32_t>> decorations_;
};

/// Returns true for the arithmetic instructions on floats to which NoContraction applies. Some of
/// them consist of products and sums: isSumOfProducts().
bool isContractable(uint16_t opcode);
/// Dot products and the products with a matrix.
bool isSumOfProducts(uint16_t opcode);

}  // namespace pelage::codegen::checks
