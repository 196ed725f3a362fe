#include "codegen/manifest.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "codegen/file_io.h"
#include "codegen/key_completion.h"
#include "codegen/names.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaximumPermutations = 1024;
constexpr size_t kMaximumLayouts = 4;  // Vulkan guarantees four sets

// A JSON value with the line that it is on.
struct Node {
  enum class Type { kNull, kBool, kInteger, kNumber, kString, kArray, kObject };
  Type type = Type::kNull;
  uint32_t line = 1;
  bool boolean = false;
  int64_t integer = 0;
  std::string string;
  std::vector<std::string> keys;  // of an object, parallel to children
  std::vector<uint32_t> keyLines;
  std::vector<Node> children;

  const Node* find(std::string_view key) const {
    for (size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == key) return &children[i];
    }
    return nullptr;
  }
};

// Counts the lines that the parser has consumed. nlohmann's parser copies its iterator, so the
// count lives outside.
class LineIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  LineIterator(const char* position, uint32_t* line) : position_(position), line_(line) {}
  reference operator*() const { return *position_; }
  LineIterator& operator++() {
    if (*position_ == '\n') ++*line_;
    ++position_;
    return *this;
  }
  LineIterator operator++(int) {
    LineIterator old = *this;
    ++*this;
    return old;
  }
  bool operator==(const LineIterator& other) const { return position_ == other.position_; }

 private:
  const char* position_;
  uint32_t* line_;
};

class TreeBuilder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(const uint32_t& line, const std::string& file, Diagnostics& diagnostics)
      : line_(line), file_(file), diagnostics_(diagnostics) {}

  bool null() override { return add(Node::Type::kNull); }
  bool boolean(bool value) override {
    add(Node::Type::kBool)->boolean = value;
    return true;
  }
  bool number_integer(number_integer_t value) override {
    add(Node::Type::kInteger)->integer = value;
    return true;
  }
  bool number_unsigned(number_unsigned_t value) override {
    constexpr auto kLargest = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
    add(Node::Type::kInteger)->integer = static_cast<int64_t>(std::min<uint64_t>(value, kLargest));
    return true;
  }
  bool number_float(number_float_t, const string_t&) override {
    return add(Node::Type::kNumber) != nullptr;
  }
  bool string(string_t& value) override {
    add(Node::Type::kString)->string = value;
    return true;
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override { return open(Node::Type::kObject); }
  bool end_object() override { return close(); }
  bool start_array(size_t) override { return open(Node::Type::kArray); }
  bool end_array() override { return close(); }
  bool key(string_t& value) override {
    Node& object = *stack_.back();
    if (object.find(value) != nullptr) {
      diagnostics_.error(file_, line_, "PK301", "the key \"" + value + "\" is there twice");
    }
    object.keys.push_back(value);
    object.keyLines.push_back(line_);
    return true;
  }
  bool parse_error(size_t, const std::string& token,
                   const nlohmann::detail::exception& e) override {
    // The exception's text starts with its own name and a position that we have as a line.
    std::string what = e.what();
    const size_t colon = what.find(": ");
    if (colon != std::string::npos) what = what.substr(colon + 2);
    diagnostics_.error(file_, line_, "PK301",
                       "not valid JSON near '" + token.substr(0, 40) + "': " + what);
    return false;
  }

  Node root;

 private:
  Node* add(Node::Type type) {
    Node* node = &root;
    if (!stack_.empty()) node = &stack_.back()->children.emplace_back();
    node->type = type;
    node->line = line_;
    return node;
  }
  bool open(Node::Type type) {
    // A container grows only while it is the innermost one, so pointers to the outer ones hold.
    stack_.push_back(add(type));
    return true;
  }
  bool close() {
    stack_.pop_back();
    return true;
  }

  const uint32_t& line_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  std::vector<Node*> stack_;
};

