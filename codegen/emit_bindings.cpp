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

class BindingsWriter {
 public:
  explicit BindingsWriter(const Program& program)
      : program_(program),
        space_(program.manifest.namespaceName()),
        prefix_(space_ == "pelage" ? "" : "::pelage::") {}

  std::string write() const {
    const std::string folder = program_.manifest.namespaceFolder();
    std::string text = generatedHead(program_, "What passes bind: a struct for each layout.");
    text += fmt::format(
        "#pragma once\n\n#include <cstdint>\n#include <optional>\n\n#include \"pelage/binding.h\"\n"
        "#include \"{0}/gpu_structs.h\"\n#include \"{0}/layouts.h\"\n\nnamespace {1} {{\n\n",
        folder, space_);
    for (const PlannedLayout& layout : program_.layouts) {
      members(layout, text);
      functions(layout, text);
    }
    return text + "}  // namespace " + space_ + "\n";
  }

 private:
  void members(const PlannedLayout& layout, std::string& text) const {
    text += fmt::format(
        "/// The resources of layout {0}: set {1} of {2}. What a permutation does\n"
        "/// not use may stay empty.\nstruct {0}Bindings {{\n",
        layout.name, layout.set, groupsOf(program_, layout));
    for (const PlannedEntry& entry : layout.entries) {
      if (!isBound(entry)) continue;
      if (entry.kind == ResourceKind::kUniformBuffer) {
        text +=
            fmt::format("  std::optional<{}> {} = {{}};\n", entry.structName, hostName(entry.name));
      } else {
        text += fmt::format("  {}BufferRange {} = {{}};  ///< {}, {}, {}\n", prefix_,
                            hostName(entry.name), entry.name, entry.structName, word(entry.access));
      }
    }
    text += "};\n\n";
  }

  // Found by the arguments, so that no member's name clashes with theirs.
  void functions(const PlannedLayout& layout, std::string& text) const {
    text += fmt::format(
        "inline const {1}LayoutTable& layoutOf(const {0}Bindings&) {{ return k{0}Layout; }}\n\n"
        "/// What is bound to one of k{0}Layout.entries.\n",
        layout.name, prefix_);
    std::string cases;
    for (const PlannedEntry& entry : layout.entries) {
      if (!isBound(entry)) continue;
      const std::string name = hostName(entry.name);
      cases += fmt::format("    case {}Entry::{}:\n      return {}BoundResource(bindings.{});\n",
                           layout.name, name, prefix_, name);
    }
    if (cases.empty()) {
      text += fmt::format(
          "inline {0}BoundResource boundTo(const {1}Bindings&, uint8_t) {{ return {{}}; }}\n\n",
          prefix_, layout.name);
      return;
    }
    text += fmt::format(
        "inline {0}BoundResource boundTo(const {1}Bindings& bindings, uint8_t entry) {{\n"
        "  switch (entry) {{\n{2}    default:\n      return {{}};\n  }}\n}}\n\n",
        prefix_, layout.name, cases);
  }

  const Program& program_;
  std::string space_;
  std::string prefix_;
};

}  // namespace

std::string bindingsHeader(const Program& program) { return BindingsWriter(program).write(); }

}  // namespace pelage::codegen
