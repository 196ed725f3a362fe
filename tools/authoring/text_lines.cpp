#include "text_lines.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

namespace pelage::detail {
namespace {

// The comma: TressFX 2 files separate coordinates by it.
bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == '\r' || c == '\v' || c == '\f';
}

std::optional<float> parseOldNumber(std::string_view word) {
  const bool negative = word.front() == '-';
  if (negative) word.remove_prefix(1);
  if (word.substr(0, 3) != "1.#") return std::nullopt;
  if (word.substr(3, 3) != "INF") return std::numeric_limits<float>::quiet_NaN();
  return negative ? -std::numeric_limits<float>::infinity()
                  : std::numeric_limits<float>::infinity();
}

}  // namespace

std::optional<float> parseFloat(std::string_view word) {
  if (word.empty()) return std::nullopt;
  if (const auto old = parseOldNumber(word)) return old;
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  float value = 0;
  const auto [at, error] = std::from_chars(word.data(), end, value);
  if (at != end) return std::nullopt;
  if (error == std::errc()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
  // Too large or too small for a float; a double knows which, or its exponent does.
  double wide = 0;
  const bool inDouble = std::from_chars(word.data(), end, wide).ec == std::errc();
  const bool small = inDouble ? std::abs(wide) < 1
                              : word.find("e-") != std::string_view::npos ||
                                    word.find("E-") != std::string_view::npos;
  if (small) return 0.0f;
  return word.front() == '-' ? -std::numeric_limits<float>::infinity()
                             : std::numeric_limits<float>::infinity();
}

std::optional<int64_t> parseInteger(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  int64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [at, error] = std::from_chars(word.data(), end, value);
  if (word.empty() || at != end || error != std::errc()) return std::nullopt;
  return value;
}

bool TextLines::next() {
  // Skips the rest of a continued line.
  do {
    if (rest_.empty()) {
      line_ = {};
      hasComment_ = continues_ = false;
      return false;
    }
    const size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    ++lineNumber_;
    const bool goesOn = continues_;
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    // A # inside a word is none: "-1.#INF".
    size_t comment = line_.find('#');
    while (comment != std::string_view::npos && comment > 0 && !isBlank(line_[comment - 1]))
      comment = line_.find('#', comment + 1);
    hasComment_ = comment != std::string_view::npos;
    line_ = line_.substr(0, comment);
    continues_ = continued_ && !hasComment_ && !line_.empty() && line_.back() == '\\';
    if (continues_) line_.remove_suffix(1);
    if (!goesOn || joins_) return true;
  } while (true);
}

void TextLines::skipBlanks() {
  while (true) {
    while (!line_.empty() && isBlank(line_.front())) line_.remove_prefix(1);
    if (!line_.empty() || !continues_) return;
    joins_ = true;
    const bool more = next();
    joins_ = false;
    if (!more) return;
  }
}

std::string_view TextLines::word() {
  skipBlanks();
  size_t length = 0;
  while (length < line_.size() && !isBlank(line_[length])) ++length;
  const std::string_view result = line_.substr(0, length);
  line_.remove_prefix(length);
  return result;
}

bool TextLines::atEnd() {
  skipBlanks();
  return line_.empty();
}

Result<float> TextLines::number(const char* what) {
  const std::string_view text = word();
  const std::optional<float> value = parseFloat(text);
  if (text.empty()) return fail(fmt::format("{} is missing at the end of the line", what));
  if (!value) return fail(fmt::format("{}: '{}' is not a number", what, clip(text)));
  return *value;
}

Result<uint32_t> TextLines::count(const char* what) {
  const std::string_view text = word();
  const std::optional<int64_t> value = parseInteger(text);
  if (!value || *value < 0 || *value > std::numeric_limits<uint32_t>::max())
    return fail(fmt::format("{}: '{}' is not a whole number of 0 to 2^32-1", what, clip(text)));
  return static_cast<uint32_t>(*value);
}

Error TextLines::fail(std::string_view what) const {
  return Error{ErrorCode::kInvalidFile, fmt::format("{}:{}: {}", name_, lineNumber_, what)};
}

}  // namespace pelage::detail