const char* typeName(Node::Type type) {
  switch (type) {
    case Node::Type::kNull:
      return "null";
    case Node::Type::kBool:
      return "a bool";
    case Node::Type::kInteger:
      return "an integer";
    case Node::Type::kNumber:
      return "a number";
    case Node::Type::kString:
      return "a string";
    case Node::Type::kArray:
      return "an array";
    case Node::Type::kObject:
      break;
  }
  return "an object";
}

// Reports what is wrong with nodes.
class NodeChecks {
 public:
  NodeChecks(const std::string& file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  size_t reported() const { return diagnostics_.items().size(); }

  void error(uint32_t line, const char* code, std::string message) {
    diagnostics_.error(file_, line, code, std::move(message));
  }

  bool expect(const Node& node, Node::Type type, const std::string& what) {
    if (node.type == type) return true;
    error(node.line, "PK302",
          what + " must be " + typeName(type) + ", it is " + typeName(node.type));
    return false;
  }

  const Node* require(const Node& object, std::string_view key, Node::Type type,
                      const std::string& where) {
    const Node* node = object.find(key);
    if (node == nullptr) {
      error(object.line, "PK302", where + " lacks \"" + std::string(key) + "\"");
      return nullptr;
    }
    return expect(*node, type, "\"" + std::string(key) + "\"") ? node : nullptr;
  }

  // An optional key.
  void readBool(const Node& object, const char* key, bool& value) {
    const Node* node = object.find(key);
    if (node != nullptr && expect(*node, Node::Type::kBool, "\"" + std::string(key) + "\""))
      value = node->boolean;
  }

  void allowKeys(const Node& object, std::initializer_list<std::string_view> allowed,
                 const std::string& where) {
    for (size_t i = 0; i < object.keys.size(); ++i) {
      if (std::find(allowed.begin(), allowed.end(), object.keys[i]) != allowed.end()) continue;
      std::string list;
      for (const std::string_view key : allowed)
        list += (list.empty() ? "" : ", ") + std::string(key);
      error(object.keyLines[i], "PK303",
            "unknown key \"" + object.keys[i] + "\" in " + where + "; known: " + list);
    }
  }

 private:
  const std::string& file_;
  Diagnostics& diagnostics_;
};

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

void readNamespace(const Node& root, Manifest& manifest, NodeChecks& checks) {
  const Node* node = checks.require(root, "namespace", Node::Type::kString, "the manifest");
  if (node == nullptr) return;
  std::string rest = node->string;
  while (true) {
    const size_t colons = rest.find("::");
    const std::string part = rest.substr(0, colons);
    if (!isIdentifier(part)) {
      checks.error(node->line, "PK304", "\"" + node->string + "\" is not a C++ namespace");
      return;
    }
    manifest.namespaceParts.push_back(part);
    if (colons == std::string::npos) return;
    rest = rest.substr(colons + 2);
  }
}

// A layout has one set number and one block of GL bindings: what a group shares with another one
// is how both begin. The layout is the last one of the group so far.
bool checkShared(const ManifestGroup& group, size_t owner, const Node& layout,
                 const std::vector<ManifestGroup>& groups, NodeChecks& checks) {
  if (owner == groups.size()) {
    checks.error(layout.line, "PK306",
                 "layout \"" + layout.string + "\" is there twice in group \"" + group.name + "\"");
    return false;
  }
  const ManifestGroup& other = groups[owner];
  if (other.layouts.size() >= group.layouts.size() &&
      std::equal(group.layouts.begin(), group.layouts.end(), other.layouts.begin())) {
    return true;
  }
  checks.error(
      layout.line, "PK306",
      "layout \"" + layout.string + "\" is in group \"" + other.name +
          "\" too, at another index or after other layouts: put the layouts that groups share "
          "first, in the same order in each");
  return false;
}

void readGroups(const Node& groups, Manifest& manifest, NodeChecks& checks) {
  std::map<std::string, size_t> owners;  // the first group that has a layout
  for (size_t i = 0; i < groups.keys.size() && i < groups.children.size(); ++i) {
    ManifestGroup group;
    group.name = groups.keys[i];
    const Node& list = groups.children[i];
    if (!checks.expect(list, Node::Type::kArray, "group \"" + group.name + "\"")) continue;
    if (list.children.empty() || list.children.size() > kMaximumLayouts) {
      checks.error(list.line, "PK305",
                   "group \"" + group.name + "\" has " + std::to_string(list.children.size()) +
                       " layouts; Vulkan guarantees 1 to " + std::to_string(kMaximumLayouts) +
                       " sets");
    }
    bool inOrder = true;
    for (const Node& layout : list.children) {
      if (!checks.expect(layout, Node::Type::kString, "a layout")) continue;
      if (!isIdentifier(layout.string) || std::islower(layout.string[0]) != 0) {
        checks.error(layout.line, "PK304",
                     "\"" + layout.string + "\" is not a layout name; write it like \"SimPosTan\"");
      }
      const auto [found, added] = owners.emplace(layout.string, manifest.groups.size());
      group.layouts.push_back(layout.string);
      // After the first wrong layout, those behind it would only repeat the error.
      if (!added && inOrder)
        inOrder = checkShared(group, found->second, layout, manifest.groups, checks);
    }
    manifest.groups.push_back(std::move(group));
  }
}

void readConstantFiles(const Node& list, const fs::path& folder, Manifest& manifest,
                       NodeChecks& checks) {
  if (!checks.expect(list, Node::Type::kArray, "\"constants\"")) return;
  for (const Node& node : list.children) {
    if (!checks.expect(node, Node::Type::kString, "a file of constants")) continue;
    const ManifestConstants constants{node.string, fs::path(node.string).stem().string(),
                                      node.line};
    if (!isFile(folder / constants.file)) {
      checks.error(node.line, "PK308", "constants: there is no file \"" + constants.file + "\"");
      continue;
    }
    if (!isIdentifier(constants.space)) {
      checks.error(node.line, "PK304",
                   "\"" + constants.space + "\" of \"" + constants.file +
                       "\" is no C++ namespace: rename the file");
      continue;
    }
    const auto same =
        std::find_if(manifest.constants.begin(), manifest.constants.end(),
                     [&](const ManifestConstants& c) { return c.space == constants.space; });
    if (same != manifest.constants.end()) {
      checks.error(node.line, "PK318",
                   "the constants of \"" + constants.file + "\" get the namespace of those of \"" +
                       same->file + "\" in line " + std::to_string(same->line) +
                       ": name a file once, and give files different names");
      continue;
    }
    manifest.constants.push_back(constants);
  }
}

void checkName(const ManifestKernel& kernel, const std::string& where,
               const std::vector<ManifestKernel>& others, NodeChecks& checks) {
  if (!isIdentifier(kernel.name) ||
      std::any_of(kernel.name.begin(), kernel.name.end(),
                  [](unsigned char c) { return std::isupper(c) != 0; })) {
    checks.error(kernel.line, "PK304",
                 "\"" + kernel.name + "\" is not a kernel name; write it like \"skin_roots\"");
  }
  for (const ManifestKernel& other : others) {
    if (camelCase(other.name) == camelCase(kernel.name)) {
      checks.error(kernel.line, "PK307",
                   where + " is there twice, or gives the same C++ name as \"" + other.name +
                       "\" in line " + std::to_string(other.line));
    }
  }
}

void readStage(const Node& stage, ManifestKernel& kernel, const std::string& where,
               NodeChecks& checks) {
  if (stage.string == "compute") {
    kernel.stage = Stage::kCompute;
  } else if (stage.string == "vertex") {
    kernel.stage = Stage::kVertex;
  } else if (stage.string == "pixel") {
    kernel.stage = Stage::kPixel;
  } else {
    checks.error(stage.line, "PK302",
                 where + ": stage \"" + stage.string + "\" is none of compute, vertex, pixel");
  }
}

void readValues(const Node& values, Axis& axis, const std::string& where, NodeChecks& checks) {
  if (!checks.expect(values, Node::Type::kArray, "\"values\"")) return;
  axis.isBool = false;
  axis.values.clear();
  for (const Node& value : values.children) {
    if (!checks.expect(value, Node::Type::kInteger, "a value of axis \"" + axis.name + "\""))
      continue;
    if (value.integer < 0 || value.integer > 1'000'000 ||
        std::find(axis.values.begin(), axis.values.end(), value.integer) != axis.values.end()) {
      checks.error(value.line, "PK313",
                   where + ": value " + std::to_string(value.integer) + " of axis \"" + axis.name +
                       "\" is there twice or not in 0..1000000");
      continue;
    }
    axis.values.push_back(static_cast<int32_t>(value.integer));
  }
  if (axis.values.empty()) {
    checks.error(values.line, "PK313", where + ": axis \"" + axis.name + "\" has no values");
    axis.values.push_back(0);
  }
}

Tier readTier(const Node& node, const std::string& where, NodeChecks& checks) {
  if (!checks.expect(node, Node::Type::kString, "\"tier\"")) return Tier::kBase;
  const std::optional<Tier> tier = tierFromName(node.string);
  if (!tier) {
    checks.error(node.line, "PK302",
                 where + ": \"tier\" is \"es\", \"base\" (default) or \"wide\", not \"" +
                     node.string + "\"");
  }
  return tier.value_or(Tier::kBase);
}

size_t countPermutations(const ManifestKernel& kernel) {
  size_t count = 1;
  for (const Axis& axis : kernel.axes) {
    if (count > kMaximumPermutations) break;
    count *= axis.values.size();
  }
  return count;
}

// Returns false for a kernel with so many permutations that nothing can go on with it.
bool checkPermutations(const ManifestKernel& kernel, const std::string& where, NodeChecks& checks) {
  if (countPermutations(kernel) > kMaximumPermutations) {
    checks.error(kernel.line, "PK310",
                 where + " has " + std::to_string(countPermutations(kernel)) +
                     " permutations, more than " + std::to_string(kMaximumPermutations) +
                     "; make some axes specialization constants");
    return false;
  }
  if (kernel.permutations().empty()) {
    checks.error(kernel.line, "PK311", where + ": all permutations are excluded");
  } else if (kernel.isExcluded(kernel.defaultPermutation())) {
    checks.error(kernel.line, "PK311",
                 where + ": the default permutation (false, or the first value) is excluded");
  }
  return true;
}

void checkCompletion(const ManifestKernel& kernel, const std::string& where, NodeChecks& checks) {
  const KeyCompletion completion = completeKeys(kernel);
  if (completion.incomplete) {
    checks.error(kernel.line, "PK316",
                 where + ": no permutation has all of \"" +
                     permutationKey(kernel, *completion.incomplete) +
                     "\"; if no key may ask for that, write its exclusion under \"conflicts\"");
  }
  if (!completion.ambiguous.empty()) {
    checks.error(kernel.line, "PK317",
                 where + ": \"" + permutationKey(kernel, completion.ambiguous[0]) +
                     "\" could be completed to \"" +
                     permutationKey(kernel, completion.ambiguous[1]) + "\" or to \"" +
                     permutationKey(kernel, completion.ambiguous[2]) +
                     "\": exclude one of them, or both");
  }
}

class KernelReader {
 public:
  KernelReader(ManifestKernel& kernel, const std::string& where, NodeChecks& checks)
      : kernel_(kernel), where_(where), checks_(checks) {}

