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

class CodeWriter {
 public:
  explicit CodeWriter(const Program& program)
      : program_(program),
        space_(program.manifest.namespaceName()),
        folder_(program.manifest.namespaceFolder()),
        prefix_(space_ == "pelage" ? "" : "::pelage::") {}

  std::map<std::string, std::string> write() const {
    std::map<std::string, std::string> files;
    for (const Format& format : kFormats) add(format, files);
    if (program_.wgsl) {
      add(kWgslFormat, files);
      // Programs in other languages read the files, and reflection.json beside them.
      for (const KernelOutput& kernel : program_.kernels) {
        for (const VariantOutput& variant : kernel.variants) {
          const std::string file = fmt::format("{}_{:016x}.wgsl", kernel.kernel.name, variant.hash);
          if (!variant.wgsl.empty()) files["wgsl/" + file] = variant.wgsl;
        }
      }
    }
    files["include/" + folder_ + "/code.h"] = allHeader();
    files["code/code.cpp"] = allList();
    return files;
  }

 private:
  void add(const Format& format, std::map<std::string, std::string>& files) const {
    const std::string name = format.name;
    files["include/" + folder_ + "/" + name + ".h"] = header(format);
    files["code/" + name + ".cpp"] = list(format);
    for (const KernelOutput& kernel : program_.kernels)
      files["code/" + kernel.kernel.name + "_" + name + ".cpp"] = table(kernel, format);
  }
  static const PackedCode& packed(const KernelOutput& kernel, const Format& format) {
    return kernel.code[static_cast<size_t>(format.format)];
  }
  static std::string tableName(const KernelOutput& kernel, const Format& format) {
    return "k" + pascalCase(kernel.kernel.name) + pascalCase(format.name);
  }
  static std::string listName(const Format& format) { return "all" + pascalCase(format.name); }

  std::string header(const Format& format) const {
    std::string text = generatedHead(program_, std::string("The kernels' ") + format.title + ".");
    text += "#pragma once\n\n#include \"pelage/kernel_code.h\"\n\nnamespace " + space_ + " {\n\n";
    for (const KernelOutput& kernel : program_.kernels)
      text += fmt::format("extern const {}KernelCode {};\n", prefix_, tableName(kernel, format));
    text += fmt::format(
        "\n/// Returns the tables of all kernels that have {}, in the order of the manifest.\n"
        "{}KernelCodeList {}();\n\n}}  // namespace {}\n",
        format.title, prefix_, listName(format), space_);
    return text;
  }

  std::string list(const Format& format) const {
    std::string text =
        generatedHead(program_, std::string("The list of the kernels' ") + format.title + ".");
    text += fmt::format("#include \"{}/{}.h\"\n\n", folder_, format.name);
    return text + listFunction(listName(format), tables(format));
  }

  // The addresses of a format's tables; a kernel that cannot be written in it has none.
  std::string tables(const Format& format) const {
    std::string text;
    for (const KernelOutput& kernel : program_.kernels) {
      if (!packed(kernel, format).ranges.empty())
        text += fmt::format("      &{},\n", tableName(kernel, format));
    }
    return text;
  }

  std::string listFunction(const std::string& name, const std::string& tables) const {
    std::string text =
        fmt::format("namespace {} {{\n\n{}KernelCodeList {}() {{\n", space_, prefix_, name);
    text += tables.empty() ? "  return {};\n"
                           : fmt::format(
                                 "  static constexpr const {}KernelCode* kAll[] = {{\n{}  }};\n"
                                 "  return kAll;\n",
                                 prefix_, tables);
    return text + "}\n\n}  // namespace " + space_ + "\n";
  }

  std::string table(const KernelOutput& kernel, const Format& format) const {
    const PackedCode& code = packed(kernel, format);
    const std::string name = tableName(kernel, format);
    std::string text = generatedHead(
        program_, std::string(format.title) + " of " + kernel.kernel.name + ", compressed.");
    text += fmt::format(
        "#include \"pelage/kernel_code_table.h\"\n\nnamespace {} {{\n\n"
        "extern const {}Kernel k{}Kernel;\nextern const {}KernelCode {};\n\n",
        space_, prefix_, pascalCase(kernel.kernel.name), prefix_, name);
    if (!code.ranges.empty()) {
      text += "namespace {\n\n";
      text += "constexpr unsigned char kBytes[] = " + bytesInitializer(code.bytes) + ";\n\n";
      text += fmt::format("constexpr {}KernelCode::Range kRanges[] = {{\n", prefix_);
      for (const PackedCode::Range& range : code.ranges) {
        text +=
            fmt::format("    {{0x{:016x}ull, {}, {}}},\n", range.variant, range.offset, range.size);
      }
      text += "};\n\n}  // namespace\n\n";
    }
    text += fmt::format("constinit const {0}KernelCode {1}{{&k{2}Kernel, {0}CodeFormat::{3},\n",
                        prefix_, name, pascalCase(kernel.kernel.name), format.enumerator);
    text += code.ranges.empty()
                ? "    nullptr, 0, 0, nullptr, 0};\n\n"
                : fmt::format("    kBytes, {}, {}, kRanges, {}}};\n\n", code.bytes.size(),
                              code.unpackedBytes, code.ranges.size());
    return text + "}  // namespace " + space_ + "\n";
  }

  std::string allHeader() const {
    return generatedHead(program_, "The kernels' code in every format.") +
           fmt::format(
               "#pragma once\n\n#include \"pelage/kernel_code.h\"\n\nnamespace {} {{\n\n"
               "/// Returns allSpirv(), allGlsl() and allEssl() in one list.\n"
               "{}KernelCodeList allCode();\n\n}}  // namespace {}\n",
               space_, prefix_, space_);
  }

  std::string allList() const {
    std::string text = generatedHead(program_, "The list of code.h.");
    text += fmt::format("#include \"{}/code.h\"\n\n", folder_);
    std::string all;
    for (const Format& format : kFormats) {
      text += fmt::format("#include \"{}/{}.h\"\n", folder_, format.name);
      all += tables(format);
    }
    return text + "\n" + listFunction("allCode", all);
  }

  const Program& program_;
  std::string space_;
  std::string folder_;
  std::string prefix_;
};

}  // namespace

std::map<std::string, std::string> emitCode(const Program& program) {
  return CodeWriter(program).write();
}

}  // namespace pelage::codegen
