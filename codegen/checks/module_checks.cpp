#include <spirv/unified1/GLSL.std.450.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <set>
#include <spirv/unified1/spirv.hpp>
#include <unordered_map>

#include "codegen/checks/checks.h"
#include "codegen/checks/line_module.h"
#include "codegen/enum_names.h"

namespace pelage::codegen {

using namespace checks;

namespace {

// A constant table of more elements than this is an error; a vector is one element. Tuned with Mesa
// 22.3 (llvmpipe), time to compile and run one GLSL 450 kernel that reads a table of int with a
// varying index: 512 elements 0.03 s, 1024 0.08 s, 2048 0.30 s, 4096 1.2 s, so from here on it
// grows with the square.
constexpr uint64_t kMaximumTableElements = 1024;

// Image formats of GLES 3.2; the first three can be read and written in one kernel.
constexpr std::array kEsImageFormats = {
    spv::ImageFormatR32f,       spv::ImageFormatR32i,     spv::ImageFormatR32ui,
    spv::ImageFormatRgba32f,    spv::ImageFormatRgba16f,  spv::ImageFormatRgba8,
    spv::ImageFormatRgba8Snorm, spv::ImageFormatRgba32i,  spv::ImageFormatRgba16i,
    spv::ImageFormatRgba8i,     spv::ImageFormatRgba32ui, spv::ImageFormatRgba16ui,
    spv::ImageFormatRgba8ui};

bool isAtomic(uint16_t opcode) {
  switch (opcode) {
    case spv::OpAtomicLoad:
    case spv::OpAtomicStore:
    case spv::OpAtomicExchange:
    case spv::OpAtomicCompareExchange:
    case spv::OpAtomicIIncrement:
    case spv::OpAtomicIDecrement:
    case spv::OpAtomicIAdd:
    case spv::OpAtomicISub:
    case spv::OpAtomicSMin:
    case spv::OpAtomicUMin:
    case spv::OpAtomicSMax:
    case spv::OpAtomicUMax:
    case spv::OpAtomicAnd:
    case spv::OpAtomicOr:
    case spv::OpAtomicXor:
    case spv::OpAtomicFAddEXT:
    case spv::OpAtomicFMinEXT:
    case spv::OpAtomicFMaxEXT:
      return true;
    default:
      return false;
  }
}

// Functions of GLSL.std.450 with products and sums inside whose contraction nothing can forbid.
const char* contractingFunction(uint32_t number) {
  switch (number) {
    case GLSLstd450Fma:
      return "mad(), or a product and a sum that the optimiser joined";
    case GLSLstd450FMix:
      return "lerp()";
    case GLSLstd450Cross:
      return "cross()";
    case GLSLstd450Length:
      return "length()";
    case GLSLstd450Distance:
      return "distance()";
    case GLSLstd450Normalize:
      return "normalize()";
    case GLSLstd450SmoothStep:
      return "smoothstep()";
    case GLSLstd450Reflect:
      return "reflect()";
    case GLSLstd450Refract:
      return "refract()";
    case GLSLstd450FaceForward:
      return "faceforward()";
    case GLSLstd450Determinant:
      return "determinant()";
    case GLSLstd450MatrixInverse:
      return "the inverse of a matrix";
    case GLSLstd450Radians:
      return "radians()";
    case GLSLstd450Degrees:
      return "degrees()";
    default:
      return nullptr;
  }
}

// Blocks of one function, with indices into the module's instructions.
struct Block {
  size_t begin = 0, end = 0;  ///< OpLabel .. behind the terminator
  uint32_t label = 0;
  std::vector<size_t> successors, predecessors;  ///< indices of blocks
  size_t loopMerge = SIZE_MAX, loopContinue = SIZE_MAX;
  bool reachable = false;
};

class FunctionGraph {
 public:
  // `begin` is the OpFunction, `end` behind the OpFunctionEnd.
  FunctionGraph(const LineModule& module, size_t begin, size_t end) : module_(module) {
    const auto& instructions = module.instructions();
    for (size_t i = begin; i < end; ++i) {
      if (instructions[i].opcode == spv::OpLabel) {
        if (!blocks_.empty()) blocks_.back().end = i;
        index_[instructions[i].result] = blocks_.size();
        blocks_.push_back({i, end - 1, instructions[i].result, {}, {}, SIZE_MAX, SIZE_MAX, false});
      }
    }
    for (size_t b = 0; b < blocks_.size(); ++b) connect(b);
    markReachable();
  }

