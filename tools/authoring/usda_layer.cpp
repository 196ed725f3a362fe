#include "usda_layer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "text_lines.h"

namespace pelage::detail {
namespace {

constexpr size_t kMaxPrimDepth = 128, kMaxBracketDepth = 64;

bool isLetter(char c) {
  const auto u = static_cast<unsigned char>(c);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || u >= 0x80;
}
bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isNumberStart(char c) { return isDigit(c) || c == '-' || c == '+' || c == '.'; }

struct Token {
  enum Kind { kEnd, kWord, kString, kAsset, kPath, kMark };
  Kind kind = kEnd;
  std::string_view text;  ///< without quotes; a mark is one character
  uint64_t line = 0;

  bool isMark(char c) const { return kind == kMark && text.front() == c; }
  bool isWord(std::string_view word) const { return kind == kWord && text == word; }
};

/// Words, texts and marks of a file.
class Tokens {
 public:
  Tokens(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  Result<Token> next() {
    if (peeked_) {
      const Token token = *peeked_;
      peeked_.reset();
      line_ = token.line;
      return token;
    }
    return read();
  }
  Result<Token> peek() {
    if (!peeked_) {
      auto token = read();
      if (!token) return token.error();
      peeked_ = *token;
    }
    return *peeked_;
  }
  Error fail(std::string_view what, std::string_view path, uint64_t line = 0) const {
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}:{}: {}{}{}", name_, line > 0 ? line : line_, path,
                             path.empty() ? "" : ": ", what)};
  }

 private:
  bool startsWith(std::string_view what) const { return text_.substr(at_, what.size()) == what; }

  void advance(size_t count) {
    count = std::min(count, text_.size() - at_);
    const auto begin = text_.begin() + static_cast<std::ptrdiff_t>(at_);
    lineAt_ +=
        static_cast<uint64_t>(std::count(begin, begin + static_cast<std::ptrdiff_t>(count), '\n'));
    at_ += count;
  }

  void skipBlanks() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (startsWith("/*")) {
        const size_t end = text_.find("*/", at_ + 2);
        advance(end == std::string_view::npos ? text_.size() : end + 2 - at_);
      } else if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
        lineAt_ += c == '\n' ? 1 : 0;
        ++at_;
      } else {
        return;
      }
    }
  }

  // Reads the text between `open`, which is here, and `close`.
  Result<Token> enclosed(Token::Kind kind, std::string_view open, std::string_view close,
                         bool escapes, bool lines) {
    const size_t begin = at_ + open.size();
    size_t end = begin;
    while (end < text_.size() && text_.substr(end, close.size()) != close) {
      if (!lines && text_[end] == '\n')
        end = text_.size();
      else
        end += escapes && text_[end] == '\\' ? 2 : 1;
    }
    if (end >= text_.size()) return fail(fmt::format("{} is not closed", open), {});
    const Token token = {kind, text_.substr(begin, end - begin), line_};
    advance(end + close.size() - at_);
    return token;
  }

  Result<Token> read() {
    skipBlanks();
    line_ = lineAt_;
    if (at_ >= text_.size()) return Token{Token::kEnd, {}, line_};
    const char c = text_[at_];
    if (startsWith("\"\"\"") || startsWith("'''"))
      return enclosed(Token::kString, text_.substr(at_, 3), text_.substr(at_, 3), true, true);
    if (c == '"' || c == '\'')
      return enclosed(Token::kString, text_.substr(at_, 1), text_.substr(at_, 1), true, false);
    if (startsWith("@@@")) return enclosed(Token::kAsset, "@@@", "@@@", false, false);
    if (c == '@') return enclosed(Token::kAsset, "@", "@", false, false);
    if (c == '<') return enclosed(Token::kPath, "<", ">", false, false);
    size_t end = at_ + 1;
    if (isLetter(c)) {
      const auto follows = [&](size_t i) {
        return i < text_.size() && (isLetter(text_[i]) || isDigit(text_[i]));
      };
      while (follows(end) ||
             (end < text_.size() && (text_[end] == ':' || text_[end] == '.') && follows(end + 1)))
        ++end;
    } else if (isNumberStart(c)) {
      while (end < text_.size() &&
             (isLetter(text_[end]) || isNumberStart(text_[end]) || text_[end] == '#'))
        ++end;
    } else if (std::string_view("()[]{}=,;:").find(c) == std::string_view::npos) {
      return fail(fmt::format("unexpected character {:#04x}", static_cast<unsigned char>(c)), {});
    }
    const Token token = {isLetter(c) || isNumberStart(c) ? Token::kWord : Token::kMark,
                         text_.substr(at_, end - at_), line_};
    at_ = end;
    return token;
  }

  std::string_view text_, name_;
  size_t at_ = 0;
  uint64_t lineAt_ = 1;  // of the next character
  uint64_t line_ = 1;    // of the last token
  std::optional<Token> peeked_;
};

