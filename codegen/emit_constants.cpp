// constants.h: numbers that kernels and the host share.
#include <fmt/format.h>

#include "codegen/program.h"

namespace pelage::codegen {
namespace {

const char* cppType(ScalarType type) {
  switch (type) {
    case ScalarType::kFloat:
      return "float";
    case ScalarType::kInt:
      return "int32_t";
    default:
      return "uint32_t";
  }
}

}  // namespace

std::string constantsHeader(const Program& program) {
  std::string text =
      generatedHead(program, "Constants that the kernels declare, a namespace for each file.");
  text += "#pragma once\n\n#include <cstdint>\n\n";
  for (const ConstantsOutput& output : program.constants) {
    const std::string space = program.manifest.namespaceName() + "::" + output.space;
    text += fmt::format("/// {}\nnamespace {} {{\n\n", output.file, space);
    for (const SharedConstant& constant : output.constants) {
      text += fmt::format("inline constexpr {} {} = {};\n", cppType(constant.type), constant.name,
                          constantValue(constant));
    }
    text += fmt::format("\n}}  // namespace {}\n\n", space);
  }
  text.pop_back();
  return text;
}

}  // namespace pelage::codegen
