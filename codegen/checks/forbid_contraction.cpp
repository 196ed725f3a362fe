#include <optional>
#include <spirv/unified1/spirv.hpp>

#include "codegen/checks/checks.h"
#include "codegen/checks/line_module.h"
#include "codegen/spirv_reader.h"

namespace pelage::codegen {

using namespace checks;

namespace {

constexpr size_t kBoundWord = 3;

// Instructions that may stand before the decorations or among them (SPIR-V specification, 2.4).
bool isBeforeTypes(uint32_t opcode) {
  switch (opcode) {
    case spv::OpCapability:
    case spv::OpExtension:
    case spv::OpExtInstImport:
    case spv::OpMemoryModel:
    case spv::OpEntryPoint:
    case spv::OpExecutionMode:
    case spv::OpExecutionModeId:
    case spv::OpString:
    case spv::OpSource:
    case spv::OpSourceContinued:
    case spv::OpSourceExtension:
    case spv::OpName:
    case spv::OpMemberName:
    case spv::OpModuleProcessed:
    case spv::OpDecorate:
    case spv::OpMemberDecorate:
    case spv::OpDecorateId:
    case spv::OpDecorateString:
    case spv::OpMemberDecorateString:
    case spv::OpDecorationGroup:
    case spv::OpGroupDecorate:
    case spv::OpGroupMemberDecorate:
      return true;
    default:
      return false;
  }
}

// A vector type: its component type and their number.
struct Vector {
  uint32_t component = 0, count = 0;
};

std::optional<Vector> aggregate(const LineModule& module, uint32_t type, uint16_t opcode) {
  const Instruction* found = module.definition(type);
  // Two to four, in every valid module.
  if (!found || found->opcode != opcode || found->operand(1) < 2 || found->operand(1) > 4) {
    return std::nullopt;
  }
  return Vector{found->operand(0), found->operand(1)};
}

std::optional<Vector> vectorType(const LineModule& module, uint32_t type) {
  return aggregate(module, type, spv::OpTypeVector);
}

// The component is the type of a column.
std::optional<Vector> matrixType(const LineModule& module, uint32_t type) {
  return aggregate(module, type, spv::OpTypeMatrix);
}

class Rewriter {
 public:
  Rewriter(std::span<const uint32_t> words, const LineModule& module)
      : words_(words), module_(module), bound_(words[kBoundWord]) {}

  std::vector<uint32_t> run() {
    std::vector<uint32_t> head(words_.begin(), words_.begin() + kHeaderWords);
    size_t at = kHeaderWords;
    for (; at < words_.size() && isBeforeTypes(words_[at] & 0xffff); at += words_[at] >> 16) {
      const auto instruction = words_.subspan(at, words_[at] >> 16);
      // All of these are rewritten.
      const bool written = (instruction[0] & 0xffff) == spv::OpDecorate && instruction.size() > 2 &&
                           instruction[2] == spv::DecorationNoContraction;
      if (!written) head.insert(head.end(), instruction.begin(), instruction.end());
    }
    for (; at < words_.size(); at += words_[at] >> 16) {
      rewrite(words_.subspan(at, words_[at] >> 16));
    }
    for (const uint32_t id : precise_) {
      head.insert(head.end(), {3u << 16 | spv::OpDecorate, id,
                               static_cast<uint32_t>(spv::DecorationNoContraction)});
    }
    head[kBoundWord] = bound_;
    head.insert(head.end(), body_.begin(), body_.end());
    return head;
  }

 private:
  void rewrite(std::span<const uint32_t> instruction) {
    const auto opcode = static_cast<uint16_t>(instruction[0] & 0xffff);
    if (instruction.size() >= 5 && isSumOfProducts(opcode) && expand(opcode, instruction)) return;
    body_.insert(body_.end(), instruction.begin(), instruction.end());
    if (isContractable(opcode) && instruction.size() > 2) precise_.push_back(instruction[2]);
  }

