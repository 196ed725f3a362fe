#include "codegen/include_scan.h"

#include <optional>
#include <sstream>
#include <system_error>

#include "codegen/file_io.h"
#include "codegen/front_end.h"
#include "codegen/hash.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

struct IncludeLine {
  std::string name;
  bool quoted = false;
};

void skipBlanks(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

// `#include "x"` and `#include <x>`, also in comments and in branches that are not taken: more than
// what is really included does no harm here.
std::optional<IncludeLine> parseInclude(std::string_view line) {
  skipBlanks(line);
  if (!line.starts_with('#')) return std::nullopt;
  line.remove_prefix(1);
  skipBlanks(line);
  if (!line.starts_with("include")) return std::nullopt;
  line.remove_prefix(7);
  skipBlanks(line);
  if (line.empty() || (line.front() != '"' && line.front() != '<')) return std::nullopt;
  const bool quoted = line.front() == '"';
  const size_t end = line.find(quoted ? '"' : '>', 1);
  if (end == std::string_view::npos) return std::nullopt;
  return IncludeLine{std::string(line.substr(1, end - 1)), quoted};
}

}  // namespace

fs::path IncludeScanner::pathOf(const std::string& name) const {
  const fs::path path(name);
  return path.is_absolute() ? path : baseDir_ / path;
}

IncludeScanner::Entry& IncludeScanner::entry(const std::string& name) {
  const auto found = entries_.find(name);
  if (found != entries_.end()) return found->second;
  Entry& entry = entries_[name];
  const std::optional<std::string> text = readWholeFile(pathOf(name));
  if (!text) return entry;
  entry.hash = sha256Hex(*text);
  std::istringstream stream(*text);
  for (std::string line; std::getline(stream, line);) {
    const std::optional<IncludeLine> include = parseInclude(line);
    if (!include) continue;
    std::vector<fs::path> candidates;
    if (include->quoted) candidates.push_back(pathOf(name).parent_path() / include->name);
    candidates.push_back(baseDir_ / include->name);
    for (const fs::path& dir : includeDirs_) candidates.push_back(dir / include->name);
    for (const fs::path& candidate : candidates) {
      std::error_code error;
      if (!fs::is_regular_file(candidate, error)) continue;
      entry.includes.push_back(displayName(candidate, baseDir_));
      break;
    }
  }
  return entry;
}

std::set<fs::path> IncludeScanner::files() const {
  std::set<fs::path> paths;
  for (const auto& [name, entry] : entries_) paths.insert(pathOf(name).lexically_normal());
  return paths;
}

std::vector<std::string> IncludeScanner::closure(const std::string& file) {
  std::set<std::string> seen;
  std::vector<std::string> pending{displayName(pathOf(file), baseDir_)};
  while (!pending.empty()) {
    const std::string name = pending.back();
    pending.pop_back();
    if (!seen.insert(name).second) continue;
    for (const std::string& include : entry(name).includes) pending.push_back(include);
  }
  return {seen.begin(), seen.end()};
}

}  // namespace pelage::codegen
