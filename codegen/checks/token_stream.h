// Lexer for preprocessed HLSL: tokens with the file and line that the programmer wrote them in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pelage::codegen::checks {

enum class TokenKind : uint8_t {
  kIdentifier,  ///< keywords too
  kNumber,      ///< with sign-less exponent and suffix, as written
  kString,      ///< with its quotes
  kPunctuator,  ///< one character, but for :: and the compound assignments, comparisons and shifts
  kDirective,   ///< a whole line that starts with '#', but for #line
  kEnd,         ///< after the last token
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string_view text;  ///< into the text given to tokenize()
  uint32_t file = 0;      ///< index into TokenStream::files
  uint32_t line = 0;      ///< from 1

  bool is(std::string_view wanted) const { return text == wanted; }
  bool isIdentifier() const { return kind == TokenKind::kIdentifier; }
};

/// The tokens of one text. The last one is kEnd, so index size() - 1 is always readable.
struct TokenStream {
  std::vector<Token> tokens;
  std::vector<std::string> files;

  /// Reading past the end gives the kEnd token.
  const Token& at(size_t index) const {
    return index < tokens.size() ? tokens[index] : tokens.back();
  }
  size_t end() const { return tokens.size() - 1; }
  const std::string& fileOf(const Token& token) const { return files[token.file]; }

  /// Index of the bracket that closes the one at `open` ( ( [ or { ), or end().
  size_t matching(size_t open) const;
};

/// Reads `text`, which starts on line 1 of `file`. Comments are skipped. Any bytes are accepted: an
/// unknown one becomes a punctuator.
TokenStream tokenize(std::string_view text, std::string_view file);

}  // namespace pelage::codegen::checks