// Sets what the name of a type says: "point3f", "matrix4d", "int64".
void describeType(UsdaAttribute& attribute) {
  using Numbers = UsdaAttribute::Numbers;
  const std::string_view type = attribute.type;
  const auto begins = [&](std::string_view word) { return type.starts_with(word); };
  if (begins("token") || begins("string") || begins("asset") || begins("pathExpression")) {
    attribute.numbers = Numbers::kText;
    return;
  }
  if (begins("int64") || begins("uint64")) {
    attribute.numbers = Numbers::kInteger;
    return;
  }
  const bool isInteger = begins("int") || begins("uint") || begins("uchar") || begins("bool");
  const bool isDouble = begins("double") || begins("timecode") || type.ends_with('d');
  if (isInteger) attribute.numbers = Numbers::kInteger;
  if (isDouble) attribute.numbers = Numbers::kDouble;
  for (const char c : type)
    if (c >= '2' && c <= '4') attribute.components = static_cast<uint32_t>(c - '0');
  if (begins("quat")) attribute.components = 4;
  if (begins("matrix") || begins("frame")) attribute.components *= attribute.components;
}

class UsdaReader {
 public:
  UsdaReader(std::string_view text, std::string_view name,
             const std::function<bool(std::string_view, std::string_view)>& wanted)
      : tokens_(text, name), wanted_(wanted) {}

  Result<UsdaLayer> read() {
    if (auto r = readLayerMetadata(); !r) return r.error();
    while (true) {
      auto token = tokens_.next();
      if (!token) return token.error();
      if (token->kind == Token::kEnd && open_.empty()) return std::move(layer_);
      if (token->kind == Token::kEnd) return fail("the file ends before the prim does");
      if (token->isMark(';')) continue;
      if (token->isMark('}') && !open_.empty()) {
        open_.pop_back();
        continue;
      }
      if (token->kind != Token::kWord) return unexpected(*token, "a prim or a property");
      if (auto r = readStatement(*token); !r) return r.error();
    }
  }

 private:
  std::string path() const { return open_.empty() ? std::string() : layer_.pathOf(open_.back()); }
  Error fail(std::string_view what, uint64_t line = 0) const {
    return tokens_.fail(what, path(), line);
  }
  Error unexpected(const Token& token, std::string_view wanted) const {
    return fail(token.kind == Token::kEnd
                    ? fmt::format("the file ends where {} should be", wanted)
                    : fmt::format("'{}' where {} should be", clip(token.text), wanted));
  }
  Result<void> expect(char mark) {
    auto token = tokens_.next();
    if (!token) return token.error();
    return token->isMark(mark) ? Result<void>() : unexpected(*token, fmt::format("'{}'", mark));
  }
  Result<bool> take(char mark) {
    auto token = tokens_.peek();
    if (!token) return token.error();
    if (!token->isMark(mark)) return false;
    (void)tokens_.next();
    return true;
  }

  // Skips a value: a word or a text, or all between two brackets.
  Result<void> skipValue() {
    std::array<char, kMaxBracketDepth> closes{};
    size_t depth = 0;
    do {
      auto token = tokens_.next();
      if (!token) return token.error();
      if (token->kind == Token::kEnd) return unexpected(*token, "a value");
      if (token->kind != Token::kMark) continue;
      const char mark = token->text.front();
      const char close = mark == '(' ? ')' : mark == '[' ? ']' : mark == '{' ? '}' : '\0';
      if (close != '\0') {
        if (depth == closes.size())
          return fail(fmt::format("brackets are nested deeper than {}", kMaxBracketDepth));
        closes[depth++] = close;
      } else if (depth > 0 && mark == closes[depth - 1]) {
        --depth;
      } else if (depth == 0 || mark == ')' || mark == ']' || mark == '}') {
        return unexpected(*token, "a value");
      }
    } while (depth > 0);
    return {};
  }