  void read(const Node& node, const fs::path& folder, const std::vector<ManifestGroup>& groups) {
    readSource(node, folder, groups);
    if (const Node* axes = node.find("axes")) readAxes(*axes);
    if (const Node* exclude = node.find("exclude"))
      kernel_.excludes = readExclusions(*exclude, false);
    if (const Node* conflicts = node.find("conflicts")) {
      kernel_.conflicts = readExclusions(*conflicts, true);
      kernel_.excludes.insert(kernel_.excludes.end(), kernel_.conflicts.begin(),
                              kernel_.conflicts.end());
    }
    if (const Node* tier = node.find("tier")) kernel_.tier = readTier(*tier, where_, checks_);
    if (const Node* rules = node.find("tiers")) readTierRules(*rules);
    if (const Node* list = node.find("noWebgpu")) readWebgpuExceptions(*list);
    checks_.readBool(node, "precise", kernel_.precise);
    checks_.readBool(node, "commutes", kernel_.commutes);
    if (const Node* input = node.find("vertexInput")) readVertexInput(*input);
  }

 private:
  // The file, stage and group of the kernel.
  void readSource(const Node& node, const fs::path& folder,
                  const std::vector<ManifestGroup>& groups) {
    if (const Node* file = checks_.require(node, "file", Node::Type::kString, where_)) {
      kernel_.file = file->string;
      if (!isFile(folder / kernel_.file)) {
        checks_.error(file->line, "PK308", where_ + ": there is no file \"" + kernel_.file + "\"");
      }
    }
    if (const Node* stage = checks_.require(node, "stage", Node::Type::kString, where_)) {
      readStage(*stage, kernel_, where_, checks_);
    }
    if (const Node* group = checks_.require(node, "group", Node::Type::kString, where_)) {
      const auto found = std::find_if(groups.begin(), groups.end(), [&](const ManifestGroup& g) {
        return g.name == group->string;
      });
      if (found == groups.end()) {
        checks_.error(group->line, "PK309",
                      where_ + ": there is no group \"" + group->string + "\"");
      } else {
        kernel_.group = static_cast<uint32_t>(found - groups.begin());
      }
    }
  }

