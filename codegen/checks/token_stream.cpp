#include "codegen/checks/token_stream.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace pelage::codegen::checks {
namespace {

bool isIdentifierStart(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

// ">>" stays two tokens, so that StructuredBuffer<vector<float, 2>> closes twice.
constexpr std::array<std::string_view, 19> kLongPunctuators = {
    "::", "==", "!=", "<=", ">=", "&&", "||", "+=", "-=", "*=",
    "/=", "%=", "&=", "|=", "^=", "++", "--", "->", "<<"};

// "#line 12" or "#line 12 "file"".
bool parseLineDirective(std::string_view line, uint32_t& number, std::string_view& name) {
  const auto skipSpace = [&line] {
    while (!line.empty() && isSpace(line.front())) line.remove_prefix(1);
  };
  line.remove_prefix(1);
  skipSpace();
  if (line.substr(0, 4) != "line") return false;
  line.remove_prefix(4);
  skipSpace();
  const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), number);
  if (error != std::errc{}) return false;
  line.remove_prefix(static_cast<size_t>(rest - line.data()));
  skipSpace();
  if (!line.empty() && line.front() == '"') {
    const size_t close = line.find('"', 1);
    if (close != std::string_view::npos) name = line.substr(1, close - 1);
  }
  return true;
}

class Lexer {
 public:
  Lexer(std::string_view text, std::string_view file) : text_(text) {
    stream_.files.emplace_back(file);
  }

  TokenStream run() {
    while (position_ < text_.size()) step();
    push(TokenKind::kEnd, text_.size());
    return std::move(stream_);
  }

 private:
  char peek(size_t ahead = 0) const {
    return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0';
  }

  // Adds the token that reaches up to `end` and moves there.
  void push(TokenKind kind, size_t end) {
    stream_.tokens.push_back({kind, text_.substr(position_, end - position_), file_, line_});
    position_ = end;
  }

  size_t lineEnd() const { return std::min(text_.find('\n', position_), text_.size()); }

  void step() {
    const char c = peek();
    if (c == '\n') {
      ++line_;
      ++position_;
      lineStart_ = true;
      return;
    }
    if (isSpace(c)) {
      ++position_;
      return;
    }
    if (c == '/' && peek(1) == '/') {
      position_ = lineEnd();
      return;
    }
    if (c == '/' && peek(1) == '*') {
      const size_t close = text_.find("*/", position_ + 2);
      const size_t end = close == std::string_view::npos ? text_.size() : close + 2;
      line_ +=
          static_cast<uint32_t>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(position_),
                                           text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      position_ = end;
      return;
    }
    if (c == '#' && lineStart_) {
      directive();
      return;
    }
    lineStart_ = false;
    if (isIdentifierStart(c)) {
      size_t end = position_ + 1;
      while (end < text_.size() && (isIdentifierStart(text_[end]) || isDigit(text_[end]))) ++end;
      push(TokenKind::kIdentifier, end);
    } else if (isDigit(c) || (c == '.' && isDigit(peek(1)))) {
      push(TokenKind::kNumber, numberEnd());
    } else if (c == '"') {
      size_t end = position_ + 1;
      while (end < text_.size() && text_[end] != '"' && text_[end] != '\n') {
        end += text_[end] == '\\' && end + 1 < text_.size() && text_[end + 1] != '\n' ? 2 : 1;
      }
      push(TokenKind::kString,
           std::min(end + (end < text_.size() && text_[end] == '"'), text_.size()));
    } else {
      const std::string_view rest = text_.substr(position_);
      const auto* found =
          std::find_if(kLongPunctuators.begin(), kLongPunctuators.end(),
                       [rest](std::string_view p) { return rest.substr(0, p.size()) == p; });
      push(TokenKind::kPunctuator,
           position_ + (found == kLongPunctuators.end() ? 1 : found->size()));
    }
  }

  size_t numberEnd() const {
    const bool hexadecimal = peek() == '0' && (peek(1) == 'x' || peek(1) == 'X');
    size_t end = position_;
    while (end < text_.size()) {
      const char c = text_[end];
      const bool exponentSign = !hexadecimal && end > position_ && (c == '+' || c == '-') &&
                                (text_[end - 1] == 'e' || text_[end - 1] == 'E');
      // "1.x" is a swizzle of a literal only in theory; a digit, a letter or one dot continue.
      if (!isIdentifierStart(c) && !isDigit(c) && c != '.' && !exponentSign) break;
      ++end;
    }
    return end;
  }

  void directive() {
    const size_t end = lineEnd();
    const std::string_view line = text_.substr(position_, end - position_);
    uint32_t number = 0;
    std::string_view name;
    if (!parseLineDirective(line, number, name)) {
      push(TokenKind::kDirective, end);
      return;
    }
    if (!name.empty()) {
      const auto found = std::find(stream_.files.begin(), stream_.files.end(), name);
      file_ = static_cast<uint32_t>(found - stream_.files.begin());
      if (found == stream_.files.end()) stream_.files.emplace_back(name);
    }
    line_ = number;
    // The number is that of the line after this one.
    position_ = end < text_.size() ? end + 1 : end;
  }

  std::string_view text_;
  size_t position_ = 0;
  uint32_t line_ = 1;
  uint32_t file_ = 0;
  bool lineStart_ = true;
  TokenStream stream_;
};

}  // namespace

size_t TokenStream::matching(size_t open) const {
  size_t depth = 0;
  for (size_t i = open; i < end(); ++i) {
    const std::string_view text = tokens[i].text;
    if (tokens[i].kind != TokenKind::kPunctuator || text.size() != 1) continue;
    const char c = text.front();
    if (c == '(' || c == '[' || c == '{') ++depth;
    if (c == ')' || c == ']' || c == '}') {
      if (depth <= 1) return i;
      --depth;
    }
  }
  return end();
}

TokenStream tokenize(std::string_view text, std::string_view file) {
  return Lexer(text, file).run();
}

}  // namespace pelage::codegen::checks