  // Reads metadata between ( and ), if there is any: calls `entry` with each key and the first
  // token of its value.
  template <class Entry>
  Result<void> readMetadata(Entry entry) {
    auto open = take('(');
    if (!open || !*open) return open ? Result<void>() : open.error();
    while (true) {
      auto token = tokens_.next();
      if (!token) return token.error();
      if (token->isMark(')')) return {};
      if (token->isMark(';') || token->isMark(',') || token->kind == Token::kString) continue;
      if (token->kind != Token::kWord) return unexpected(*token, "metadata or ')'");
      std::string_view key = token->text;
      auto after = tokens_.peek();
      if (!after) return after.error();
      if (after->kind == Token::kWord) {  // "prepend references"
        key = after->text;
        (void)tokens_.next();
      }
      if (auto r = expect('='); !r) return r;
      auto value = tokens_.peek();
      if (!value) return value.error();
      const Token first = *value;
      if (auto r = skipValue(); !r) return r;
      if (auto r = entry(key, first); !r) return r;
      // @file@</prim> (offset = 1)
      while (true) {
        auto rest = tokens_.peek();
        if (!rest) return rest.error();
        if (rest->kind != Token::kPath && !rest->isMark('(')) break;
        if (auto r = skipValue(); !r) return r;
      }
    }
  }

  Result<double> numberOf(const Token& token, std::string_view what) const {
    double value = 0;
    std::string_view word = token.text;
    if (word.size() > 1 && word.front() == '+') word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto [at, error] = std::from_chars(word.data(), end, value);
    if (token.kind == Token::kWord && at == end && error == std::errc()) return value;
    // Beyond a double.
    if (token.kind == Token::kWord && at == end && error == std::errc::result_out_of_range)
      return double{parseFloat(word).value_or(0)};
    return fail(fmt::format("{}: '{}' is not a number", what, clip(token.text)), token.line);
  }

  Result<void> readLayerMetadata() {
    return readMetadata([&](std::string_view key, const Token& value) -> Result<void> {
      if (key == "subLayers") layer_.hasSublayers = true;
      if (key == "upAxis") layer_.upAxis = value.text;
      if (key != "metersPerUnit") return {};
      auto number = numberOf(value, key);
      if (!number) return number.error();
      layer_.metersPerUnit = *number;
      return {};
    });
  }

  Result<void> readStatement(const Token& first) {
    const std::string_view word = first.text;
    if (word == "def" || word == "over" || word == "class") return readPrim(word == "def");
    if (open_.empty() && word != "reorder") return unexpected(first, "'def', 'over' or 'class'");
    if (word == "variantSet") {
      layer_.prims[open_.back()].composes = true;
      auto name = tokens_.next();
      if (!name) return name.error();
      if (auto r = expect('='); !r) return r;
      return skipValue();
    }
    return readProperty(first);
  }

  Result<void> readPrim(bool defined) {
    auto token = tokens_.next();
    if (!token) return token.error();
    UsdaPrim prim;
    if (token->kind == Token::kWord) {
      prim.type = token->text;
      token = tokens_.next();
      if (!token) return token.error();
    }
    if (token->kind != Token::kString || token->text.empty())
      return unexpected(*token, "the name of a prim, in quotes,");
    if (open_.size() == kMaxPrimDepth)
      return fail(fmt::format("prims are nested deeper than {}", kMaxPrimDepth));
    if (layer_.prims.size() == UsdaPrim::kNoParent) return fail("too many prims");
    prim.name = token->text;
    prim.line = token->line;
    prim.defined = defined;
    if (!open_.empty()) {
      const UsdaPrim& parent = layer_.prims[open_.back()];
      prim.parent = open_.back();
      prim.defined = defined && parent.defined;
      prim.active = parent.active;
    }
    open_.push_back(static_cast<uint32_t>(layer_.prims.size()));
    layer_.prims.push_back(std::move(prim));
    auto done = readMetadata([&](std::string_view key, const Token& value) -> Result<void> {
      UsdaPrim& added = layer_.prims[open_.back()];
      if (key == "active" && (value.isWord("false") || value.isWord("0"))) added.active = false;
      constexpr std::array<std::string_view, 5> kArcs = {"references", "payload", "inherits",
                                                         "specializes", "variants"};
      if (std::find(kArcs.begin(), kArcs.end(), key) != kArcs.end()) added.composes = true;
      return {};
    });
    if (!done) return done;
    return expect('{');
  }