  void readVertexInput(const Node& node) {
    const std::string what = "\"vertexInput\" of " + where_;
    if (!checks_.expect(node, Node::Type::kObject, what)) return;
    checks_.allowKeys(node, {"stride", "step", "offsets"}, what);
    if (kernel_.stage != Stage::kVertex) {
      checks_.error(node.line, "PK302", where_ + ": only vertex kernels have a \"vertexInput\"");
    }
    // The least that every API takes as a stride (GL_MAX_VERTEX_ATTRIB_STRIDE,
    // maxVertexInputBindingStride) and as an offset.
    constexpr int64_t kMaximumStride = 2048, kMaximumOffset = 2047;
    ManifestVertexInput input;
    if (const Node* stride = checks_.require(node, "stride", Node::Type::kInteger, what)) {
      input.stride = static_cast<uint32_t>(std::clamp<int64_t>(stride->integer, 0, kMaximumStride));
      if (stride->integer != input.stride || input.stride == 0 || input.stride % 4 != 0) {
        checks_.error(
            stride->line, "PK302",
            what + ": \"stride\" is a multiple of 4 from 4 to " + std::to_string(kMaximumStride));
      }
    }
    if (const Node* step = checks_.require(node, "step", Node::Type::kString, what)) {
      input.perInstance = step->string == "instance";
      if (!input.perInstance && step->string != "vertex")
        checks_.error(step->line, "PK302", what + ": \"step\" is \"vertex\" or \"instance\"");
    }
    if (const Node* offsets = checks_.require(node, "offsets", Node::Type::kArray, what)) {
      for (const Node& offset : offsets->children) {
        const bool fits = offset.type == Node::Type::kInteger && offset.integer >= 0 &&
                          offset.integer <= kMaximumOffset && offset.integer % 4 == 0;
        if (!fits) {
          checks_.error(
              offset.line, "PK302",
              what + ": an offset is a multiple of 4 from 0 to " + std::to_string(kMaximumOffset));
        }
        input.offsets.push_back(fits ? static_cast<uint32_t>(offset.integer) : 0);
      }
    }
    kernel_.vertexInput = std::move(input);
  }

