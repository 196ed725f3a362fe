// A SPIR-V module as a list of instructions with the tables that reflection needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <spirv/unified1/spirv.h>

namespace pelage::codegen {

inline constexpr size_t kHeaderWords = 5;  ///< in front of the instructions of a module

/// One instruction: a view into the words of the module.
struct SpirvInstruction {
  SpvOp op = SpvOpNop;
  uint32_t resultType = 0;             ///< 0 when it has none
  uint32_t result = 0;                 ///< 0 when it has none
  std::span<const uint32_t> operands;  ///< after result type and result
  size_t wordOffset = 0;               ///< of its first word in the module
};

/// The instruction at the front of `words`, with the offset 0; nothing if it is malformed.
std::optional<SpirvInstruction> decodeInstruction(std::span<const uint32_t> words);
/// A literal string, up to its zero.
std::string_view literalString(std::span<const uint32_t> words);

class SpirvReader {
 public:
  /// Empty when the words are not a well-formed module. Keeps a view of the words.
  static std::optional<SpirvReader> parse(std::span<const uint32_t> words);

  std::span<const uint32_t> words() const { return words_; }
  const std::vector<SpirvInstruction>& instructions() const { return instructions_; }
  /// nullptr when nothing defines the id.
  const SpirvInstruction* definition(uint32_t id) const;
  /// As in OpName; empty without one.
  const std::string& name(uint32_t id) const;
  const std::string& memberName(uint32_t type, uint32_t member) const;
  std::optional<uint32_t> decoration(uint32_t id, SpvDecoration decoration) const;
  std::optional<uint32_t> memberDecoration(uint32_t type, uint32_t member,
                                           SpvDecoration decoration) const;
  /// Value of an OpConstant or the default of an OpSpecConstant, 32 bits.
  std::optional<uint32_t> constant(uint32_t id) const;
  /// Id of the function that the module starts in.
  std::optional<uint32_t> entryPoint() const { return entryPoint_; }

 private:
  std::span<const uint32_t> words_;
  std::vector<SpirvInstruction> instructions_;
  std::unordered_map<uint32_t, size_t> definitions_;
  std::unordered_map<uint32_t, std::string> names_;
  std::map<std::pair<uint32_t, uint32_t>, std::string> memberNames_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> decorations_;
  std::map<std::tuple<uint32_t, uint32_t, uint32_t>, uint32_t> memberDecorations_;
  std::optional<uint32_t> entryPoint_;
};

}  // namespace pelage::codegen
