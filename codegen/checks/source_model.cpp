#include "codegen/checks/source_model.h"

#include <algorithm>
#include <array>

namespace pelage::codegen::checks {
namespace {

constexpr std::array<std::string_view, 26> kQualifiers = {
    "static",       "const",    "groupshared",   "uniform",  "precise",
    "volatile",     "extern",   "inline",        "shared",   "row_major",
    "column_major", "in",       "out",           "inout",    "nointerpolation",
    "linear",       "centroid", "noperspective", "sample",   "globallycoherent",
    "unsigned",     "snorm",    "unorm",         "triangle", "point",
    "export"};

bool isQualifier(std::string_view text) {
  return std::find(kQualifiers.begin(), kQualifiers.end(), text) != kQualifiers.end();
}

// Parses declarations of variables and what they consist of.
class DeclarationParser {
 public:
  explicit DeclarationParser(const TokenStream& stream) : stream_(stream) {}

  const Token& at(size_t i) const { return stream_.at(i); }
  bool is(size_t i, std::string_view text) const { return at(i).is(text); }

  // Behind the '>' that closes the '<' at `open`; `arguments` becomes what is between.
  size_t skipTypeArguments(size_t open, TokenRange& arguments) const {
    size_t depth = 0;
    for (size_t i = open; i < stream_.end(); ++i) {
      if (is(i, "<")) ++depth;
      if (is(i, ">") && --depth == 0) {
        arguments = {open + 1, i};
        return i + 1;
      }
      if (is(i, ";") || is(i, "{") || is(i, "}")) break;
    }
    return open + 1;
  }

  size_t parseAttributes(size_t i, std::vector<Attribute>& attributes) const {
    while (is(i, "[")) {
      const size_t close = stream_.matching(i);
      Attribute attribute;
      attribute.doubled = is(i + 1, "[");
      size_t name = i + (attribute.doubled ? 2 : 1);
      // Each entry of a comma list is an attribute of its own.
      while (name < close && at(name).isIdentifier()) {
        attribute.scope = {};
        if (is(name + 1, "::")) {
          attribute.scope = at(name).text;
          name += 2;
        }
        attribute.name = at(name).text;
        attribute.token = name;
        attribute.arguments = {name + 1, name + 1};
        size_t next = name + 1;
        if (is(next, "(")) {
          const size_t end = stream_.matching(next);
          attribute.arguments = {next + 1, end};
          next = end + 1;
        }
        attributes.push_back(attribute);
        if (!is(next, ",")) break;
        name = next + 1;
      }
      i = close + 1;
    }
    return i;
  }

  // Qualifiers, type and type arguments; behind them. `declaration.type` stays empty when there is
  // no type here.
  size_t parseType(size_t i, Declaration& declaration) const {
    while (at(i).isIdentifier() && isQualifier(at(i).text)) {
      declaration.qualifiers.push_back(at(i).text);
      ++i;
    }
    if (!at(i).isIdentifier()) return i;
    // "struct S s" names a type that was declared before.
    if (is(i, "struct") && at(i + 1).isIdentifier()) ++i;
    while (is(i + 1, "::") && at(i + 2).isIdentifier()) i += 2;
    declaration.type = at(i).text;
    declaration.typeToken = i;
    ++i;
    if (is(i, "<")) i = skipTypeArguments(i, declaration.typeArguments);
    if (is(i, "const")) declaration.qualifiers.push_back(at(i++).text);
    return i;
  }

  // From the name on: arrays, semantics, initialiser. Stops at ',' ';' ')' or '}'.
  size_t parseDeclarator(size_t i, Declaration& declaration) const {
    declaration.name = i++;
    while (is(i, "[")) {
      const size_t close = stream_.matching(i);
      declaration.arraySizes.push_back({i + 1, close});
      i = close + 1;
    }
    while (is(i, ":")) {
      ++i;
      if (is(i, "register")) {
        declaration.hasRegister = true;
      } else if (is(i, "packoffset")) {
        declaration.packOffset = i;
      } else if (at(i).isIdentifier()) {
        declaration.semantic = at(i).text;
      }
      ++i;
      if (is(i, "(")) i = stream_.matching(i) + 1;
    }
    if (is(i, "=")) {
      const size_t begin = ++i;
      while (i < stream_.end() && !is(i, ",") && !is(i, ";") && !is(i, ")") && !is(i, "}")) {
        i = is(i, "(") || is(i, "{") || is(i, "[") ? stream_.matching(i) + 1 : i + 1;
      }
      declaration.initializer = {begin, i};
    }
    return i;
  }

  // "type a[2] : SEMANTIC, b;" to behind the ';'.
  size_t parseVariables(size_t i, const Declaration& prototype,
                        std::vector<Declaration>& result) const {
    for (;;) {
      if (!at(i).isIdentifier()) break;
      Declaration declaration = prototype;
      i = parseDeclarator(i, declaration);
      result.push_back(std::move(declaration));
      if (!is(i, ",")) break;
      ++i;
    }
    while (i < stream_.end() && !is(i, ";") && !is(i, "}")) ++i;
    return is(i, ";") ? i + 1 : i;
  }

  size_t parseParameters(size_t open, std::vector<Declaration>& parameters) const {
    const size_t close = stream_.matching(open);
    size_t i = open + 1;
    while (i < close) {
      Declaration declaration;
      i = parseAttributes(i, declaration.attributes);
      i = parseType(i, declaration);
      if (at(i).isIdentifier() && !declaration.type.empty()) {
        i = parseDeclarator(i, declaration);
        parameters.push_back(std::move(declaration));
      }
      while (i < close && !is(i, ",")) ++i;
      ++i;
    }
    return close + 1;
  }

