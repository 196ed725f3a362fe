#include "codegen/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "codegen/checks/source_model.h"
#include "codegen/checks/token_stream.h"
#include "codegen/enum_names.h"
#include "codegen/names.h"
#include "codegen/spirv_reader.h"

namespace pelage::codegen {
namespace {

constexpr const char* kEntry = "pelageStoreConstants";

// The buffer of the probe that takes constants of a type.
std::string bufferOf(ScalarType type) { return std::string("pelageConstants_") + word(type); }

std::optional<ScalarType> typeOf(const checks::Declaration& declaration) {
  if (!declaration.arraySizes.empty() || declaration.isQualified("unsigned")) return std::nullopt;
  for (const ScalarType type : {ScalarType::kUint, ScalarType::kInt, ScalarType::kFloat}) {
    if (declaration.type == word(type)) return type;
  }
  return std::nullopt;
}

// Value of each element that a module stores into the buffer of a type. Only what the compiler has
// made a constant has one.
std::map<std::pair<std::string, uint32_t>, uint32_t> storedConstants(const SpirvReader& module) {
  std::map<std::pair<std::string, uint32_t>, uint32_t> values;
  for (const SpirvInstruction& store : module.instructions()) {
    if (store.op != SpvOpStore) continue;
    const SpirvInstruction* target = module.definition(store.operands[0]);
    const SpirvInstruction* value = module.definition(store.operands[1]);
    if (target == nullptr || target->op != SpvOpAccessChain) continue;
    if (value == nullptr || value->op != SpvOpConstant) continue;
    const std::optional<uint32_t> element = module.constant(target->operands.back());
    const std::optional<uint32_t> bits = module.constant(store.operands[1]);
    if (element && bits) values[{module.name(target->operands[0]), *element}] = *bits;
  }
  return values;
}

}  // namespace

std::vector<SharedConstant> findConstants(const std::string& preprocessed, const std::string& file,
                                          Diagnostics& diagnostics) {
  const checks::TokenStream stream = checks::tokenize(preprocessed, file);
  const checks::SourceModel model = checks::parseSource(stream);
  std::vector<SharedConstant> constants;
  bool any = false;
  for (const checks::Declaration& global : model.globals) {
    const checks::Token& name = stream.at(global.name);
    if (!global.isQualified("static") || !global.isQualified("const")) continue;
    if (stream.fileOf(name) != file) continue;
    any = true;
    const std::string text(name.text);
    const std::optional<ScalarType> type = typeOf(global);
    if (!type) {
      diagnostics.error(file, name.line, "PK510",
                        "constant '" + text +
                            "' is shared with the host and no single uint, int or float: move it "
                            "into a file that \"constants\" of the manifest does not list");
    } else if (!isIdentifier(text)) {
      diagnostics.error(file, name.line, "PK510",
                        "constant '" + text + "' is shared with the host: this is no C++ name");
    } else {
      constants.push_back({text, *type, 0, name.line});
    }
  }
  if (!any) {
    diagnostics.error(file, 1, "PK512",
                      "the manifest lists this file under \"constants\": it declares none as "
                      "'static const uint kName = ...;'");
  }
  return constants;
}

FrontEndInput constantsProbe(FrontEndInput source, const std::string& preprocessed,
                             std::span<const SharedConstant> constants) {
  std::string text = preprocessed + "\n";
  // A space of its own: no register is taken.
  for (const ScalarType type : {ScalarType::kUint, ScalarType::kInt, ScalarType::kFloat}) {
    text += fmt::format("RWStructuredBuffer<{}> {} : register(u{}, space62);\n", word(type),
                        bufferOf(type), static_cast<int>(type));
  }
  text += fmt::format("[numthreads(1, 1, 1)]\nvoid {}() {{\n", kEntry);
  for (size_t i = 0; i < constants.size(); ++i) {
    text += fmt::format("  {}[{}] = {};\n", bufferOf(constants[i].type), i, constants[i].name);
  }
  source.text = text + "}\n";
  source.entry = kEntry;
  source.stage = Stage::kCompute;
  return source;
}

void readConstants(std::span<const uint32_t> spirv, const std::string& file,
                   std::vector<SharedConstant>& constants, Diagnostics& diagnostics) {
  const std::optional<SpirvReader> module = SpirvReader::parse(spirv);
  const auto values =
      module ? storedConstants(*module) : std::map<std::pair<std::string, uint32_t>, uint32_t>{};
  for (size_t i = 0; i < constants.size(); ++i) {
    SharedConstant& constant = constants[i];
    const auto found = values.find({bufferOf(constant.type), static_cast<uint32_t>(i)});
    const bool isFinite =
        found != values.end() &&
        (constant.type != ScalarType::kFloat || std::isfinite(std::bit_cast<float>(found->second)));
    if (isFinite) {
      constant.bits = found->second;
      continue;
    }
    diagnostics.error(file, constant.line, "PK511",
                      "constant '" + constant.name +
                          "' is shared with the host, and the compiler finds no finite value for "
                          "it: write 'static const', literals and other such constants");
  }
}

std::string constantValue(const SharedConstant& constant) {
  switch (constant.type) {
    case ScalarType::kFloat: {
      // The shortest text that is read as the same float.
      std::string text = fmt::format("{}", std::bit_cast<float>(constant.bits));
      if (text.find_first_of(".e") == std::string::npos) text += ".0";
      return text + "f";
    }
    case ScalarType::kInt: {
      const auto value = std::bit_cast<int32_t>(constant.bits);
      return value == INT32_MIN ? "INT32_MIN" : std::to_string(value);
    }
    default:
      return std::to_string(constant.bits) + "u";
  }
}

}  // namespace pelage::codegen