  const std::vector<Block>& blocks() const { return blocks_; }
  // SIZE_MAX when there is no such block.
  size_t find(uint32_t label) const {
    const auto found = index_.find(label);
    return found == index_.end() ? SIZE_MAX : found->second;
  }

 private:
  void link(size_t from, uint32_t label) {
    const size_t to = find(label);
    if (to == SIZE_MAX) return;
    blocks_[from].successors.push_back(to);
    blocks_[to].predecessors.push_back(from);
  }

  void connect(size_t b) {
    const auto& instructions = module_.instructions();
    for (size_t i = blocks_[b].begin; i < blocks_[b].end; ++i) {
      const Instruction& instruction = instructions[i];
      switch (instruction.opcode) {
        case spv::OpLoopMerge:
          blocks_[b].loopMerge = find(instruction.operand(0));
          blocks_[b].loopContinue = find(instruction.operand(1));
          break;
        case spv::OpBranch:
          link(b, instruction.operand(0));
          break;
        case spv::OpBranchConditional: {
          // "while (true)" does not leave through its condition.
          const Instruction* condition = module_.definition(instruction.operand(0));
          const bool always = condition && condition->opcode == spv::OpConstantTrue;
          link(b, instruction.operand(1));
          if (!always) link(b, instruction.operand(2));
          break;
        }
        case spv::OpSwitch:
          link(b, instruction.operand(1));
          for (size_t k = 3; k < instruction.operands.size(); k += 2) {
            link(b, instruction.operands[k]);
          }
          break;
        default:
          break;
      }
    }
  }

  void markReachable() {
    if (blocks_.empty()) return;
    std::vector<size_t> open{0};
    blocks_[0].reachable = true;
    while (!open.empty()) {
      const size_t b = open.back();
      open.pop_back();
      for (const size_t next : blocks_[b].successors) {
        if (!blocks_[next].reachable) {
          blocks_[next].reachable = true;
          open.push_back(next);
        }
      }
    }
  }

  const LineModule& module_;
  std::vector<Block> blocks_;
  std::unordered_map<uint32_t, size_t> index_;
};

// A set of the function's variables, one bit each.
using Bits = std::vector<bool>;

// Reports errors at the lines of instructions.
class Report {
 public:
  Report(const std::string& file, const LineModule* raw, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics), entry_{file, 1} {
    if (!raw) return;
    for (const Instruction& instruction : raw->instructions()) {
      if (instruction.opcode != spv::OpEntryPoint) continue;
      const Instruction* function = raw->definition(instruction.operand(1));
      if (function && function->line != 0) entry_ = locate(*raw, *function);
      return;
    }
  }

  // The entry point.
  const SourceLocation& entry() const { return entry_; }
  SourceLocation locate(const LineModule& module, const Instruction& instruction) const {
    if (instruction.line == 0) return entry_;
    const std::string_view file = module.file(instruction.fileId);
    return {file.empty() ? file_ : std::string(file), instruction.line};
  }

  void error(const SourceLocation& at, const char* code, std::string message) const {
    diagnostics_.error(at, code, std::move(message));
  }
  void error(const LineModule& module, const Instruction& at, const char* code,
             std::string message) const {
    error(locate(module, at), code, std::move(message));
  }
  void error(const char* code, std::string message) const {
    error(entry_, code, std::move(message));
  }

 private:
  const std::string& file_;
  Diagnostics& diagnostics_;
  SourceLocation entry_;
};

// "f(f1;vf3;" and "@main(vu3;" are how the front end names functions.
std::string_view plainName(std::string_view name) {
  if (name.starts_with('@')) name.remove_prefix(1);
  return name.substr(0, name.find('('));
}

// Moves "file:12: " from the line to the place.
void takeLocation(std::string_view& line, SourceLocation& at) {
  for (size_t colon = line.find(':'); colon != std::string_view::npos;
       colon = line.find(':', colon + 1)) {
    uint32_t number = 0;
    const char* const begin = line.data() + colon + 1;
    const char* const end = line.data() + line.size();
    const auto [next, failed] = std::from_chars(begin, end, number);
    if (failed != std::errc{} || next == end || *next != ':') continue;
    if (colon > 0) at.file = std::string(line.substr(0, colon));
    at.line = std::max(number, 1u);
    line.remove_prefix(static_cast<size_t>(next + 1 - line.data()));
    while (line.starts_with(' ')) line.remove_prefix(1);
    return;
  }
}

// PK201: what the front end says while it goes on.
void checkLogLine(std::string_view line, const Report& report) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!line.empty() && blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && blank(line.back())) line.remove_suffix(1);
  // Errors are reported by the caller; the rest are headlines and trailers.
  if (line.empty() || line.starts_with("ERROR:") ||
      line.find("HLSL parsing failed") != std::string_view::npos ||
      (line.starts_with("Linked ") && line.ends_with("stage:"))) {
    return;
  }
  SourceLocation at = report.entry();
  constexpr std::string_view kWarning = "WARNING: ";
  if (line.starts_with(kWarning)) {
    line.remove_prefix(kWarning.size());
    takeLocation(line, at);
  }
  report.error(at, "PK201",
               "the front end says: " + std::string(line) +
                   " (it goes on with something else than what is written)");
}