  // Behind the next ';', braces and what is in them included.
  size_t skipStatement(size_t i) const {
    while (i < stream_.end() && !is(i, ";")) i = is(i, "{") ? stream_.matching(i) + 1 : i + 1;
    return i + 1;
  }

 protected:
  const TokenStream& stream_;
};

// Parses scopes.
class Parser : private DeclarationParser {
 public:
  explicit Parser(const TokenStream& stream) : DeclarationParser(stream) {}

  SourceModel run() {
    size_t i = 0;
    while (i < stream_.end()) i = std::max(parseTopLevel(i), i + 1);
    return std::move(model_);
  }

 private:
  // A function whose name is at `i`, to behind its body or ';'.
  size_t parseFunction(size_t i, const Declaration& prototype) {
    Function function;
    function.name = i;
    function.attributes = prototype.attributes;
    function.returnType = prototype.type;
    i = parseParameters(i + 1, function.parameters);
    while (i < stream_.end() && !is(i, "{") && !is(i, ";") && !is(i, "}")) ++i;
    if (is(i, "{")) {
      const size_t close = stream_.matching(i);
      function.body = {i + 1, close};
      i = close;
    }
    model_.functions.push_back(std::move(function));
    return i + 1;
  }

  // Members between the braces; methods go to the functions.
  void parseMembers(TokenRange range, std::vector<Declaration>& members) {
    size_t i = range.begin;
    while (i < range.end) {
      const size_t start = i;
      Declaration prototype;
      i = parseAttributes(i, prototype.attributes);
      i = parseType(i, prototype);
      if (at(i).isIdentifier() && is(i + 1, "(")) {
        i = parseFunction(i, prototype);
      } else if (at(i).isIdentifier() && !prototype.type.empty()) {
        i = parseVariables(i, prototype, members);
      }
      i = std::max(i, start + 1);
    }
  }

  size_t parseStruct(size_t i, const Declaration& prototype) {
    Struct result;
    ++i;
    if (at(i).isIdentifier()) {
      result.name = at(i).text;
      result.nameToken = i++;
    } else {
      result.nameToken = i;
    }
    if (is(i, ":")) {
      result.base = i;
      while (i < stream_.end() && !is(i, "{") && !is(i, ";")) ++i;
    }
    if (!is(i, "{")) return i;
    const size_t close = stream_.matching(i);
    parseMembers({i + 1, close}, result.members);
    model_.structs.push_back(result);
    i = close + 1;
    if (at(i).isIdentifier()) {  // "struct S { ... } s;"
      Declaration declaration = prototype;
      declaration.type = result.name;
      declaration.typeToken = result.nameToken;
      return parseVariables(i, declaration, model_.globals);
    }
    return is(i, ";") ? i + 1 : i;
  }

  size_t parseBlock(size_t i, const Declaration& prototype) {
    ConstantBlock block;
    block.attributes = prototype.attributes;
    ++i;
    block.name = at(i).text;
    block.nameToken = i++;
    while (i < stream_.end() && !is(i, "{") && !is(i, ";")) {
      if (is(i, "register")) block.hasRegister = true;
      ++i;
    }
    if (!is(i, "{")) return i;
    const size_t close = stream_.matching(i);
    parseMembers({i + 1, close}, block.members);
    model_.blocks.push_back(std::move(block));
    return close + 1;
  }

  size_t parseTopLevel(size_t i) {
    Declaration prototype;
    i = parseAttributes(i, prototype.attributes);
    size_t type = i;
    while (at(type).isIdentifier() && isQualifier(at(type).text)) ++type;
    const bool definesStruct = (is(type, "struct") || is(type, "class")) &&
                               (is(type + 1, "{") || is(type + 2, "{") || is(type + 2, ":"));
    if (definesStruct) {
      for (; i < type; ++i) prototype.qualifiers.push_back(at(i).text);
      return parseStruct(i, prototype);
    }
    if (is(i, "cbuffer") || is(i, "tbuffer")) return parseBlock(i, prototype);
    if (is(i, "template")) {
      TokenRange parameters;
      return is(i + 1, "<") ? skipTypeArguments(i + 1, parameters) : i + 1;
    }
    if (is(i, "enum") || is(i, "interface") || is(i, "using")) return skipStatement(i);
    if (is(i, "namespace")) return i + (is(i + 1, "{") ? 2 : 3);
    if (is(i, "typedef")) {
      i = parseType(i + 1, prototype);
      if (at(i).isIdentifier()) {
        const std::string_view name = at(i).text;
        i = parseDeclarator(i, prototype);
        model_.typedefs.emplace(name, prototype);
      }
      return i + 1;
    }
    if (!at(i).isIdentifier()) return i + 1;
    i = parseType(i, prototype);
    if (!at(i).isIdentifier() || prototype.type.empty()) return i;
    if (is(i + 1, "(")) return parseFunction(i, prototype);
    return parseVariables(i, prototype, model_.globals);
  }

  SourceModel model_;
};

}  // namespace

bool Declaration::isQualified(std::string_view qualifier) const {
  return std::find(qualifiers.begin(), qualifiers.end(), qualifier) != qualifiers.end();
}

const Attribute* Declaration::findAttribute(std::string_view scope, std::string_view wanted) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(), [&](const Attribute& a) {
    return a.scope == scope && a.name == wanted;
  });
  return found == attributes.end() ? nullptr : &*found;
}

const Struct* SourceModel::findStruct(std::string_view name) const {
  const auto found = std::find_if(structs.begin(), structs.end(),
                                  [name](const Struct& s) { return s.name == name; });
  return found == structs.end() ? nullptr : &*found;
}

SourceModel parseSource(const TokenStream& stream) { return Parser(stream).run(); }

}  // namespace pelage::codegen::checks
