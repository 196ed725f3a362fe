// Links between documents lead somewhere, and so do paths of the tree that texts and comments name.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "support/test_folder.h"

namespace {

namespace fs = std::filesystem;
using pelage::test::textOf;

const fs::path kRoot = PELAGE_SOURCE_DIR;

// Folders at the root that hold sources; others are made by builds.
constexpr std::array<std::string_view, 13> kFolders = {
    ".github",   "benchmark", "cmake",  "codegen", "docs",  "include", "kernels",
    "packaging", "runtime",   "sample", "scripts", "tests", "tools"};

std::vector<fs::path> filesOf(const std::set<std::string>& extensions) {
  std::vector<fs::path> files;
  const auto add = [&](const fs::directory_entry& entry) {
    if (entry.is_regular_file() && extensions.contains(entry.path().extension()))
      files.push_back(entry.path());
  };
  for (const fs::directory_entry& entry : fs::directory_iterator(kRoot)) add(entry);
  for (const std::string_view folder : kFolders)
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder))
      add(entry);
  std::sort(files.begin(), files.end());
  return files;
}

// A page without its code: fenced blocks and what is between backticks.
std::string proseOf(const std::string& page) {
  std::string prose;
  std::istringstream lines(page);
  bool code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      code = !code;
      continue;
    }
    if (code) continue;
    static const std::regex inlineCode("`[^`]*`");
    prose += std::regex_replace(line, inlineCode, "") + "\n";
  }
  return prose;
}

// The anchor that a heading gets: lower case, words joined by hyphens, punctuation left out.
std::string anchorOf(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-')
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (c == ' ')
      anchor += '-';
  }
  return anchor;
}

std::set<std::string> anchorsOf(const fs::path& page) {
  std::set<std::string> anchors;
  std::ifstream in(page);
  bool code = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) code = !code;
    if (code || !line.starts_with("#")) continue;
    const size_t start = line.find_first_not_of("# ");
    if (start != std::string::npos) anchors.insert(anchorOf(line.substr(start)));
  }
  return anchors;
}

// Paths of the tree that a text names as docs/... or tests/...; not those that go on with a
// variable.
std::set<std::string> pathsIn(const std::string& text) {
  static const std::regex path(
      R"((^|[^A-Za-z0-9_./}-])((?:docs|tests)/[A-Za-z0-9_/.-]*[A-Za-z0-9_])(?![A-Za-z0-9_$]))");
  std::set<std::string> paths;
  for (std::sregex_iterator it(text.begin(), text.end(), path), end; it != end; ++it)
    paths.insert((*it)[2].str());
  return paths;
}

// A file or folder, a source that is named without its extension, or a decision by its number.
bool isThere(const std::string& path) {
  if (fs::exists(kRoot / path)) return true;
  constexpr std::string_view kDecisions = "docs/decisions/";
  if (path.starts_with(kDecisions) && path.size() == kDecisions.size() + 4) {
    const std::string number = path.substr(kDecisions.size());
    for (const fs::directory_entry& entry : fs::directory_iterator(kRoot / kDecisions))
      if (entry.path().filename().string().starts_with(number + "-")) return true;
  }
  return fs::exists(kRoot / (path + ".cpp")) || fs::exists(kRoot / (path + ".h"));
}

TEST(DocumentLinks, LeadToFilesAndHeadings) {
  static const std::regex link(R"(\]\(([^)\s]+)\))");
  size_t count = 0;
  std::map<fs::path, std::set<std::string>> anchors;
  for (const fs::path& page : filesOf({".md"})) {
    const std::string prose = proseOf(textOf(page));
    for (std::sregex_iterator it(prose.begin(), prose.end(), link), end; it != end; ++it) {
      const std::string target = (*it)[1].str();
      if (target.find("://") != std::string::npos) continue;
      ++count;
      const size_t hash = target.find('#');
      const std::string file = target.substr(0, hash);
      const fs::path path = file.empty() ? page : (page.parent_path() / file).lexically_normal();
      EXPECT_TRUE(fs::exists(path)) << page << " links to " << target;
      if (hash == std::string::npos || !fs::exists(path)) continue;
      if (!anchors.contains(path)) anchors[path] = anchorsOf(path);
      EXPECT_TRUE(anchors[path].contains(target.substr(hash + 1)))
          << page << " links to " << target << ", which has no such heading";
    }
  }
  EXPECT_GT(count, 100u);
}

