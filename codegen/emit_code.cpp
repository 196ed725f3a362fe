// The libraries of code: for each kernel and format a source file with the packed bytes and nothing
// else, so that a program links the kernels that it names.
#include <fmt/format.h>

#include "codegen/names.h"
#include "codegen/program.h"

namespace pelage::codegen {
namespace {

struct Format {
  CodeFormat format;
  const char* name;        ///< of the header and of the library
  const char* enumerator;  ///< of pelage::CodeFormat
  const char* title;
};
constexpr Format kFormats[] = {
    {CodeFormat::kSpirv, "spirv", "kSpirv", "SPIR-V"},
    {CodeFormat::kGlsl, "glsl", "kGlsl", "GLSL 450 core"},
    {CodeFormat::kEssl, "essl", "kEssl", "ESSL 320"},
};
constexpr Format kWgslFormat = {CodeFormat::kWgsl, "wgsl", "kWgsl", "WGSL"};

// As a string literal: compilers take one far faster than an array of numbers, in a fortieth of the
// memory. MSVC ends literals at 65,535 bytes, so there it is numbers.
std::string bytesInitializer(std::string_view bytes) {
  constexpr size_t kBytesPerLine = 64;
  std::string text;
#ifdef _WIN32
  text = "{";
  for (size_t i = 0; i < bytes.size(); ++i) {
    if (i % kBytesPerLine == 0) text += "\n    ";
    text += std::to_string(static_cast<unsigned char>(bytes[i])) + ",";
  }
  text += "}";
#else
  for (size_t i = 0; i < bytes.size(); i += kBytesPerLine) {
    text += "\n    \"";
    for (const char c : bytes.substr(i, kBytesPerLine)) {
      const auto u = static_cast<unsigned char>(c);
      if (u >= 32 && u < 127 && u != '"' && u != '\\' && u != '?') {
        text += c;
      } else {
        text += '\\';
        for (int shift = 6; shift >= 0; shift -= 3)
          text += static_cast<char>('0' + (u >> shift & 7u));
      }
    }
    text += '"';
  }
#endif
  return text;
}

const PackedCode& packed(const KernelOutput& kernel, const Format& format) {
  return kernel.code[static_cast<size_t>(format.format)];
}

std::string tableName(const KernelOutput& kernel, const Format& format) {
  return "k" + pascalCase(kernel.kernel.name) + pascalCase(format.name);
}

std::string listName(const Format& format) { return "all" + pascalCase(format.name); }

std::string formatHeader(const Format& format, const Program& program, const CppNames& names) {
  std::string text = generatedHead(program, std::string("The kernels' ") + format.title + ".");
  text +=
      "#pragma once\n\n#include \"pelage/kernel_code.h\"\n\nnamespace " + names.space + " {\n\n";
  for (const KernelOutput& kernel : program.kernels)
    text += fmt::format("extern const {}KernelCode {};\n", names.prefix, tableName(kernel, format));
  text += fmt::format(
      "\n/// Returns the tables of all kernels that have {}, in the order of the manifest.\n"
      "{}KernelCodeList {}();\n\n}}  // namespace {}\n",
      format.title, names.prefix, listName(format), names.space);
  return text;
}

// The addresses of a format's tables; a kernel that cannot be written in it has none.
std::string tableList(const Format& format, const Program& program) {
  std::string text;
  for (const KernelOutput& kernel : program.kernels) {
    if (!packed(kernel, format).ranges.empty())
      text += fmt::format("      &{},\n", tableName(kernel, format));
  }
  return text;
}

// Defines the function that returns a list of tables.
std::string codeList(const std::string& name, const std::string& tables, const CppNames& names) {
  return "namespace " + names.space + " {\n\n" +
         listFunction(names, "KernelCode", name, tables, "KernelCodeList") + "}  // namespace " +
         names.space + "\n";
}

std::string formatList(const Format& format, const Program& program, const CppNames& names) {
  std::string text =
      generatedHead(program, std::string("The list of the kernels' ") + format.title + ".");
  text += fmt::format("#include \"{}/{}.h\"\n\n", names.folder, format.name);
  return text + codeList(listName(format), tableList(format, program), names);
}

std::string kernelTable(const KernelOutput& kernel, const Format& format, const Program& program,
                        const CppNames& names) {
  const PackedCode& code = packed(kernel, format);
  const std::string name = tableName(kernel, format);
  std::string text = generatedHead(
      program, std::string(format.title) + " of " + kernel.kernel.name + ", compressed.");
  text += fmt::format(
      "#include \"pelage/kernel_code_table.h\"\n\nnamespace {} {{\n\n"
      "extern const {}Kernel k{}Kernel;\nextern const {}KernelCode {};\n\n",
      names.space, names.prefix, pascalCase(kernel.kernel.name), names.prefix, name);
  if (!code.ranges.empty()) {
    text += "namespace {\n\n";
    text += "constexpr unsigned char kBytes[] = " + bytesInitializer(code.bytes) + ";\n\n";
    text += fmt::format("constexpr {}KernelCode::Range kRanges[] = {{\n", names.prefix);
    for (const PackedCode::Range& range : code.ranges) {
      text +=
          fmt::format("    {{0x{:016x}ull, {}, {}}},\n", range.variant, range.offset, range.size);
    }
    text += "};\n\n}  // namespace\n\n";
  }
  text += fmt::format("constinit const {0}KernelCode {1}{{&k{2}Kernel, {0}CodeFormat::{3},\n",
                      names.prefix, name, pascalCase(kernel.kernel.name), format.enumerator);
  text += code.ranges.empty()
              ? "    nullptr, 0, 0, nullptr, 0};\n\n"
              : fmt::format("    kBytes, {}, {}, kRanges, {}}};\n\n", code.bytes.size(),
                            code.unpackedBytes, code.ranges.size());
  return text + "}  // namespace " + names.space + "\n";
}

std::string allHeader(const Program& program, const CppNames& names) {
  return generatedHead(program, "The kernels' code in every format.") +
         fmt::format(
             "#pragma once\n\n#include \"pelage/kernel_code.h\"\n\nnamespace {} {{\n\n"
             "/// Returns allSpirv(), allGlsl() and allEssl() in one list.\n"
             "{}KernelCodeList allCode();\n\n}}  // namespace {}\n",
             names.space, names.prefix, names.space);
}

std::string allList(const Program& program, const CppNames& names) {
  std::string text = generatedHead(program, "The list of code.h.");
  text += fmt::format("#include \"{}/code.h\"\n\n", names.folder);
  std::string all;
  for (const Format& format : kFormats) {
    text += fmt::format("#include \"{}/{}.h\"\n", names.folder, format.name);
    all += tableList(format, program);
  }
  return text + "\n" + codeList("allCode", all, names);
}

void addFormat(const Format& format, const Program& program, const CppNames& names,
               std::map<std::string, std::string>& files) {
  const std::string name = format.name;
  files["include/" + names.folder + "/" + name + ".h"] = formatHeader(format, program, names);
  files["code/" + name + ".cpp"] = formatList(format, program, names);
  for (const KernelOutput& kernel : program.kernels)
    files["code/" + kernel.kernel.name + "_" + name + ".cpp"] =
        kernelTable(kernel, format, program, names);
}

}  // namespace

std::map<std::string, std::string> emitCode(const Program& program) {
  const CppNames names = cppNames(program.manifest);
  std::map<std::string, std::string> files;
  for (const Format& format : kFormats) addFormat(format, program, names, files);
  if (program.wgsl) {
    addFormat(kWgslFormat, program, names, files);
    // Programs in other languages read the files, and reflection.json beside them.
    for (const KernelOutput& kernel : program.kernels) {
      for (const VariantOutput& variant : kernel.variants) {
        const std::string file = fmt::format("{}_{:016x}.wgsl", kernel.kernel.name, variant.hash);
        if (!variant.wgsl.empty()) files["wgsl/" + file] = variant.wgsl;
      }
    }
  }
  files["include/" + names.folder + "/code.h"] = allHeader(program, names);
  files["code/code.cpp"] = allList(program, names);
  return files;
}

}  // namespace pelage::codegen