  // [custom] [uniform] type[] name[.timeSamples] [= value] [(metadata)], or a relationship.
  Result<void> readProperty(const Token& first) {
    constexpr std::array<std::string_view, 9> kPrefixes = {
        "custom", "uniform", "varying", "config", "prepend", "append", "add", "delete", "reorder"};
    Token token = first;
    while (std::find(kPrefixes.begin(), kPrefixes.end(), token.text) != kPrefixes.end()) {
      auto after = tokens_.next();
      if (!after) return after.error();
      if (after->kind != Token::kWord) return unexpected(*after, "a property");
      token = *after;
    }
    UsdaAttribute found;
    found.type = token.text;
    found.line = token.line;
    auto name = tokens_.peek();
    if (!name) return name.error();
    if (name->isMark('=')) return skipAssigned();  // reorder nameChildren = [...]
    auto array = take('[');
    if (!array) return array.error();
    found.isArray = *array;
    if (found.isArray)
      if (auto r = expect(']'); !r) return r;
    name = tokens_.next();
    if (!name) return name.error();
    if (name->kind != Token::kWord) return unexpected(*name, "the name of a property");
    constexpr std::string_view kSamples = ".timeSamples";
    std::string_view key = name->text;
    const bool sampled = key.ends_with(kSamples);
    if (sampled) key.remove_suffix(kSamples.size());
    if (open_.empty() || found.type == "rel" || key.find('.') != std::string_view::npos ||
        !wanted_(layer_.prims[open_.back()].type, key)) {
      if (auto r = skipAssigned(); !r) return r;
      return readMetadata([](std::string_view, const Token&) { return Result<void>(); });
    }
    describeType(found);
    UsdaPrim& prim = layer_.prims[open_.back()];
    const auto [at, isNew] = prim.attributes.try_emplace(std::string(key), std::move(found));
    return readAttribute(key, at->second, sampled);
  }

  Result<void> skipAssigned() {
    auto assigned = take('=');
    if (!assigned || !*assigned) return assigned ? Result<void>() : assigned.error();
    return skipValue();
  }

  Result<void> readAttribute(std::string_view key, UsdaAttribute& attribute, bool sampled) {
    auto assigned = take('=');
    if (!assigned) return assigned.error();
    if (*assigned && sampled) {
      if (attribute.time) return fail(fmt::format("the samples of {} are there twice", key));
      if (auto r = readSamples(key, attribute); !r) return r;
    } else if (*assigned) {
      if (attribute.hasDefault) return fail(fmt::format("{} is there twice", key));
      // A value counts more than samples.
      attribute.time.reset();
      if (auto r = readValue(key, attribute, attribute.hasDefault); !r) return r;
    }
    return readMetadata([&](std::string_view entry, const Token& value) -> Result<void> {
      if (entry == "interpolation") attribute.interpolation = value.text;
      return {};
    });
  }

  // Keeps the first sample, if there is no other value.
  Result<void> readSamples(std::string_view key, UsdaAttribute& attribute) {
    if (auto r = expect('{'); !r) return r;
    while (true) {
      auto token = tokens_.next();
      if (!token) return token.error();
      if (token->isMark('}')) return {};
      if (token->isMark(',')) continue;
      auto time = numberOf(*token, fmt::format("a time of {}", key));
      if (!time) return time.error();
      if (auto r = expect(':'); !r) return r;
      if (attribute.hasDefault || (attribute.time && !(*time < *attribute.time))) {
        if (auto r = skipValue(); !r) return r;
        continue;
      }
      bool hasValue = false;
      if (auto r = readValue(key, attribute, hasValue); !r) return r;
      if (hasValue) attribute.time = *time;
    }
  }

