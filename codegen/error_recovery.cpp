#include "codegen/error_recovery.h"

#include <algorithm>
#include <optional>
#include <set>

#include "codegen/checks/source_model.h"
#include "codegen/checks/token_stream.h"

namespace pelage::codegen {
namespace {

using checks::Token;
using checks::TokenRange;
using checks::TokenStream;

constexpr int kMaximumErrors = 50;

// The name in "'name' : unknown variable".
std::string_view quotedName(std::string_view message) {
  if (!message.starts_with('\'')) return {};
  const size_t end = message.find('\'', 1);
  return end == std::string_view::npos ? std::string_view{} : message.substr(1, end - 1);
}

struct FoundToken {
  size_t token = 0;
  const checks::Function* function = nullptr;
};

// The token in a function body that the message is about.
std::optional<FoundToken> findLocation(const TokenStream& stream, const checks::SourceModel& model,
                                       const FrontEndMessage& message) {
  std::optional<FoundToken> first;
  const std::string_view name = quotedName(message.text);
  for (const checks::Function& function : model.functions) {
    for (size_t i = function.body.begin; i < function.body.end; ++i) {
      const Token& token = stream.at(i);
      if (token.line != message.line || stream.fileOf(token) != message.file) continue;
      if (token.is(name)) return FoundToken{i, &function};
      if (!first) first = FoundToken{i, &function};
    }
  }
  return first;
}

// Replaces a range of the source, so that nothing after it becomes wrong.
struct Edit {
  TokenRange range;
  std::string replacement;
};

// The statement around a token, without its semicolon.
TokenRange findStatement(const TokenStream& stream, TokenRange body, size_t token) {
  TokenRange range = body;
  int depth = 0;
  for (size_t i = body.begin; i < body.end; ++i) {
    const Token& t = stream.at(i);
    if (t.is("(") || t.is("[")) ++depth;
    if (t.is(")") || t.is("]")) --depth;
    if (depth > 0 || !(t.is(";") || t.is("{") || t.is("}"))) continue;
    if (i >= token) {
      range.end = i;
      break;
    }
    range.begin = i + 1;
  }
  return range;
}

// The part of "for (a; b; c)" that the token is in.
TokenRange findClause(const TokenStream& stream, TokenRange head, size_t token) {
  TokenRange clause = head;
  for (size_t i = head.begin; i < head.end; ++i) {
    if (!stream.at(i).is(";")) continue;
    if (i >= token) {
      clause.end = i;
      break;
    }
    clause.begin = i + 1;
  }
  return clause;
}

Edit planEdit(const TokenStream& stream, const FoundToken& location) {
  TokenRange range = findStatement(stream, location.function->body, location.token);
  // Heads of compound statements stay: "if (x) wrong;" loses "wrong", "if (wrong) y;" gets another
  // condition.
  while (range.begin < location.token) {
    const Token& head = stream.at(range.begin);
    if (head.is("else") || head.is("do")) {
      ++range.begin;
      continue;
    }
    const bool isFor = head.is("for");
    if (!isFor && !head.is("if") && !head.is("while") && !head.is("switch")) break;
    const size_t close = stream.matching(range.begin + 1);
    const TokenRange inside{range.begin + 2, close};
    if (location.token > close) {
      range.begin = close + 1;
      continue;
    }
    if (!isFor) return {inside, "0"};
    range = findClause(stream, inside, location.token);
    break;
  }
  // A variable stays declared.
  for (size_t i = range.begin + 2; i < location.token; ++i) {
    const Token& type = stream.at(i - 2);
    if (stream.at(i).is("(")) break;
    if (!stream.at(i).is("=") || !stream.at(i - 1).isIdentifier() || !type.isIdentifier()) continue;
    return {{i, range.end}, "= (" + std::string(type.text) + ")0"};
  }
  // A function still returns something.
  if (stream.at(range.begin).is("return")) {
    return {range, "return (" + std::string(location.function->returnType) + ")0"};
  }
  return {range, ""};
}

void blank(std::string& text, const Token& token) {
  const auto offset = static_cast<size_t>(token.text.data() - text.data());
  for (size_t i = offset; i < offset + token.text.size(); ++i) {
    if (text[i] != '\n') text[i] = ' ';
  }
}

}  // namespace

std::vector<FrontEndMessage> findAllErrors(FrontEndInput input, std::string preprocessed,
                                           const std::vector<FrontEndMessage>& first) {
  std::vector<FrontEndMessage> errors;
  // Names declared in a blanked statement: errors that call them unknown do not count.
  std::set<std::string, std::less<>> blanked;
  std::vector<FrontEndMessage> messages = first;
  for (int round = 0; round < kMaximumErrors; ++round) {
    const auto error = std::find_if(messages.begin(), messages.end(),
                                    [](const FrontEndMessage& m) { return m.isError; });
    if (error == messages.end()) break;
    if (!blanked.contains(quotedName(error->text))) errors.push_back(*error);

    const TokenStream stream = checks::tokenize(preprocessed, input.file);
    const checks::SourceModel model = checks::parseSource(stream);
    const std::optional<FoundToken> location = findLocation(stream, model, *error);
    if (!location) break;
    const Edit edit = planEdit(stream, *location);
    if (edit.range.empty()) break;
    const auto start =
        static_cast<size_t>(stream.at(edit.range.begin).text.data() - preprocessed.data());
    for (size_t i = edit.range.begin; i < edit.range.end; ++i) {
      const Token& t = stream.at(i);
      if (t.isIdentifier()) blanked.emplace(t.text);
      blank(preprocessed, t);
    }
    preprocessed.insert(start, edit.replacement);

    input.text = preprocessed;
    messages = compileHlsl(input).messages;
  }
  return errors;
}

}  // namespace pelage::codegen