TEST(DocumentLinks, PathsInTextsAndCommentsAreThere) {
  size_t count = 0;
  for (const fs::path& file :
       filesOf({".md", ".h", ".cpp", ".hlsl", ".hlsli", ".txt", ".cmake", ".sh", ".py"}))
    for (const std::string& path : pathsIn(textOf(file))) {
      ++count;
      EXPECT_TRUE(isThere(path)) << file << " names " << path;
    }
  EXPECT_GT(count, 100u);
}

// The lines of a comment, or of the code up to the end of the declaration that follows it.
struct Comment {
  std::string text;
  std::string declaration;
};

std::string trimmed(const std::string& line) {
  const size_t start = line.find_first_not_of(" \t");
  return start == std::string::npos ? std::string() : line.substr(start);
}

// A declaration ends at the first ';' or '{' outside of parentheses.
bool endsDeclaration(const std::string& code) {
  int depth = 0;
  for (const char c : code) {
    if (c == '(') ++depth;
    if (c == ')') --depth;
    if (depth == 0 && (c == ';' || c == '{')) return true;
  }
  return false;
}

std::vector<Comment> commentsOf(const fs::path& source) {
  std::vector<Comment> comments;
  std::ifstream in(source);
  bool inComment = false, open = false;
  for (std::string line; std::getline(in, line);) {
    const bool isComment = trimmed(line).starts_with("//");
    if (isComment && !inComment) comments.emplace_back();
    if (isComment) comments.back().text += line + "\n";
    if (inComment && !isComment) open = true;
    if (isComment) open = false;
    inComment = isComment;
    if (!open) continue;
    comments.back().declaration += line + "\n";
    open = !endsDeclaration(comments.back().declaration);
  }
  return comments;
}

bool hasWord(const std::string& text, const std::string& word) {
  return std::regex_search(text, std::regex("\\b" + word + "\\b"));
}

const std::set<std::string> kSources = {".h", ".cpp", ".hlsl", ".hlsli"};

// Sources whose comments describe functions and name files.
std::vector<fs::path> commentedFiles() {
  std::vector<fs::path> files = filesOf(kSources);
  std::erase_if(files, [](const fs::path& file) {
    static const std::set<std::string> folders = {"codegen", "include", "kernels", "runtime",
                                                  "tools"};
    return !folders.contains(file.lexically_relative(kRoot).begin()->string());
  });
  return files;
}

TEST(Comments, DescribeParametersOfTheDeclarationThatFollows) {
  static const std::regex param(R"(\\param\s+(\w+))");
  size_t count = 0;
  for (const fs::path& file : commentedFiles())
    for (const Comment& comment : commentsOf(file))
      for (std::sregex_iterator it(comment.text.begin(), comment.text.end(), param), end; it != end;
           ++it) {
        ++count;
        EXPECT_TRUE(hasWord(comment.declaration, (*it)[1].str()))
            << file << " describes parameter " << (*it)[1].str() << " of\n"
            << comment.declaration;
      }
  EXPECT_GT(count, 50u);
}

TEST(Comments, NameFilesThatAreThere) {
  // Made by the build, or of other projects.
  std::set<std::string> known = {"a.hlsl",       "bindings.h", "code.h",  "constants.h",
                                 "essl.h",       "format.h",   "glsl.h",  "gpu_structs.h",
                                 "kernels.h",    "layouts.h",  "spirv.h", "sysexits.h",
                                 "vulkan_core.h"};
  for (const fs::path& file : filesOf({".h", ".cpp", ".hlsl", ".hlsli", ".py", ".sh"}))
    known.insert(file.filename().string());
  static const std::regex comment(R"(//.*)");
  static const std::regex name(
      R"((^|[^A-Za-z0-9_.*])([a-z0-9_]+\.(?:hlsli?|h|cpp|py|sh))(?![A-Za-z0-9_]))");
  size_t count = 0;
  for (const fs::path& file : commentedFiles()) {
    const std::string text = textOf(file);
    for (std::sregex_iterator line(text.begin(), text.end(), comment), end; line != end; ++line) {
      const std::string words = line->str();
      for (std::sregex_iterator it(words.begin(), words.end(), name); it != end; ++it) {
        ++count;
        EXPECT_TRUE(known.contains((*it)[2].str())) << file << " names " << (*it)[2].str();
      }
    }
  }
  EXPECT_GT(count, 50u);
}

// Whoever knows one tree knows all.
TEST(DocumentLinks, EveryRoomThatUsersMeetHasAPage) {
  for (const char* room : {"assets", "passes", "skinning", "sdf", "contact", "simulation",
                           "shading", "shadow", "oit", "scene", "vulkan", "gl"})
    EXPECT_TRUE(fs::exists(kRoot / "docs" / (std::string(room) + ".md"))) << room;
}

}  // namespace
