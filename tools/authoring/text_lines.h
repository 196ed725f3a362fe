// Lines and words of text files, with the line number for errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "pelage/result.h"

namespace pelage::detail {

inline std::string_view asText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A whole word as a number, whatever the locale; also with a plus sign, nan, inf, and the forms
/// that old Microsoft libraries print ("-1.#INF", "1.#QNAN"). Numbers beyond a float are infinite,
/// those too small are 0.
std::optional<float> parseFloat(std::string_view word);

/// A whole word as a whole number.
std::optional<int64_t> parseInteger(std::string_view word);

/// Some editors of Windows put it in front of UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

class TextLines {
 public:
  /// \param continued: a backslash at the end of a line joins it with the next.
  TextLines(std::string_view text, std::string_view name, bool continued = false)
      : rest_(text), name_(name), continued_(continued) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  }

  /// Goes to the next line, blank ones too; false at the end. A comment (# to the end of the line)
  /// is not part of it.
  bool next();

  /// The next word of the line, without the blanks and commas around it; empty at the end.
  std::string_view word();
  /// Whether the line has no more words.
  bool atEnd();

  /// Whether the line has a comment.
  bool hasComment() const { return hasComment_; }

  /// A number of any value, also one that is not finite.
  Result<float> number(const char* what);
  Result<uint32_t> count(const char* what);

  uint64_t lineNumber() const { return lineNumber_; }
  /// Bytes behind this line.
  size_t bytesLeft() const { return rest_.size(); }
  /// "name:line: what"
  Error fail(std::string_view what) const;

 private:
  void skipBlanks();

  std::string_view rest_, line_, name_;
  bool continued_;          // lines can go on
  bool continues_ = false;  // this one does
  bool joins_ = false;      // next() is called to go on with a line
  bool hasComment_ = false;
  uint64_t lineNumber_ = 0;
};

/// The part of a word that errors quote.
inline std::string_view clip(std::string_view text) { return text.substr(0, 40); }

}  // namespace pelage::detail