void checkLog(std::string_view rest, const Report& report) {
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    checkLogLine(rest.substr(0, end), report);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

// PK202.
void checkEntry(const std::string& entry, const LineModule& module, const Report& report) {
  bool named = false, writes = false;
  for (const Instruction& instruction : module.instructions()) {
    switch (instruction.opcode) {
      case spv::OpEntryPoint: {
        const auto words =
            instruction.operands.subspan(std::min<size_t>(2, instruction.operands.size()));
        const std::string_view text(reinterpret_cast<const char*>(words.data()), words.size() * 4);
        named = named || text.substr(0, text.find('\0')) == entry;
        break;
      }
      case spv::OpStore: {
        const auto storage = module.storageClass(module.rootOf(instruction.operand(0)));
        writes = writes ||
                 (storage != spv::StorageClassFunction && storage != spv::StorageClassPrivate &&
                  storage != spv::StorageClassWorkgroup);
        break;
      }
      case spv::OpImageWrite:
      case spv::OpKill:
        writes = true;
        break;
      default:
        writes = writes || isAtomic(instruction.opcode);
        break;
    }
  }
  if (!named || !writes) {
    report.error(
        "PK202",
        named ? quote(entry) + " writes nothing: is the entry point the function that was meant?"
              : "the module has no entry point " + quote(entry));
  }
}

void checkAtomic(const Instruction& instruction, const LineModule& module, const Report& report) {
  const uint32_t pointer = instruction.operand(0);
  const auto storage = module.storageClass(pointer);
  if (storage == spv::StorageClassFunction || storage == spv::StorageClassPrivate) {
    report.error(
        module, instruction, "PK204",
        "an atomic works on a copy here (an inout parameter or a local variable): name the "
        "buffer or groupshared element itself in the Interlocked call");
    return;
  }
  const uint32_t type =
      instruction.type != 0 ? instruction.type : module.typeOf(instruction.operand(3));
  if (module.isFloat(type) || module.width(type) != 32) {
    report.error(
        module, instruction, "PK205",
        "only atomics on 32-bit integers are safe: keep the value as uint (asuint, or fixed "
        "point)");
  }
  if ((instruction.opcode == spv::OpAtomicSMin || instruction.opcode == spv::OpAtomicSMax) &&
      storage != spv::StorageClassWorkgroup) {
    report.error(
        module, instruction, "PK206",
        "a signed minimum or maximum on a buffer puts keys with the top bit first: declare "
        "the keys uint");
  }
}

// PK207: a constant table that a driver takes seconds to compile, where it is used first.
void checkTable(const Instruction& instruction, const LineModule& module,
                std::set<uint32_t>& reported, const Report& report) {
  if (instruction.line == 0 || instruction.opcode == spv::OpConstantComposite ||
      instruction.opcode == spv::OpSpecConstantComposite) {
    return;
  }
  for (const uint32_t operand : instruction.operands) {
    const Instruction* found = module.definition(operand);
    if (!found || found->opcode != spv::OpConstantComposite) continue;
    const Instruction* type = module.definition(found->type);
    if (!type || type->opcode != spv::OpTypeArray) continue;
    const uint64_t count = module.elementCount(found->type);
    if (count > kMaximumTableElements && reported.insert(found->result).second) {
      report.error(
          module, instruction, "PK207",
          "a constant table of " + std::to_string(count) + " elements (more than " +
              std::to_string(kMaximumTableElements) +
              ") takes drivers seconds to compile: pack it into fewer uint4, or put it in a "
              "buffer");
    }
  }
}

void checkInstructions(const LineModule& module, const Report& report) {
  std::set<uint32_t> tables;
  for (const Instruction& instruction : module.instructions()) {
    switch (instruction.opcode) {
      case spv::OpSMod:
        report.error(
            module, instruction, "PK203",
            "% on signed integers takes the divisor's sign here and the dividend's in HLSL: "
            "write a - b * (a / b), or use uint");
        break;
      case spv::OpFMod:
        report.error(
            module, instruction, "PK203",
            "% and fmod() on floats take the divisor's sign here and the dividend's in HLSL: "
            "write a - b * trunc(a / b)");
        break;
      default:
        if (isAtomic(instruction.opcode)) checkAtomic(instruction, module, report);
        break;
    }
    checkTable(instruction, module, tables, report);
  }
}

// The operands that are values, of instructions that compute or move values; other operands may
// be literals that look like ids.
std::span<const uint32_t> valueOperands(const Instruction& instruction) {
  const uint16_t op = instruction.opcode;
  const bool computes = (op >= spv::OpConvertFToU && op <= spv::OpBitcast) ||
                        (op >= spv::OpSNegate && op <= spv::OpFwidthCoarse);
  if (computes || op == spv::OpReturnValue || op == spv::OpFunctionCall ||
      op == spv::OpCompositeConstruct || op == spv::OpPhi) {
    return instruction.operands;
  }
  if (op == spv::OpStore) {
    return instruction.operands.first(std::min<size_t>(2, instruction.operands.size()));
  }
  return {};
}

// PK208 and PK209: OpUndef is what a missing return and other missing values become.
void checkUndefined(const FunctionGraph& graph, const Instruction& function,
                    const LineModule& module, const Report& report) {
  const auto& instructions = module.instructions();
  for (const Block& block : graph.blocks()) {
    if (!block.reachable) continue;
    for (size_t i = block.begin; i < block.end; ++i) {
      const Instruction& instruction = instructions[i];
      const auto ids = valueOperands(instruction);
      const bool undefined = std::any_of(ids.begin(), ids.end(), [&](uint32_t operand) {
        const Instruction* found = module.definition(operand);
        return found && found->opcode == spv::OpUndef;
      });
      if (!undefined) continue;
      if (instruction.opcode == spv::OpReturnValue) {
        report.error(
            module, function, "PK208",
            "a path through " + quote(plainName(module.name(function.result))) +
                " ends without return, and returns anything: end the function with a return");
      } else {
        report.error(module, instruction, "PK209",
                     "an undefined value is used here: initialise it");
      }
    }
  }
}

// PK210: a case of a switch on an unsigned number that falls into the next one.
void checkSwitches(const FunctionGraph& graph, const LineModule& module, const Report& report) {
  const auto& instructions = module.instructions();
  for (size_t b = 0; b < graph.blocks().size(); ++b) {
    const Block& block = graph.blocks()[b];
    for (size_t i = block.begin; i < block.end; ++i) {
      const Instruction& instruction = instructions[i];
      if (instruction.opcode != spv::OpSwitch) continue;
      const Instruction* type = module.definition(module.typeOf(instruction.operand(0)));
      if (!type || type->opcode != spv::OpTypeInt || type->operand(1) != 0) continue;
      const uint32_t merge = i > 0 && instructions[i - 1].opcode == spv::OpSelectionMerge
                                 ? instructions[i - 1].operand(0)
                                 : 0;
      for (const size_t target : block.successors) {
        const Block& body = graph.blocks()[target];
        const bool fallsIn =
            body.label != merge &&
            std::any_of(body.predecessors.begin(), body.predecessors.end(),
                        [&](size_t from) { return from != b && graph.blocks()[from].reachable; });
        if (fallsIn) {
          report.error(module, instruction, "PK210",
                       "a case of this switch on uint falls into the next one, which GLES refuses: "
                       "write switch (int(...)), or end every case with break");
          break;
        }
      }
    }
  }
}

void reportUnwritten(const Instruction& load, uint32_t variable, bool always,
                     const LineModule& module, const Report& report) {
  std::string_view name = module.name(variable);
  if (name.empty() || name.starts_with("param")) name = "a value";
  report.error(module, load, "PK211",
               quote(name) +
                   (always ? " is read before anything is assigned to it"
                           : " is read here, but not every path assigns it before") +
                   ": initialise it where it is declared");
}

// A struct whose members are assigned one by one, and one is left out.
void checkMembers(const Instruction& load, uint32_t variable, const std::set<uint32_t>& written,
                  size_t index, std::set<size_t>& reported, const LineModule& module,
                  const Report& report) {
  if (load.operand(0) != variable) return;
  const Instruction* pointer = module.definition(variable);
  const Instruction* type = pointer ? module.definition(module.pointee(pointer->type)) : nullptr;
  if (!type || type->opcode != spv::OpTypeStruct || written.size() >= type->operands.size()) return;
  reported.insert(index);
  report.error(module, load, "PK211",
               quote(module.name(variable)) + " is used as a whole, but " +
                   std::to_string(type->operands.size() - written.size()) +
                   " of its members are never assigned: assign all of them");
}

// Records the member that a store through `pointer` writes; all members if it is not known.
void noteWrite(uint32_t pointer, uint32_t variable, size_t index,
               std::map<size_t, std::set<uint32_t>>& members, std::vector<bool>& writtenWhole,
               const LineModule& module) {
  const Instruction* chain = module.definition(pointer);
  if (chain && chain->opcode == spv::OpAccessChain && chain->operand(0) == variable) {
    if (const auto member = module.constant(chain->operand(1))) {
      members[index].insert(*member);
      return;
    }
  }
  writtenWhole[index] = true;
}

struct VariableAccess {
  size_t variable;
  size_t instruction;
  bool isStore;
};

struct Flow {
  std::vector<Bits> in, out;
};

// The blocks through which a loop exits by its condition, before the body.
std::unordered_map<size_t, std::pair<size_t, size_t>> findLoopExits(const FunctionGraph& graph) {
  std::unordered_map<size_t, std::pair<size_t, size_t>> exits;
  for (size_t b = 0; b < graph.blocks().size(); ++b) {
    const Block& header = graph.blocks()[b];
    if (header.loopMerge == SIZE_MAX || header.loopContinue == SIZE_MAX ||
        !graph.blocks()[header.loopContinue].reachable) {
      continue;
    }
    size_t at = b;
    for (size_t steps = 0; steps < graph.blocks().size(); ++steps) {
      const Block& block = graph.blocks()[at];
      if (block.successors.size() != 1) break;
      at = block.successors.front();
      if (at == header.loopContinue) break;
    }
    exits[at] = {header.loopMerge, header.loopContinue};
  }
  return exits;
}

// Variables written on some path (`must` false) or on every path to a block. A loop counts as
// running at least once: assignments in its body count after it.
Flow solve(const FunctionGraph& graph, const std::vector<std::vector<VariableAccess>>& accesses,
           size_t variableCount, bool must) {
  const size_t count = graph.blocks().size();
  Flow flow{std::vector<Bits>(count, Bits(variableCount, must)),
            std::vector<Bits>(count, Bits(variableCount, must))};
  std::unordered_map<size_t, std::pair<size_t, size_t>> exits;  // block -> merge, continue
  if (must) exits = findLoopExits(graph);
  if (count != 0) flow.in[0].assign(variableCount, false);
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t b = 0; b < count; ++b) {
      const Block& block = graph.blocks()[b];
      if (!block.reachable) continue;
      Bits in = flow.in[b];
      if (b != 0) {
        in.assign(variableCount, must);
        for (const size_t from : block.predecessors) {
          if (!graph.blocks()[from].reachable) continue;
          Bits out = flow.out[from];
          const auto exit = exits.find(from);
          if (exit != exits.end() && exit->second.first == b) {
            const Bits& body = flow.out[exit->second.second];
            for (size_t v = 0; v < variableCount; ++v) out[v] = out[v] || body[v];
          }
          for (size_t v = 0; v < variableCount; ++v) {
            in[v] = must ? in[v] && out[v] : in[v] || out[v];
          }
        }
      }
      Bits out = in;
      for (const VariableAccess& access : accesses[b]) {
        if (access.isStore) out[access.variable] = true;
      }
      if (in != flow.in[b] || out != flow.out[b]) {
        flow.in[b] = std::move(in);
        flow.out[b] = std::move(out);
        changed = true;
      }
    }
  }
  return flow;
}

