// bindings.h: a struct for each layout, which a pass takes in place of names.
#include <fmt/format.h>

#include "codegen/enum_names.h"
#include "codegen/names.h"
#include "codegen/program.h"

namespace pelage::codegen {
namespace {

bool isBound(const PlannedEntry& entry) {
  return entry.kind == ResourceKind::kStorageBuffer || entry.kind == ResourceKind::kUniformBuffer;
}

void addMembers(const PlannedLayout& layout, const Program& program, const CppNames& names,
                std::string& text) {
  text += fmt::format(
      "/// The resources of layout {0}: set {1} of {2}. What a permutation does\n"
      "/// not use may stay empty.\nstruct {0}Bindings {{\n",
      layout.name, layout.set, groupsOf(program, layout));
  for (const PlannedEntry& entry : layout.entries) {
    if (!isBound(entry)) continue;
    if (entry.kind == ResourceKind::kUniformBuffer) {
      text +=
          fmt::format("  std::optional<{}> {} = {{}};\n", entry.structName, hostName(entry.name));
    } else {
      text += fmt::format("  {}BufferRange {} = {{}};  ///< {}, {}, {}\n", names.prefix,
                          hostName(entry.name), entry.name, entry.structName, word(entry.access));
    }
  }
  text += "};\n\n";
}

// Found by the arguments, so that no member's name clashes with theirs.
void addFunctions(const PlannedLayout& layout, const CppNames& names, std::string& text) {
  text += fmt::format(
      "inline const {1}LayoutTable& layoutOf(const {0}Bindings&) {{ return k{0}Layout; }}\n\n"
      "/// What is bound to one of k{0}Layout.entries.\n",
      layout.name, names.prefix);
  std::string cases;
  for (const PlannedEntry& entry : layout.entries) {
    if (!isBound(entry)) continue;
    const std::string name = hostName(entry.name);
    cases += fmt::format("    case {}Entry::{}:\n      return {}BoundResource(bindings.{});\n",
                         layout.name, name, names.prefix, name);
  }
  if (cases.empty()) {
    text += fmt::format(
        "inline {0}BoundResource boundTo(const {1}Bindings&, uint8_t) {{ return {{}}; }}\n\n",
        names.prefix, layout.name);
    return;
  }
  text += fmt::format(
      "inline {0}BoundResource boundTo(const {1}Bindings& bindings, uint8_t entry) {{\n"
      "  switch (entry) {{\n{2}    default:\n      return {{}};\n  }}\n}}\n\n",
      names.prefix, layout.name, cases);
}

}  // namespace

std::string bindingsHeader(const Program& program) {
  const CppNames names = cppNames(program.manifest);
  std::string text = generatedHead(program, "What passes bind: a struct for each layout.");
  text += fmt::format(
      "#pragma once\n\n#include <cstdint>\n#include <optional>\n\n#include \"pelage/binding.h\"\n"
      "#include \"{0}/gpu_structs.h\"\n#include \"{0}/layouts.h\"\n\nnamespace {1} {{\n\n",
      names.folder, names.space);
  for (const PlannedLayout& layout : program.layouts) {
    addMembers(layout, program, names, text);
    addFunctions(layout, names, text);
  }
  return text + "}  // namespace " + names.space + "\n";
}

}  // namespace pelage::codegen
