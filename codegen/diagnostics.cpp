#include "codegen/diagnostics.h"

#include <algorithm>

namespace pelage::codegen {

bool Diagnostics::hasErrors() const {
  return std::any_of(items_.begin(), items_.end(), [](const Diagnostic& d) { return d.isError; });
}

bool Diagnostics::hasCode(std::string_view code) const {
  return std::any_of(items_.begin(), items_.end(),
                     [code](const Diagnostic& d) { return d.code == code; });
}

std::vector<Diagnostic> Diagnostics::sorted() const {
  std::vector<Diagnostic> result = items_;
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

std::string Diagnostics::format() const {
  std::string text;
  for (const Diagnostic& d : sorted()) {
    text += d.file + ":" + std::to_string(d.line) + (d.isError ? ": error: [" : ": note: [") +
            d.code + "] " + d.message + "\n";
  }
  return text;
}

}  // namespace pelage::codegen