  bool expand(uint16_t opcode, std::span<const uint32_t> instruction) {
    const uint32_t type = instruction[1], result = instruction[2];
    const uint32_t a = instruction[3], b = instruction[4];
    switch (opcode) {
      case spv::OpDot: {
        const auto vector = vectorType(module_, module_.typeOf(a));
        if (!vector || vector->component != type) return false;
        dot(*vector, a, b, result);
        return true;
      }
      case spv::OpVectorTimesMatrix: {
        const auto vector = vectorType(module_, module_.typeOf(a)),
                   columns = matrixType(module_, module_.typeOf(b));
        if (!vector || !columns) return false;
        std::vector<uint32_t> parts;
        for (uint32_t i = 0; i < columns->count; ++i) {
          const uint32_t column = emit(spv::OpCompositeExtract, columns->component, {b, i});
          parts.push_back(bound_++);
          dot(*vector, a, column, parts.back());
        }
        emitTo(result, spv::OpCompositeConstruct, type, parts);
        return true;
      }
      case spv::OpMatrixTimesVector: {
        const auto columns = matrixType(module_, module_.typeOf(a)),
                   vector = vectorType(module_, module_.typeOf(b));
        if (!columns || !vector || vector->count != columns->count) return false;
        transform(*columns, vector->component, a, b, result);
        return true;
      }
      case spv::OpMatrixTimesMatrix: {
        const auto left = matrixType(module_, module_.typeOf(a)),
                   right = matrixType(module_, module_.typeOf(b));
        const auto vector = right ? vectorType(module_, right->component) : std::nullopt;
        if (!left || !vector || vector->count != left->count) return false;
        std::vector<uint32_t> parts;
        for (uint32_t i = 0; i < right->count; ++i) {
          const uint32_t column = emit(spv::OpCompositeExtract, right->component, {b, i});
          parts.push_back(bound_++);
          transform(*left, vector->component, a, column, parts.back());
        }
        emitTo(result, spv::OpCompositeConstruct, type, parts);
        return true;
      }
      default:
        return false;
    }
  }

  void emitTo(uint32_t result, uint16_t opcode, uint32_t type, std::span<const uint32_t> operands) {
    body_.push_back(static_cast<uint32_t>(3 + operands.size()) << 16 | opcode);
    body_.push_back(type);
    body_.push_back(result);
    body_.insert(body_.end(), operands.begin(), operands.end());
    if (isContractable(opcode)) precise_.push_back(result);
  }
  uint32_t emit(uint16_t opcode, uint32_t type, std::initializer_list<uint32_t> operands) {
    const uint32_t result = bound_++;
    emitTo(result, opcode, type, {operands.begin(), operands.size()});
    return result;
  }

  // Adds the products from the first to the last, the last sum into `result`.
  void sum(uint32_t type, const std::vector<uint32_t>& products, uint32_t result) {
    uint32_t total = products.front();
    for (size_t i = 1; i < products.size(); ++i) {
      const uint32_t next = i + 1 == products.size() ? result : bound_++;
      const uint32_t operands[] = {total, products[i]};
      emitTo(next, spv::OpFAdd, type, operands);
      total = next;
    }
  }

  void dot(Vector vector, uint32_t a, uint32_t b, uint32_t result) {
    std::vector<uint32_t> products;
    for (uint32_t i = 0; i < vector.count; ++i) {
      const uint32_t left = emit(spv::OpCompositeExtract, vector.component, {a, i});
      const uint32_t right = emit(spv::OpCompositeExtract, vector.component, {b, i});
      products.push_back(emit(spv::OpFMul, vector.component, {left, right}));
    }
    sum(vector.component, products, result);
  }

  // Matrix times vector: the columns, weighted by the vector's components.
  void transform(Vector columns, uint32_t scalar, uint32_t matrix, uint32_t vector,
                 uint32_t result) {
    std::vector<uint32_t> products;
    for (uint32_t i = 0; i < columns.count; ++i) {
      const uint32_t column = emit(spv::OpCompositeExtract, columns.component, {matrix, i});
      const uint32_t weight = emit(spv::OpCompositeExtract, scalar, {vector, i});
      products.push_back(emit(spv::OpVectorTimesScalar, columns.component, {column, weight}));
    }
    sum(columns.component, products, result);
  }

  std::span<const uint32_t> words_;
  const LineModule& module_;
  uint32_t bound_;
  std::vector<uint32_t> body_, precise_;
};

}  // namespace

std::vector<uint32_t> forbidContraction(std::span<const uint32_t> spirv) {
  const std::optional<LineModule> module = LineModule::parse(spirv);
  if (!module) return {spirv.begin(), spirv.end()};
  return Rewriter(spirv, *module).run();
}

}  // namespace pelage::codegen