  void readAxes(const Node& axes) {
    if (!checks_.expect(axes, Node::Type::kArray, "\"axes\"")) return;
    for (const Node& node : axes.children) {
      if (!checks_.expect(node, Node::Type::kObject, "an axis")) continue;
      const Node* name = checks_.require(node, "name", Node::Type::kString, "an axis of " + where_);
      if (name == nullptr) continue;
      Axis axis;
      axis.name = name->string;
      checks_.allowKeys(node, {"name", "values"}, "axis \"" + axis.name + "\"");
      if (!isIdentifier(axis.name) || std::isupper(static_cast<unsigned char>(axis.name[0])) != 0) {
        checks_.error(name->line, "PK304",
                      "\"" + axis.name + "\" is not an axis name; write it like \"globalShape\"");
        continue;
      }
      for (const Axis& other : kernel_.axes) {
        if (macroName(other.name) == macroName(axis.name)) {
          checks_.error(name->line, "PK312",
                        where_ + ": axes \"" + other.name + "\" and \"" + axis.name +
                            "\" have the same macro " + macroName(axis.name));
        }
      }
      if (const Node* values = node.find("values")) readValues(*values, axis, where_, checks_);
      kernel_.axes.push_back(std::move(axis));
    }
  }

  void readTierRules(const Node& list) {
    if (!checks_.expect(list, Node::Type::kArray, "\"tiers\"")) return;
    for (const Node& node : list.children) {
      if (!checks_.expect(node, Node::Type::kObject, "a tier of permutations")) continue;
      const std::string rule = "a tier of permutations of " + where_;
      checks_.allowKeys(node, {"when", "tier"}, rule);
      const Node* when = checks_.require(node, "when", Node::Type::kObject, rule);
      const Node* tier = checks_.require(node, "tier", Node::Type::kString, rule);
      if (when == nullptr || tier == nullptr) continue;
      const size_t saidBefore = checks_.reported();
      TierRule read;
      read.tier = readTier(*tier, where_, checks_);
      read.conditions = readConditions(*when, false);
      if (checks_.reported() != saidBefore) continue;
      if (read.conditions.empty() || read.tier <= kernel_.tier) {
        checks_.error(node.line, "PK319",
                      where_ +
                          ": \"when\" names axes and their values, and the tier is higher than \"" +
                          tierName(kernel_.tier) + "\", which all permutations have");
        continue;
      }
      kernel_.tierRules.push_back(std::move(read));
    }
  }

