// Messages of the tool about its input: errors and notes with file and line.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pelage::codegen {

/// The location of a declaration.
struct SourceLocation {
  std::string file;
  uint32_t line = 1;
};

/// One message in the format of compilers.
struct Diagnostic {
  std::string file;
  uint32_t line = 0;    ///< from 1
  std::string code;     ///< "PK012"
  std::string message;  ///< one line, which also says what to do
  bool isError = true;  ///< otherwise a note, which does not fail the build

  auto operator<=>(const Diagnostic&) const = default;
};

/// The text in single quotes, as messages name things.
inline std::string quote(std::string_view text) { return "'" + std::string(text) + "'"; }

/// Collects the messages of a whole build, so that all of them are reported at once.
class Diagnostics {
 public:
  void add(Diagnostic diagnostic) { items_.push_back(std::move(diagnostic)); }
  void error(std::string file, uint32_t line, std::string code, std::string message) {
    add({std::move(file), line, std::move(code), std::move(message), true});
  }
  void error(const SourceLocation& where, std::string code, std::string message) {
    error(where.file, where.line, std::move(code), std::move(message));
  }
  void note(std::string file, uint32_t line, std::string code, std::string message) {
    add({std::move(file), line, std::move(code), std::move(message), false});
  }
  void append(const Diagnostics& other) {
    items_.insert(items_.end(), other.items_.begin(), other.items_.end());
  }

  bool hasErrors() const;
  bool hasCode(std::string_view code) const;

  /// Sorted by file and line, each message once.
  std::vector<Diagnostic> sorted() const;
  /// In the order in which they were added.
  const std::vector<Diagnostic>& items() const { return items_; }

  /// The sorted messages, one per line: "file:line: error: [PK012] message".
  std::string format() const;

 private:
  std::vector<Diagnostic> items_;
};

}  // namespace pelage::codegen
