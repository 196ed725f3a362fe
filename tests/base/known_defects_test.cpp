// Tags of known defects (K1, K2, ...) are listed in docs/known_defects.md.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "support/test_folder.h"

namespace {

namespace fs = std::filesystem;
using pelage::test::textOf;

// The tags in a text, by where they are.
std::set<std::string> tagsIn(const std::string& text) {
  static const std::regex tag(R"(\bK[1-9][0-9]?\b)");
  return {std::sregex_token_iterator(text.begin(), text.end(), tag), std::sregex_token_iterator()};
}

TEST(KnownDefects, EveryTagInTheTreeIsListed) {
  const fs::path root = PELAGE_SOURCE_DIR;
  const std::set<std::string> listed = tagsIn(textOf(root / "docs/known_defects.md"));
  EXPECT_EQ(listed.size(), 44u);
  std::map<std::string, fs::path> used;
  for (const char* folder : {"tests", "kernels", "docs", "benchmark"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().filename() == "known_defects.md") continue;
      const std::string extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".h" && extension != ".hlsl" &&
          extension != ".hlsli" && extension != ".md")
        continue;
      for (const std::string& tag : tagsIn(textOf(entry.path()))) used.emplace(tag, entry.path());
    }
  EXPECT_GT(used.size(), 40u);
  for (const auto& [tag, path] : used) EXPECT_TRUE(listed.contains(tag)) << tag << " in " << path;
}

}  // namespace