  void readWebgpuExceptions(const Node& list) {
    if (!checks_.expect(list, Node::Type::kArray, "\"noWebgpu\"")) return;
    for (const Node& node : list.children) {
      if (!checks_.expect(node, Node::Type::kObject, "an exception")) continue;
      const std::string rule = "an exception of " + where_;
      checks_.allowKeys(node, {"when", "why"}, rule);
      WebgpuException read;
      if (const Node* why = checks_.require(node, "why", Node::Type::kString, rule))
        read.why = why->string;
      const Node* when = node.find("when");
      if (when != nullptr && checks_.expect(*when, Node::Type::kObject, "\"when\" of " + rule))
        read.conditions = readConditions(*when, false);
      kernel_.webgpuExceptions.push_back(std::move(read));
    }
  }

  std::vector<std::vector<AxisValue>> readExclusions(const Node& list, bool areConflicts) {
    std::vector<std::vector<AxisValue>> exclusions;
    if (!checks_.expect(list, Node::Type::kArray, areConflicts ? "\"conflicts\"" : "\"exclude\""))
      return exclusions;
    for (const Node& node : list.children) {
      if (!checks_.expect(node, Node::Type::kObject, "an exclusion")) continue;
      if (node.keys.empty()) {
        checks_.error(node.line, "PK314",
                      where_ + ": an exclusion without an axis excludes everything");
        continue;
      }
      std::vector<AxisValue> conditions = readConditions(node, areConflicts);
      if (!conditions.empty()) exclusions.push_back(std::move(conditions));
    }
    return exclusions;
  }