  Result<void> readValue(std::string_view key, UsdaAttribute& attribute, bool& hasValue) {
    attribute.floats.clear();
    attribute.doubles.clear();
    attribute.integers.clear();
    attribute.texts.clear();
    auto token = tokens_.next();
    if (!token) return token.error();
    hasValue = !token->isWord("None");
    if (!hasValue) return {};
    if (!attribute.isArray) return readElement(key, attribute, *token);
    if (!token->isMark('[')) return unexpected(*token, fmt::format("'[' of {}", key));
    while (true) {
      token = tokens_.next();
      if (!token) return token.error();
      if (token->isMark(']')) return {};
      if (auto r = readElement(key, attribute, *token); !r) return r;
      token = tokens_.next();
      if (!token) return token.error();
      if (token->isMark(']')) return {};
      if (!token->isMark(',')) return unexpected(*token, fmt::format("',' or ']' of {}", key));
    }
  }

  // A number or a text, or as many in parentheses as the type has; a matrix has them by rows.
  Result<void> readElement(std::string_view key, UsdaAttribute& attribute, const Token& first) {
    if (!first.isMark('(')) {
      if (attribute.components != 1)
        return unexpected(first, fmt::format("a {} of {}", attribute.type, key));
      return readNumber(key, attribute, first);
    }
    uint32_t count = 0, depth = 1;
    while (depth > 0) {
      auto token = tokens_.next();
      if (!token) return token.error();
      if (token->isMark(',')) continue;
      if (token->isMark('(') && depth < 2) {
        ++depth;
      } else if (token->isMark(')')) {
        --depth;
      } else {
        if (auto r = readNumber(key, attribute, *token); !r) return r;
        if (++count > attribute.components) break;
      }
    }
    if (count != attribute.components || attribute.components == 1)
      return fail(fmt::format("{}: an element has {} numbers{}; a {} has {}", key, count,
                              depth > 0 ? " or more" : "", attribute.type, attribute.components));
    return {};
  }

  Result<void> readNumber(std::string_view key, UsdaAttribute& attribute, const Token& token) {
    using Numbers = UsdaAttribute::Numbers;
    const std::string_view word = token.text;
    if (attribute.numbers == Numbers::kText) {
      if (token.kind != Token::kString && token.kind != Token::kAsset)
        return unexpected(token, fmt::format("a text of {}", key));
      attribute.texts.emplace_back(word);
    } else if (token.kind != Token::kWord) {
      return unexpected(token, fmt::format("a number of {}", key));
    } else if (attribute.numbers == Numbers::kFloat) {
      const std::optional<float> value = parseFloat(word);
      if (!value) return fail(fmt::format("{}: '{}' is not a number", key, clip(word)));
      attribute.floats.push_back(*value);
    } else if (attribute.numbers == Numbers::kDouble) {
      auto value = numberOf(token, key);
      if (!value) return value.error();
      attribute.doubles.push_back(*value);
    } else {
      const bool isTrue = word == "true";
      const std::optional<int64_t> value =
          isTrue || word == "false" ? std::optional<int64_t>(isTrue ? 1 : 0) : parseInteger(word);
      if (!value)
        return fail(fmt::format("{}: '{}' is not a whole number of 64 bits", key, clip(word)));
      attribute.integers.push_back(*value);
    }
    return {};
  }

  Tokens tokens_;
  const std::function<bool(std::string_view, std::string_view)>& wanted_;
  UsdaLayer layer_;
  std::vector<uint32_t> open_;  // prims, from the outermost
};

}  // namespace

std::string UsdaLayer::pathOf(uint32_t prim) const {
  std::vector<uint32_t> chain;
  for (uint32_t at = prim; at != UsdaPrim::kNoParent; at = prims[at].parent) chain.push_back(at);
  std::string path;
  for (size_t i = chain.size(); i-- > 0;) path += '/' + std::string(clip(prims[chain[i]].name));
  return path;
}

Result<UsdaLayer> readUsda(
    std::span<const std::byte> bytes, std::string_view name,
    const std::function<bool(std::string_view primType, std::string_view attribute)>& wanted) {
  std::string_view text = asText(bytes);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (!text.starts_with("#usda 1."))
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}:1: the file does not begin with '#usda 1.0'", name)};
  return UsdaReader(text, name, wanted).read();
}

}  // namespace pelage::detail