// PK211: variables that are read before they are written.
void checkVariables(const FunctionGraph& graph, size_t begin, size_t end, const LineModule& module,
                    const Report& report) {
  const auto& instructions = module.instructions();
  std::unordered_map<uint32_t, size_t> variables;
  std::vector<uint32_t> ids;
  for (size_t i = begin; i < end; ++i) {
    if (instructions[i].opcode == spv::OpVariable && instructions[i].operands.size() < 2) {
      variables[instructions[i].result] = ids.size();
      ids.push_back(instructions[i].result);
    }
  }
  if (ids.empty()) return;

  const size_t blockCount = graph.blocks().size();
  std::vector<std::vector<VariableAccess>> accesses(blockCount);
  std::map<size_t, std::set<uint32_t>> members;  // written through constant member indices
  std::vector<bool> writtenWhole(ids.size());
  for (size_t b = 0; b < blockCount; ++b) {
    const Block& block = graph.blocks()[b];
    for (size_t i = block.begin; i < block.end; ++i) {
      const Instruction& instruction = instructions[i];
      const auto note = [&](uint32_t pointer, bool isStore) {
        const auto found = variables.find(module.rootOf(pointer));
        if (found == variables.end()) return;
        accesses[b].push_back({found->second, i, isStore});
        if (isStore) noteWrite(pointer, found->first, found->second, members, writtenWhole, module);
      };
      if (instruction.opcode == spv::OpLoad) {
        note(instruction.operand(0), false);
      } else if (instruction.opcode == spv::OpStore || isAtomic(instruction.opcode)) {
        note(instruction.operand(0), true);
      } else if (instruction.opcode == spv::OpFunctionCall ||
                 instruction.opcode == spv::OpCopyMemory || instruction.opcode == spv::OpExtInst) {
        // A pointer given away may be written through.
        for (const uint32_t operand : instruction.operands) {
          if (module.storageClass(operand) == spv::StorageClassFunction) note(operand, true);
        }
      }
    }
  }
  const Flow may = solve(graph, accesses, ids.size(), false);
  const Flow must = solve(graph, accesses, ids.size(), true);
  std::set<size_t> reported;
  for (size_t b = 0; b < blockCount; ++b) {
    if (!graph.blocks()[b].reachable) continue;
    Bits mayHere = may.in[b], mustHere = must.in[b];
    for (const VariableAccess& access : accesses[b]) {
      if (access.isStore) {
        mayHere[access.variable] = mustHere[access.variable] = true;
      } else if (!mustHere[access.variable] && reported.insert(access.variable).second) {
        reportUnwritten(instructions[access.instruction], ids[access.variable],
                        !mayHere[access.variable], module, report);
      } else if (reported.count(access.variable) == 0 && !writtenWhole[access.variable]) {
        checkMembers(instructions[access.instruction], ids[access.variable],
                     members[access.variable], access.variable, reported, module, report);
      }
    }
  }
}