  std::vector<AxisValue> readConditions(const Node& node, bool areConflicts) {
    std::vector<AxisValue> conditions;
    for (size_t i = 0; i < node.keys.size() && i < node.children.size(); ++i) {
      const auto axis = std::find_if(kernel_.axes.begin(), kernel_.axes.end(),
                                     [&](const Axis& a) { return a.name == node.keys[i]; });
      if (axis == kernel_.axes.end()) {
        checks_.error(node.keyLines[i], "PK314", where_ + " has no axis \"" + node.keys[i] + "\"");
        continue;
      }
      const Node& value = node.children[i];
      if (!checks_.expect(value, axis->isBool ? Node::Type::kBool : Node::Type::kInteger,
                          "the value of axis \"" + axis->name + "\"")) {
        continue;
      }
      const int64_t number = axis->isBool ? int64_t{value.boolean} : value.integer;
      if (std::find(axis->values.begin(), axis->values.end(), number) == axis->values.end()) {
        checks_.error(
            value.line, "PK314",
            where_ + ": axis \"" + axis->name + "\" has no value " + std::to_string(number));
        continue;
      }
      if (areConflicts && axis->isBool && number == 0) {
        checks_.error(value.line, "PK315",
                      where_ + ": a conflict with axis \"" + axis->name +
                          "\" off ends when it is switched on: write it under \"exclude\"");
        continue;
      }
      conditions.emplace_back(static_cast<uint32_t>(axis - kernel_.axes.begin()),
                              static_cast<int32_t>(number));
    }
    return conditions;
  }

  ManifestKernel& kernel_;
  const std::string& where_;  // in messages
  NodeChecks& checks_;
};

void readKernel(const Node& node, const fs::path& folder, Manifest& manifest, NodeChecks& checks) {
  if (!checks.expect(node, Node::Type::kObject, "a kernel")) return;
  const size_t reported = checks.reported();
  const Node* name = checks.require(node, "name", Node::Type::kString, "a kernel");
  if (name == nullptr) return;
  ManifestKernel kernel;
  kernel.name = name->string;
  kernel.line = name->line;
  const std::string where = "kernel \"" + kernel.name + "\"";
  checks.allowKeys(node,
                   {"name", "file", "stage", "group", "axes", "exclude", "conflicts", "tier",
                    "tiers", "precise", "commutes", "vertexInput", "noWebgpu"},
                   where);
  checkName(kernel, where, manifest.kernels, checks);
  KernelReader(kernel, where, checks).read(node, folder, manifest.groups);
  if (!checkPermutations(kernel, where, checks)) return;
  if (checks.reported() == reported) checkCompletion(kernel, where, checks);
  manifest.kernels.push_back(std::move(kernel));
}

void readRoot(const Node& root, const fs::path& folder, Manifest& manifest, NodeChecks& checks) {
  const std::string what = "the manifest";
  if (!checks.expect(root, Node::Type::kObject, what)) return;
  checks.allowKeys(root, {"namespace", "groups", "constants", "kernels", "webgpu"}, what);
  checks.readBool(root, "webgpu", manifest.webgpu);
  readNamespace(root, manifest, checks);
  if (const Node* constants = root.find("constants"))
    readConstantFiles(*constants, folder, manifest, checks);
  if (const Node* groups = checks.require(root, "groups", Node::Type::kObject, what))
    readGroups(*groups, manifest, checks);
  if (const Node* kernels = checks.require(root, "kernels", Node::Type::kArray, what)) {
    for (const Node& kernel : kernels->children) readKernel(kernel, folder, manifest, checks);
  }
}

bool allHold(const std::vector<AxisValue>& conditions, const Permutation& permutation) {
  return std::all_of(conditions.begin(), conditions.end(), [&](const AxisValue& condition) {
    return permutation[condition.first] == condition.second;
  });
}

bool anyHolds(const std::vector<std::vector<AxisValue>>& exclusions,
              const Permutation& permutation) {
  return std::any_of(exclusions.begin(), exclusions.end(),
                     [&](const auto& conditions) { return allHold(conditions, permutation); });
}

}  // namespace

