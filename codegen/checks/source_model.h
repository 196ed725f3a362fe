// The declarations of one preprocessed HLSL file, as far as the source checks need them. It does
// not diagnose syntax errors (the front end does); it leaves out declarations that it cannot parse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "codegen/checks/token_stream.h"

namespace pelage::codegen::checks {

/// A half-open range of token indices.
struct TokenRange {
  size_t begin = 0, end = 0;
  bool empty() const { return begin >= end; }
};

/// "[[vk::constant_id(3)]]" has scope vk, name constant_id, doubled; "[numthreads(64, 1, 1)]" has
/// no scope and is not doubled.
struct Attribute {
  std::string_view scope, name;
  TokenRange arguments;  ///< inside the parentheses
  size_t token = 0;      ///< of the name
  bool doubled = false;
};

/// A variable, member or parameter.
struct Declaration {
  std::vector<Attribute> attributes;
  std::vector<std::string_view> qualifiers;  ///< static, const, inout, ...
  std::string_view type;                     ///< "RWStructuredBuffer"
  TokenRange typeArguments;                  ///< between < and >
  size_t name = 0;                           ///< token
  size_t typeToken = 0;
  std::vector<TokenRange> arraySizes;  ///< inside each [ ]
  std::string_view semantic;           ///< "SV_Position", not register or packoffset
  bool hasRegister = false;
  size_t packOffset = 0;  ///< token, 0 when there is none
  TokenRange initializer;

  bool isQualified(std::string_view qualifier) const;
  const Attribute* findAttribute(std::string_view scope, std::string_view name) const;
};

struct Struct {
  std::string_view name;
  size_t nameToken = 0;
  std::vector<Declaration> members;
  size_t base = 0;  ///< token of the ':' of a base list, 0 when there is none
};

/// cbuffer or tbuffer.
struct ConstantBlock {
  std::string_view name;
  size_t nameToken = 0;
  std::vector<Attribute> attributes;
  std::vector<Declaration> members;
  bool hasRegister = false;
};

struct Function {
  size_t name = 0;  ///< token
  std::vector<Attribute> attributes;
  std::string_view returnType;
  std::vector<Declaration> parameters;
  TokenRange body;  ///< inside the braces; empty for a declaration without a body
};

/// Views into the token stream's text.
struct SourceModel {
  std::vector<Struct> structs;
  std::vector<ConstantBlock> blocks;
  std::vector<Declaration> globals;
  std::vector<Function> functions;  ///< of structs too
  std::map<std::string_view, Declaration> typedefs;

  const Struct* findStruct(std::string_view name) const;
};

SourceModel parseSource(const TokenStream& stream);

}  // namespace pelage::codegen::checks