// A static without an initializer that nothing writes; the language would make it zero.
void checkStatics(const LineModule& module, const Report& report) {
  std::set<uint32_t> written;
  std::map<uint32_t, const Instruction*> read;
  for (const Instruction& instruction : module.instructions()) {
    if (instruction.opcode == spv::OpLoad) {
      read.emplace(module.rootOf(instruction.operand(0)), &instruction);
    } else if (instruction.opcode == spv::OpStore) {
      written.insert(module.rootOf(instruction.operand(0)));
    } else if (instruction.opcode == spv::OpFunctionCall) {
      for (const uint32_t operand : instruction.operands) written.insert(module.rootOf(operand));
    }
  }
  for (const auto& [variable, load] : read) {
    const Instruction* definition = module.definition(variable);
    if (definition && definition->opcode == spv::OpVariable &&
        definition->operand(0) == spv::StorageClassPrivate && definition->operands.size() < 2 &&
        written.count(variable) == 0) {
      reportUnwritten(*load, variable, true, module, report);
    }
  }
}

void checkFunctions(const LineModule& module, const Report& report) {
  const auto& instructions = module.instructions();
  for (size_t i = 0; i < instructions.size(); ++i) {
    if (instructions[i].opcode != spv::OpFunction) continue;
    size_t end = i;
    while (end < instructions.size() && instructions[end].opcode != spv::OpFunctionEnd) ++end;
    end = std::min(end + 1, instructions.size());
    const FunctionGraph graph(module, i, end);
    checkUndefined(graph, instructions[i], module, report);
    checkSwitches(graph, module, report);
    checkVariables(graph, i, end, module, report);
    i = end - 1;
  }
}