bool ManifestKernel::isExcluded(const Permutation& permutation) const {
  return anyHolds(excludes, permutation);
}

bool ManifestKernel::isConflict(const Permutation& permutation) const {
  return anyHolds(conflicts, permutation);
}

Permutation ManifestKernel::defaultPermutation() const {
  Permutation permutation;
  for (const Axis& axis : axes) permutation.push_back(axis.values.front());
  return permutation;
}

std::vector<Permutation> ManifestKernel::combinations() const {
  std::vector<Permutation> all{{}};
  for (const Axis& axis : axes) {
    std::vector<Permutation> longer;
    for (const Permutation& prefix : all) {
      for (const int32_t value : axis.values) {
        longer.push_back(prefix);
        longer.back().push_back(value);
      }
    }
    all = std::move(longer);
  }
  return all;
}

std::vector<Permutation> ManifestKernel::permutations() const {
  std::vector<Permutation> all = combinations();
  std::erase_if(all, [this](const Permutation& p) { return isExcluded(p); });
  return all;
}

Tier ManifestKernel::tierOf(const Permutation& permutation) const {
  Tier highest = tier;
  for (const TierRule& rule : tierRules)
    if (allHold(rule.conditions, permutation)) highest = std::max(highest, rule.tier);
  return highest;
}

const std::string* ManifestKernel::whyNotWebgpu(const Permutation& permutation) const {
  for (const WebgpuException& exception : webgpuExceptions)
    if (allHold(exception.conditions, permutation)) return &exception.why;
  return nullptr;
}

bool Manifest::groupsFit(uint32_t a, uint32_t b) const {
  const std::vector<std::string>& first = groups[a].layouts;
  const std::vector<std::string>& second = groups[b].layouts;
  const auto shared = static_cast<std::ptrdiff_t>(std::min(first.size(), second.size()));
  return std::equal(first.begin(), first.begin() + shared, second.begin());
}

std::string Manifest::namespaceName() const {
  std::string name;
  for (const std::string& part : namespaceParts) name += (name.empty() ? "" : "::") + part;
  return name;
}

std::string Manifest::namespaceFolder() const {
  std::string name;
  for (const std::string& part : namespaceParts) name += (name.empty() ? "" : "/") + part;
  return name;
}

Manifest readManifest(const fs::path& path, Diagnostics& diagnostics) {
  Manifest manifest;
  manifest.file = path.filename().string();
  const std::optional<std::string> text = readWholeFile(path);
  if (!text) {
    diagnostics.error(manifest.file, 1, "PK300", "cannot open the manifest " + path.string());
    return manifest;
  }
  uint32_t line = 1;
  TreeBuilder builder(line, manifest.file, diagnostics);
  if (nlohmann::json::sax_parse(LineIterator(text->data(), &line),
                                LineIterator(text->data() + text->size(), &line), &builder)) {
    NodeChecks checks(manifest.file, diagnostics);
    readRoot(builder.root, path.parent_path(), manifest, checks);
  }
  return manifest;
}

std::string macroName(const std::string& axis) {
  std::string name;
  for (const char c : axis) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isupper(u) != 0 && !name.empty()) name += '_';
    name += static_cast<char>(std::toupper(u));
  }
  return name;
}

std::string permutationKey(const ManifestKernel& kernel, const Permutation& permutation) {
  std::string key;
  for (size_t i = 0; i < kernel.axes.size(); ++i) {
    key += (key.empty() ? "" : " ") + kernel.axes[i].name + "=" + std::to_string(permutation[i]);
  }
  return key;
}

}  // namespace pelage::codegen
