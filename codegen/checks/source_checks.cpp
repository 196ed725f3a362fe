#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>

#include "codegen/checks/checks.h"
#include "codegen/checks/source_model.h"
#include "codegen/checks/token_stream.h"

namespace pelage::codegen {

using namespace checks;

namespace {

using std::string_view_literals::operator""sv;

template <size_t N>
bool contains(const std::array<std::string_view, N>& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

// A forbidden word. `call`: only if a '(' follows and the file defines no such function.
struct Word {
  std::string_view text;
  const char* code;
  bool call;
  const char* message;
};

constexpr std::array kWords = {
    Word{"template", "PK102", false, "no templates: write one function for each type, or a macro"},
    Word{"typename", "PK102", false, "no templates: write one function for each type, or a macro"},
    Word{"enum", "PK103", false, "no enum: write static const uint kName = value;"},
    Word{"interface", "PK105", false, "no interfaces: write plain functions"},
    Word{"using", "PK106", false, "no using: write a typedef, or the whole name"},
    Word{"NonUniformResourceIndex", "PK110", false,
         "no NonUniformResourceIndex: arrays of resources are not portable; put the data in one "
         "buffer or one texture array and index that"},
    Word{"fma", "PK114", true,
         "fma() becomes double precision and GLES refuses it: write mad(a, b, c)"},
    Word{"ldexp", "PK115", true, "ldexp() becomes invalid SPIR-V: write x * exp2(e)"},
    Word{"InterlockedCompareStore", "PK116", false,
         "InterlockedCompareStore is dropped in silence: write InterlockedCompareExchange and "
         "ignore the original value"},
    Word{"InterlockedCompareStoreFloatBitwise", "PK116", false,
         "InterlockedCompareStoreFloatBitwise is not portable: keep the float as uint (asuint) and "
         "write InterlockedCompareExchange"},
};

constexpr std::array kNarrowOrWide = {
    "half"sv,    "half2"sv,    "half3"sv,          "half4"sv,           "double"sv,  "double2"sv,
    "double3"sv, "double4"sv,  "float16_t"sv,      "float64_t"sv,       "int16_t"sv, "uint16_t"sv,
    "int64_t"sv, "uint64_t"sv, "int8_t4_packed"sv, "uint8_t4_packed"sv,
};

constexpr std::array kNarrowPrefixes = {"min16float"sv, "min10float"sv, "min16int"sv, "min12int"sv,
                                        "min16uint"sv,  "float16_t"sv,  "int16_t"sv,  "uint16_t"sv,
                                        "int64_t"sv,    "uint64_t"sv,   "float64_t"sv};

constexpr std::array kCombinedSamplers = {"sampler1D"sv, "sampler2D"sv, "sampler3D"sv,
                                          "samplerCUBE"sv, "sampler"sv};

constexpr std::array kAssignments = {"="sv,  "+="sv, "-="sv, "*="sv, "/="sv, "%="sv,
                                     "&="sv, "|="sv, "^="sv, "++"sv, "--"sv};

// Attributes that the front end knows in each scope; it ignores the others.
constexpr std::array kVulkanAttributes = {"push_constant"sv, "constant_id"sv, "binding"sv,
                                          "location"sv, "input_attachment_index"sv};

bool isStructuredBuffer(std::string_view type) {
  return type == "StructuredBuffer" || type == "RWStructuredBuffer" ||
         type == "AppendStructuredBuffer" || type == "ConsumeStructuredBuffer";
}
bool isByteAddressBuffer(std::string_view type) {
  return type == "ByteAddressBuffer" || type == "RWByteAddressBuffer";
}
bool isStorageTexture(std::string_view type) {
  return type.starts_with("RWTexture") || type == "RWBuffer";
}
bool isConstantBuffer(std::string_view type) {
  return type == "ConstantBuffer" || type == "TextureBuffer";
}
bool isResource(std::string_view type) {
  return isStructuredBuffer(type) || isByteAddressBuffer(type) || isStorageTexture(type) ||
         isConstantBuffer(type) || type.starts_with("Texture") || type == "Buffer" ||
         type == "SamplerState" || type == "SamplerComparisonState" ||
         type.starts_with("Rasterizer");
}

bool isNotWide(std::string_view type) {
  if (contains(kNarrowOrWide, type)) return true;
  return std::any_of(
      kNarrowPrefixes.begin(), kNarrowPrefixes.end(), [type](std::string_view prefix) {
        if (!type.starts_with(prefix)) return false;
        // "float16_t3x3", "min16float4": only a dimension may follow.
        const std::string_view rest = type.substr(prefix.size());
        return rest.empty() || (rest.size() == 1 && rest[0] >= '1' && rest[0] <= '4') ||
               (rest.size() == 3 && rest[1] == 'x');
      });
}

// "_11_22" or "_m00_m11": two elements or more.
bool isMatrixSwizzle(std::string_view text) {
  size_t elements = 0;
  while (!text.empty()) {
    if (text.front() != '_') return false;
    text.remove_prefix(1);
    if (text.starts_with('m')) text.remove_prefix(1);
    if (text.size() < 2 || text[0] < '0' || text[0] > '4' || text[1] < '0' || text[1] > '4') {
      return false;
    }
    text.remove_prefix(2);
    ++elements;
  }
  return elements >= 2;
}

// Rows and columns of a value type, {1, 3} for float3; nothing for a struct or an unknown name.
struct Shape {
  uint32_t rows = 1, columns = 1;
  bool isMatrix = false;
};

std::string registerClass(std::string_view type) {
  if (type == "ConstantBuffer") return "b";
  if (type.starts_with("Sampler")) return "s";
  if (type.starts_with("RW") || type.starts_with("Append") || type.starts_with("Consume") ||
      type.starts_with("Rasterizer")) {
    return "u";
  }
  return "t";
}

std::optional<uint32_t> dimension(std::string_view text) {
  if (text.size() == 1 && text[0] >= '1' && text[0] <= '4') {
    return static_cast<uint32_t>(text[0] - '0');
  }
  return std::nullopt;
}

// The preprocessed kernel, and what its names stand for.
class Source {
 public:
  Source(const CheckInput& input, Diagnostics& diagnostics)
      : stream(tokenize(input.preprocessed, input.file)),
        model(parseSource(stream)),
        diagnostics_(diagnostics) {}

  const Token& at(size_t i) const { return stream.at(i); }
  bool is(size_t i, std::string_view text) const { return at(i).is(text); }

  void error(size_t token, const char* code, std::string message) const {
    diagnostics_.error(stream.fileOf(at(token)), at(token).line, code, std::move(message));
  }

  std::string_view resolve(std::string_view type, TokenRange* arguments = nullptr) const {
    // A chain of typedefs is at most as long as their number.
    for (size_t i = 0; i <= model.typedefs.size(); ++i) {
      const auto found = model.typedefs.find(type);
      if (found == model.typedefs.end()) break;
      type = found->second.type;
      if (arguments) *arguments = found->second.typeArguments;
    }
    return type;
  }

  std::optional<Shape> shapeOf(std::string_view type, TokenRange arguments) const {
    type = resolve(type, &arguments);
    if (type == "vector" || type == "matrix") {
      Shape shape{type == "matrix" ? 4u : 1u, 4u, type == "matrix"};
      // <float, 3> or <float, 3, 4>
      std::vector<uint32_t> numbers;
      for (size_t i = arguments.begin; i < arguments.end; ++i) {
        if (const auto number = dimension(at(i).text)) numbers.push_back(*number);
      }
      if (shape.isMatrix && numbers.size() == 2) {
        shape.rows = numbers[0];
        shape.columns = numbers[1];
      } else if (!shape.isMatrix && numbers.size() == 1) {
        shape.columns = numbers[0];
      }
      return shape;
    }
    for (const std::string_view base : {"float"sv, "uint"sv, "int"sv, "bool"sv, "dword"sv}) {
      if (!type.starts_with(base)) continue;
      const std::string_view rest = type.substr(base.size());
      if (rest.empty()) return Shape{};
      if (rest.size() == 1 && dimension(rest)) return Shape{1, *dimension(rest), false};
      if (rest.size() == 3 && rest[1] == 'x' && dimension(rest.substr(0, 1)) &&
          dimension(rest.substr(2))) {
        return Shape{*dimension(rest.substr(0, 1)), *dimension(rest.substr(2)), true};
      }
    }
    return std::nullopt;
  }

  std::string_view elementType(const Declaration& declaration) const {
    size_t i = declaration.typeArguments.begin;
    while (i < declaration.typeArguments.end &&
           (is(i, "row_major") || is(i, "column_major") || is(i, "struct") || is(i, "const"))) {
      ++i;
    }
    return i < declaration.typeArguments.end ? resolve(at(i).text) : std::string_view{};
  }

  // "static const uint kN = 64;"
  bool isStaticNumber(std::string_view name) const {
    return std::any_of(model.globals.begin(), model.globals.end(), [&](const Declaration& global) {
      return at(global.name).is(name) && global.isQualified("static") &&
             global.isQualified("const") &&
             global.initializer.end == global.initializer.begin + 1 &&
             at(global.initializer.begin).kind == TokenKind::kNumber;
    });
  }

  const TokenStream stream;
  const SourceModel model;

 private:
  Diagnostics& diagnostics_;
};

// The front end places a vector on 4 bytes unless it would straddle 16, as Direct3D does; std140
// and std430 align two components to 8, three and four to 16 (OpenGL 4.5 core specification,
// 7.6.2.2). A member where the two differ cannot be written down in GLSL. All else follows std140
// in constant buffers and std430 in structured buffers.
enum class Rules { kStd140, kStd430 };

class BlockLayouts {
 public:
  explicit BlockLayouts(const Source& source) : source_(source) {}

  void check(const Struct& structure, Rules rules) { (void)extentOf(structure, rules, 0); }
  void check(const ConstantBlock& block) { (void)layOut(block.members, Rules::kStd140, 0); }

 private:
  struct Extent {
    uint32_t size = 0, alignment = 4;
  };

  static uint32_t roundUp(uint32_t value, uint32_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
  }

  static constexpr uint32_t vectorAlignment(uint32_t components) {
    return components == 1 ? 4 : components == 2 ? 8 : 16;
  }

  // Returns nothing if a size is not known; members after it are not checked.
  std::optional<Extent> extentOf(const Struct& structure, Rules rules, size_t depth) {
    const auto found = extents_.find({&structure, rules});
    if (found != extents_.end()) return found->second;
    if (depth > source_.model.structs.size()) return std::nullopt;
    const auto extent = layOut(structure.members, rules, depth);
    extents_.emplace(std::pair(&structure, rules), extent);
    return extent;
  }

  std::optional<Extent> layOut(const std::vector<Declaration>& members, Rules rules, size_t depth) {
    // Sizes stay far below 2^32; larger ones are of no use.
    constexpr uint32_t kMaximumSize = 1u << 28;
    Extent all{0, rules == Rules::kStd140 ? 16u : 4u};
    for (const Declaration& member : members) {
      const auto extent = extentOf(member, rules, depth);
      if (!extent || extent->size > kMaximumSize || all.size > kMaximumSize) return std::nullopt;
      const auto shape = source_.shapeOf(member.type, member.typeArguments);
      if (shape && !shape->isMatrix && member.arraySizes.empty()) {
        const bool straddles = all.size % 16 + extent->size > 16;
        const uint32_t start = straddles ? roundUp(all.size, 16) : all.size;
        if (start % extent->alignment != 0) reportLocation(member, start, extent->alignment);
      }
      all.size = roundUp(all.size, extent->alignment) + extent->size;
      all.alignment = std::max(all.alignment, extent->alignment);
    }
    all.size = roundUp(all.size, all.alignment);
    return all;
  }

  std::optional<Extent> extentOf(const Declaration& member, Rules rules, size_t depth) {
    const bool std140 = rules == Rules::kStd140;
    Extent extent;
    if (const auto shape = source_.shapeOf(member.type, member.typeArguments)) {
      // A matrix is an array of its columns, or of its rows when it is row_major.
      const bool byRows = member.isQualified("row_major");
      const uint32_t components = shape->isMatrix && !byRows ? shape->rows : shape->columns;
      extent = {4 * components, vectorAlignment(components)};
      if (shape->isMatrix) {
        if (std140) extent.alignment = 16;
        extent.size =
            roundUp(extent.size, extent.alignment) * (byRows ? shape->rows : shape->columns);
      }
    } else {
      const Struct* structure = source_.model.findStruct(source_.resolve(member.type));
      const auto inner = structure ? extentOf(*structure, rules, depth + 1) : std::nullopt;
      if (!inner) return std::nullopt;
      extent = *inner;
    }
    for (const TokenRange& range : member.arraySizes) {
      const auto count = arraySize(range);
      if (!count) return std::nullopt;
      if (std140) extent.alignment = 16;
      const uint64_t size = uint64_t{roundUp(extent.size, extent.alignment)} * *count;
      if (size > UINT32_MAX / 2) return std::nullopt;
      extent.size = static_cast<uint32_t>(size);
    }
    return extent;
  }

  // A number, or a static const that is one.
  std::optional<uint32_t> arraySize(TokenRange range) const {
    if (range.end != range.begin + 1) return std::nullopt;
    std::string_view text = source_.at(range.begin).text;
    for (const Declaration& global : source_.model.globals) {
      if (source_.at(global.name).is(text) && source_.isStaticNumber(text))
        text = source_.at(global.initializer.begin).text;
    }
    uint32_t value = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string_view suffix = text.substr(static_cast<size_t>(end - text.data()));
    if (failed != std::errc{} || !(suffix.empty() || suffix == "u" || suffix == "U")) {
      return std::nullopt;
    }
    return value;
  }

  void reportLocation(const Declaration& member, uint32_t start, uint32_t alignment) {
    source_.error(member.name, "PK124",
                  quote(source_.at(member.name).text) + " starts at byte " + std::to_string(start) +
                      " as in Direct3D, but in GLSL a " +
                      std::string(source_.resolve(member.type)) + " starts at a multiple of " +
                      std::to_string(alignment) +
                      ": put it first in its 16 bytes, or add padding before it");
  }

  const Source& source_;
  std::map<std::pair<const Struct*, Rules>, std::optional<Extent>> extents_;
};

void checkPackOffset(const Declaration& member, const Source& source) {
  if (member.packOffset != 0) {
    source.error(
        member.packOffset, "PK123",
        "packoffset cannot be expressed in GLSL: order the members, and pad them to 16 bytes");
  }
}

void reportVector3(size_t token, std::string_view type, const Source& source) {
  source.error(
      token, "PK125",
      std::string(type) +
          " in a structured buffer takes 16 bytes here and 12 in Direct3D: use a type of two "
          "or four components, or single floats");
}

void collectStructs(const std::vector<Declaration>& members, std::set<std::string_view>& names,
                    size_t depth, const Source& source) {
  if (depth > source.model.structs.size()) return;
  for (const Declaration& member : members) {
    const std::string_view type = source.resolve(member.type);
    if (const Struct* structure = source.model.findStruct(type);
        structure && names.insert(type).second) {
      collectStructs(structure->members, names, depth + 1, source);
    }
  }
}

class DeclarationChecks {
 public:
  explicit DeclarationChecks(const Source& source) : source_(source), layouts_(source) {}

  void run() {
    std::set<std::string_view> inBlocks;
    for (const ConstantBlock& block : source_.model.blocks) {
      layouts_.check(block);
      collectStructs(block.members, inBlocks, 0, source_);
      const auto isPush = [](const Attribute& a) { return a.name == "push_constant"; };
      const bool push = std::any_of(block.attributes.begin(), block.attributes.end(), isPush);
      if (!block.hasRegister && !push) {
        source_.error(
            block.nameToken, "PK131",
            "cbuffer " + quote(block.name) + " has no register: add : register(bN, spaceM)");
      }
      if (block.hasRegister && push) {
        source_.error(block.nameToken, "PK113",
                      "a push constant has no register: remove it from " + quote(block.name));
      }
    }
    for (const Struct& type : source_.model.structs) {
      if (type.base != 0) {
        source_.error(
            type.nameToken, "PK105",
            "struct " + quote(type.name) +
                " has a base, which the front end drops with its members: make it a member");
      }
      for (const Declaration& member : type.members) checkPackOffset(member, source_);
    }
    for (const ConstantBlock& block : source_.model.blocks) {
      for (const Declaration& member : block.members) checkPackOffset(member, source_);
    }
    for (const Declaration& global : source_.model.globals) checkGlobal(global, inBlocks);
    for (const Function& function : source_.model.functions) {
      for (const Declaration& parameter : function.parameters) checkElement(parameter);
    }
  }

 private:
  void checkGlobal(const Declaration& global, const std::set<std::string_view>& inBlocks) {
    const std::string_view name = source_.at(global.name).text;
    const std::string_view type = source_.resolve(global.type);
    const bool push = global.findAttribute("vk", "push_constant") != nullptr;
    if (push && !isConstantBuffer(type)) {
      source_.error(global.name, "PK113",
                    quote(name) +
                        " becomes a uniform block at binding 0 instead of a push constant: write "
                        "[[vk::push_constant]] ConstantBuffer<" +
                        std::string(type) + "> " + std::string(name) + ";");
    } else if (push && global.hasRegister) {
      source_.error(global.name, "PK113",
                    "a push constant has no register: remove it from " + quote(name));
    }
    if (isResource(type)) {
      if (!push && !global.hasRegister) {
        source_.error(
            global.name, "PK131",
            quote(name) + " has no register: add : register(" + registerClass(type) + "N, spaceM)");
      }
      if (!global.arraySizes.empty() &&
          (isStructuredBuffer(type) || isByteAddressBuffer(type) || isConstantBuffer(type))) {
        source_.error(
            global.name, "PK128",
            "an array of " + std::string(type) +
                " is refused or becomes invalid SPIR-V: put the data in one buffer and add an "
                "offset");
      }
    } else if (!push && !global.isQualified("static") && !global.isQualified("groupshared") &&
               !global.isQualified("const") && !contains(kCombinedSamplers, type)) {
      source_.error(
          global.name, "PK134",
          quote(name) +
              " becomes a uniform in a hidden block at binding 0: put it in a cbuffer, or make "
              "it static const");
    }
    checkElement(global);
    if (isConstantBuffer(type)) {
      const std::string_view element = source_.elementType(global);
      if (const Struct* structure = source_.model.findStruct(element)) {
        layouts_.check(*structure, Rules::kStd140);
      }
      if (inBlocks.count(element) != 0) {
        source_.error(
            global.name, "PK126",
            "struct " + quote(element) +
                " is a member of a cbuffer too, which leaves one of the two without a layout: "
                "declare a second struct for " +
                quote(name));
      }
    }
  }

  // The element of a structured buffer may hold no vector of three.
  void checkElement(const Declaration& declaration) {
    if (!isStructuredBuffer(source_.resolve(declaration.type)) || declaration.typeArguments.empty())
      return;
    const size_t first = declaration.typeArguments.begin;
    TokenRange inner;
    if (source_.is(first + 1, "<")) inner = {first + 2, declaration.typeArguments.end};
    if (const auto shape = source_.shapeOf(source_.at(first).text, inner)) {
      if (shape->columns == 3 || shape->rows == 3)
        reportVector3(declaration.name, source_.at(first).text, source_);
      return;
    }
    const std::string_view element = source_.elementType(declaration);
    checkElementStruct(element, 0);
    if (const Struct* structure = source_.model.findStruct(element)) {
      layouts_.check(*structure, Rules::kStd430);
    }
  }

  void checkElementStruct(std::string_view name, size_t depth) {
    const Struct* structure = source_.model.findStruct(name);
    if (!structure || depth > source_.model.structs.size() || !elements_.insert(name).second)
      return;
    for (const Declaration& member : structure->members) {
      const auto shape = source_.shapeOf(member.type, member.typeArguments);
      if (shape && (shape->columns == 3 || shape->rows == 3)) {
        reportVector3(member.name, member.type, source_);
      } else if (!shape) {
        checkElementStruct(source_.resolve(member.type), depth + 1);
      }
    }
  }

  const Source& source_;
  BlockLayouts layouts_;
  std::set<std::string_view> elements_;
};

void checkGroupSize(const Function& entry, const Source& source) {
  const auto found =
      std::find_if(entry.attributes.begin(), entry.attributes.end(),
                   [](const Attribute& attribute) { return attribute.name == "numthreads"; });
  if (found == entry.attributes.end()) {
    source.error(entry.name, "PK120",
                 quote(source.at(entry.name).text) +
                     " has no [numthreads(x, y, z)]: it would run with one thread a group");
    return;
  }
  for (size_t i = found->arguments.begin; i < found->arguments.end; ++i) {
    if (source.at(i).isIdentifier() && !source.isStaticNumber(source.at(i).text)) {
      source.error(
          i, "PK121",
          quote(source.at(i).text) +
              " in numthreads crashes the front end when it is a specialization constant: use "
              "a number or a macro");
    }
  }
}

void checkEntry(const CheckInput& input, const Source& source, Diagnostics& diagnostics) {
  const Function* entry = nullptr;
  for (const Function& function : source.model.functions) {
    if (source.at(function.name).is(input.entry) && source.at(function.name + 1).is("(") &&
        function.body.begin != 0) {
      entry = &function;
    }
  }
  if (!entry) {
    diagnostics.error(input.file, 1, "PK122",
                      "no function " + quote(input.entry) +
                          " in this file, which would make a valid kernel that does nothing: the "
                          "entry point has the kernel's name");
    return;
  }
  for (const Declaration& parameter : entry->parameters) {
    std::string semantic(parameter.semantic);
    std::transform(semantic.begin(), semantic.end(), semantic.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    if (semantic == "sv_coverage" && !parameter.isQualified("out")) {
      source.error(
          parameter.name, "PK119",
          "SV_Coverage as a parameter of its own is an undefined value: make it a member of "
          "the input struct");
    }
  }
  if (input.stage == Stage::kCompute) checkGroupSize(*entry, source);
}

bool isUnsafeWaveOperation(std::string_view text) {
  const auto startsWord = [text](std::string_view prefix) {
    return text.starts_with(prefix) && text.size() > prefix.size() && text[prefix.size()] >= 'A' &&
           text[prefix.size()] <= 'Z';
  };
  static constexpr std::array kQuad = {
      "QuadReadAcrossX"sv, "QuadReadAcrossY"sv, "QuadReadAcrossDiagonal"sv,
      "QuadReadLaneAt"sv,  "QuadAny"sv,         "QuadAll"sv};
  if (contains(kQuad, text)) return true;
  if (text == "WaveActiveAllTrue" || text == "WaveActiveAnyTrue") return false;
  return startsWord("WaveActive") || startsWord("WaveRead") || startsWord("WavePrefix") ||
         startsWord("WaveGet") || startsWord("WaveMultiPrefix") || text == "WaveMatch" ||
         text == "WaveIsFirstLane" || text == "WaveIsHelperLane";
}

void checkWord(size_t i, const std::set<std::string_view>& functions, const Source& source) {
  const std::string_view text = source.at(i).text;
  const bool called = source.is(i + 1, "(");
  const bool isMember = i > 0 && (source.is(i - 1, ".") || source.is(i - 1, "::"));
  for (const Word& word : kWords) {
    if (text != word.text || (word.call && (!called || isMember || functions.count(text) != 0))) {
      continue;
    }
    source.error(i, word.code, word.message);
    return;
  }
  if (isMember) {
    if (isMatrixSwizzle(text) && source.is(i - 1, ".")) {
      source.error(i, "PK117",
                   "the matrix swizzle ." + std::string(text) +
                       " becomes invalid SPIR-V: take the elements one by one, m[row][column]");
    }
    return;
  }
  if (text == "operator") {
    source.error(i, "PK104", "no operator overloading: write a named function");
  } else if (text.starts_with("RasterizerOrdered")) {
    source.error(i, "PK107",
                 "no " + std::string(text) +
                     ": sort in a second pass, or keep a list a pixel with InterlockedExchange");
  } else if (isNotWide(text)) {
    source.error(i, "PK108", "no " + std::string(text) + ": only 32-bit types are portable");
  } else if (called && isUnsafeWaveOperation(text)) {
    source.error(
        i, "PK109",
        std::string(text) +
            "() has no portable form in GLSL: use groupshared memory; of the wave operations "
            "only WaveActiveAllTrue and WaveActiveAnyTrue are safe");
  } else if (contains(kCombinedSamplers, text) && source.at(i + 1).isIdentifier()) {
    source.error(i, "PK133",
                 std::string(text) +
                     " is a combined image-sampler without a binding: declare a Texture and a "
                     "SamplerState");
  }
}

void checkDoubleAttribute(size_t open, const Source& source) {
  const size_t close = source.stream.matching(open + 1);
  for (size_t i = open + 2; i < close; ++i) {
    if (source.is(i, "(")) i = source.stream.matching(i);
    if (source.is(i, ",")) {
      source.error(i, "PK111", "two attributes in one [[ ]] are not understood: write [[a]] [[b]]");
      return;
    }
  }
  if (!source.is(open + 3, "::")) return;
  const std::string_view scope = source.at(open + 2).text, name = source.at(open + 4).text;
  const bool known = scope == "vk"
                         ? contains(kVulkanAttributes, name)
                         : scope == "spv" && (name.starts_with("format_") ||
                                              name == "nonwritable" || name == "nonreadable");
  if (known) return;
  std::string message = "[[" + std::string(scope) + "::" + std::string(name) + "]] is ignored";
  if (name == "image_format") {
    message += ": write [[spv::format_rgba8]] (or another format) before the texture";
  } else if (name == "counter_binding") {
    message += ": keep the counter in a buffer of its own";
  } else {
    message += ": remove it";
  }
  source.error(open + 4, "PK112", std::move(message));
}

void checkTokens(const Source& source) {
  std::set<std::string_view> functions;
  for (const Function& function : source.model.functions)
    functions.insert(source.at(function.name).text);
  for (size_t i = 0; i < source.stream.end(); ++i) {
    const Token& token = source.at(i);
    if (token.kind == TokenKind::kDirective) {
      if (token.text.find("pragma") != std::string_view::npos &&
          token.text.find("once") != std::string_view::npos) {
        source.error(
            i, "PK101",
            "#pragma once does nothing here: write an include guard (#ifndef, #define, #endif)");
      }
    } else if (token.isIdentifier()) {
      checkWord(i, functions, source);
    } else if (token.is("[") && source.is(i + 1, "[") && source.at(i + 2).isIdentifier()) {
      checkDoubleAttribute(i, source);
    }
  }
}

// "t[p].x = v", "t[p][1] += v", and ++ or -- on one component.
void checkTexelWrite(size_t name, const Source& source) {
  const size_t close = source.stream.matching(name + 1);
  size_t next = close + 1;
  if (source.is(next, ".") && source.at(next + 1).isIdentifier()) {
    next += 2;
  } else if (source.is(next, "[")) {
    next = source.stream.matching(next) + 1;
  } else {
    return;
  }
  const bool prefixed = name > 0 && (source.is(name - 1, "++") || source.is(name - 1, "--"));
  if (prefixed || contains(kAssignments, source.at(next).text)) {
    source.error(
        name, "PK130",
        "a part of a texel cannot be written: read the whole texel, change it, write it back");
  }
}

// Names of resources.
struct Names {
  std::set<std::string_view> byteBuffers, storageTextures, constantBuffers;
};

void checkBody(const Function& function, const Names& names, const Source& source) {
  std::set<std::string_view> parameters, byteBuffers, textures;
  for (const Declaration& parameter : function.parameters) {
    const std::string_view name = source.at(parameter.name).text,
                           type = source.resolve(parameter.type);
    parameters.insert(name);
    if (isByteAddressBuffer(type)) byteBuffers.insert(name);
    if (isStorageTexture(type)) textures.insert(name);
  }
  const auto named = [&parameters](std::string_view name, const std::set<std::string_view>& local,
                                   const std::set<std::string_view>& global) {
    return local.count(name) != 0 || (parameters.count(name) == 0 && global.count(name) != 0);
  };
  for (size_t i = function.body.begin; i < function.body.end; ++i) {
    const Token& token = source.at(i);
    if (!token.isIdentifier() || source.is(i - 1, ".")) continue;
    if (source.is(i + 1, ".") && source.is(i + 2, "GetDimensions") &&
        named(token.text, byteBuffers, names.byteBuffers)) {
      source.error(i, "PK118",
                   "GetDimensions of a ByteAddressBuffer counts 32-bit elements here and bytes in "
                   "Direct3D: pass the size in a constant buffer");
    }
    if (token.text.starts_with("Interlocked") && source.is(i + 1, "(") &&
        textures.count(source.at(i + 2).text) != 0) {
      source.error(i, "PK129",
                   "an atomic on the texture parameter " + quote(source.at(i + 2).text) +
                       " becomes invalid SPIR-V: name the global texture");
    }
    if (source.is(i + 1, "[") && named(token.text, textures, names.storageTextures))
      checkTexelWrite(i, source);
    if (names.constantBuffers.count(token.text) != 0 && parameters.count(token.text) == 0) {
      const size_t next = source.is(i + 1, "[") ? source.stream.matching(i + 1) + 1 : i + 1;
      if (!source.is(next, ".")) {
        source.error(i, "PK127",
                     "the ConstantBuffer " + quote(token.text) +
                         " cannot be used as a whole: take its members one by one");
      }
    }
  }
}

void checkBodies(const Source& source) {
  Names names;
  for (const Declaration& global : source.model.globals) {
    const std::string_view name = source.at(global.name).text;
    if (isByteAddressBuffer(global.type)) names.byteBuffers.insert(name);
    if (isStorageTexture(global.type)) names.storageTextures.insert(name);
    if (isConstantBuffer(global.type)) names.constantBuffers.insert(name);
  }
  for (const Function& function : source.model.functions) checkBody(function, names, source);
}

}  // namespace

void runSourceChecks(const CheckInput& input, Diagnostics& diagnostics) {
  const Source source(input, diagnostics);
  DeclarationChecks(source).run();
  checkEntry(input, source, diagnostics);
  checkTokens(source);
  checkBodies(source);
}

}  // namespace pelage::codegen