void checkBlocks(const LineModule& module, const Report& report) {
  for (const Instruction& instruction : module.instructions()) {
    if (instruction.opcode == spv::OpTypeStruct &&
        module.hasDecoration(instruction.result, spv::DecorationBufferBlock)) {
      report.error(
          "PK212",
          "block " + quote(module.name(instruction.result)) +
              " is a BufferBlock, which Vulkan 1.2 and newer targets refuse: the front end is "
              "to be told to use the StorageBuffer class");
    }
    if (instruction.opcode == spv::OpVariable &&
        instruction.operand(0) == spv::StorageClassUniform) {
      const Instruction* type = module.definition(module.pointee(instruction.type));
      if (type && module.name(type->result) == "$Global") {
        report.error(
            "PK213",
            "a global variable that is neither static nor in a cbuffer became a uniform in a "
            "hidden block at binding 0: put it in a cbuffer");
      }
    }
  }
}

std::string tierText(Tier tier) { return std::string("tier ") + tierName(tier); }

// PK214 group size, PK215 groupshared memory.
void checkLimits(const LineModule& module, Tier tier, const Report& report) {
  const TierLimits limit = limitsOf(tier);
  uint64_t sharedBytes = 0;
  for (const Instruction& instruction : module.instructions()) {
    if (instruction.opcode == spv::OpExecutionMode &&
        instruction.operand(1) == spv::ExecutionModeLocalSize) {
      const std::array size = {instruction.operand(2), instruction.operand(3),
                               instruction.operand(4)};
      const uint64_t threads = uint64_t{size[0]} * size[1] * size[2];
      const bool fits = std::equal(size.begin(), size.end(), limit.groupSize,
                                   [](uint32_t a, uint32_t b) { return a >= 1 && a <= b; });
      if (!fits || threads > limit.groupThreads) {
        report.error("PK214", "a group of " + std::to_string(size[0]) + " x " +
                                  std::to_string(size[1]) + " x " + std::to_string(size[2]) +
                                  " threads; " + tierText(tier) + " has at most " +
                                  std::to_string(limit.groupThreads) + " threads, " +
                                  std::to_string(limit.groupSize[0]) + " x " +
                                  std::to_string(limit.groupSize[1]) + " x " +
                                  std::to_string(limit.groupSize[2]));
      }
    }
    if (instruction.opcode == spv::OpVariable &&
        instruction.operand(0) == spv::StorageClassWorkgroup) {
      const uint64_t count = module.scalarCount(module.pointee(instruction.type));
      sharedBytes = std::min<uint64_t>(sharedBytes + std::min<uint64_t>(count, UINT32_MAX) * 4,
                                       UINT32_MAX * uint64_t{4});
    }
  }
  if (sharedBytes > limit.groupSharedBytes) {
    report.error("PK215", std::to_string(sharedBytes) + " bytes of groupshared memory; " +
                              tierText(tier) + " has " + std::to_string(limit.groupSharedBytes));
  }
}

// PK216 images that GLES cannot read and write, or has no format for.
void checkImages(const LineModule& module, Tier tier, const Report& report) {
  if (tier == Tier::kWide) return;
  struct Use {
    const Instruction* read = nullptr;
    const Instruction* write = nullptr;
  };
  std::map<uint32_t, Use> uses;
  for (const Instruction& instruction : module.instructions()) {
    const uint32_t variable = module.rootOf(instruction.operand(0));
    switch (instruction.opcode) {
      case spv::OpImageRead:
        uses[variable].read = &instruction;
        break;
      case spv::OpImageWrite:
        uses[variable].write = &instruction;
        break;
      case spv::OpImageTexelPointer:
        uses[variable] = {&instruction, &instruction};
        break;
      default:
        break;
    }
  }
  for (const auto& [variable, use] : uses) {
    const Instruction* definition = module.definition(variable);
    if (!definition) continue;
    const Instruction* type = module.definition(module.pointee(definition->type));
    if (!type || type->opcode != spv::OpTypeImage) continue;
    const auto format = std::find(kEsImageFormats.begin(), kEsImageFormats.end(),
                                  static_cast<spv::ImageFormat>(type->operand(6)));
    const SourceLocation at = report.locate(module, use.write ? *use.write : *use.read);
    if (format == kEsImageFormats.end()) {
      report.error(at, "PK216",
                   quote(module.name(variable)) +
                       " has an image format that GLES lacks: use one or four components, with "
                       "[[spv::format_...]] where the type does not say it");
    } else if (use.read && use.write && format - kEsImageFormats.begin() >= 3) {
      report.error(
          at, "PK216",
          quote(module.name(variable)) +
              " is read and written, which GLES allows for r32 formats only: use a buffer, or "
              "one image for reading and one for writing");
    }
  }
}

// PK217 too many storage buffers; PK218 those of the vertex stage; PK223 other resources.
void checkResources(const LineModule& module, const CheckInput& input, const Report& report) {
  uint32_t buffers = 0, images = 0, textures = 0, blocks = 0;
  for (const Instruction& instruction : module.instructions()) {
    if (instruction.opcode != spv::OpVariable) continue;
    const uint32_t type = module.pointee(instruction.type);
    const Instruction* definition = module.definition(type);
    if (instruction.operand(0) == spv::StorageClassStorageBuffer ||
        module.hasDecoration(type, spv::DecorationBufferBlock)) {
      ++buffers;
    } else if (instruction.operand(0) == spv::StorageClassUniform) {
      ++blocks;
    } else if (instruction.operand(0) == spv::StorageClassUniformConstant && definition &&
               definition->opcode == spv::OpTypeImage) {
      // 2: read or written without a sampler; all others count as textures.
      ++(definition->operand(5) == 2 ? images : textures);
    }
  }
  const TierLimits limits = limitsOf(input.tier);
  const auto check = [&](const char* code, uint32_t count, const StageCounts& allowed,
                         const char* what, const char* advice) {
    const uint32_t most = allowed.of(input.stage);
    if (count <= most) return;
    report.error(code, std::to_string(count) + " " + what + " in one kernel; " +
                           tierText(input.tier) + " has " + std::to_string(most) + " in the " +
                           word(input.stage) + " stage: " + advice);
  };
  const bool noneInVertex = input.stage == Stage::kVertex && limits.storageBuffers.vertex == 0;
  check(noneInVertex ? "PK218" : "PK217", buffers, limits.storageBuffers, "storage buffers",
        noneInVertex ? "read vertex inputs, or state a higher tier"
                     : "merge some, or state a higher tier");
  check("PK223", images, limits.images, "images", "merge some, or state a higher tier");
  check("PK223", textures, limits.textures, "textures", "merge some");
  check("PK223", blocks, limits.uniformBlocks, "constant blocks", "merge some");
}

// PK219 and PK220: the same bits everywhere.
void checkPrecision(const LineModule& module, const Report& report) {
  std::set<std::pair<std::string, uint32_t>> reported;
  for (const Instruction& instruction : module.instructions()) {
    const bool contractable =
        isSumOfProducts(instruction.opcode) ||
        (isContractable(instruction.opcode) &&
         !module.hasDecoration(instruction.result, spv::DecorationNoContraction));
    if (contractable) {
      const SourceLocation at = report.locate(module, instruction);
      if (reported.insert({at.file, at.line}).second) {
        report.error(at, "PK219",
                     "this arithmetic may be contracted, but the kernel promises the same bits "
                     "everywhere: the module has to go through forbidContraction()");
      }
    }
    if (instruction.opcode != spv::OpExtInst) continue;
    const Instruction* set = module.definition(instruction.operand(0));
    if (!set || set->opcode != spv::OpExtInstImport) continue;
    if (const char* function = contractingFunction(instruction.operand(1))) {
      report.error(
          module, instruction, "PK220",
          std::string(function) +
              " has products and sums inside that each driver rounds in its own way, but the "
              "kernel promises the same bits everywhere: write them out");
    }
  }
}

// PK221, PK222: the text for OpenGL.
void checkText(std::string_view text, const char* language, const Report& report) {
  if (text.find("SPIRV_Cross_BaseInstance") != std::string_view::npos) {
    report.error(
        "PK221",
        std::string(language) +
            " has a base-instance uniform that nobody sets: the back end is to be told not to "
            "support a base instance");
  }
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const bool loose = line.starts_with("uniform ") &&
                       line.find("SPIRV_Cross_BaseInstance") == std::string_view::npos;
    const bool unbound = line.starts_with("layout(") &&
                         line.find("binding = ") == std::string_view::npos &&
                         (line.find(") uniform ") != std::string_view::npos ||
                          line.find(" buffer ") != std::string_view::npos);
    if (loose || unbound) {
      report.error("PK222", std::string(language) + " has a resource without a binding: " +
                                std::string(line.substr(0, 80)));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace

void runModuleChecks(const CheckInput& input, Diagnostics& diagnostics) {
  const std::optional<LineModule> raw = LineModule::parse(input.rawSpirv);
  const std::optional<LineModule> optimised = LineModule::parse(input.optimisedSpirv);
  if ((!raw && !input.rawSpirv.empty()) || (!optimised && !input.optimisedSpirv.empty())) {
    diagnostics.error(input.file, 1, "PK200", "the module is not well-formed SPIR-V");
  }
  const Report report(input.file, raw ? &*raw : nullptr, diagnostics);
  checkLog(input.frontEndLog, report);
  if (raw) {
    checkEntry(input.entry, *raw, report);
    checkInstructions(*raw, report);
    checkFunctions(*raw, report);
    checkBlocks(*raw, report);
    checkStatics(*raw, report);
  }
  // Code that the optimizer removes costs nothing.
  if (optimised) {
    checkLimits(*optimised, input.tier, report);
    checkImages(*optimised, input.tier, report);
    checkResources(*optimised, input, report);
    if (input.precise) checkPrecision(*optimised, report);
  }
  checkText(input.glsl, "GLSL", report);
  if (input.tier != Tier::kWide) checkText(input.essl, "ESSL", report);
}

}  // namespace pelage::codegen
