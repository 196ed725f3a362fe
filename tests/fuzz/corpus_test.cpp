// The fuzzers' corpus, and every truncation of it, through the fuzzers' functions: for builds
// without libFuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/random.h"
#include "support/test_folder.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

using test::bytesOf;
using test::textOf;

struct Target {
  const char* name;
  Outcome (*run)(std::span<const std::byte>);
};
constexpr Target kTargets[] = {
    {"tfx", tfx},         {"tfxbone", tfxbone},     {"tfxmesh", tfxmesh},
    {"tfxskin", tfxskin}, {"tfxfollow", tfxfollow}, {"psdf", psdf},
    {"cache", cache},     {"settings", settings},   {"haircache", haircache},
#if PELAGE_FUZZ_CURVES
    {"hair", hair},       {"hairtxt", hairtxt},     {"obj", obj},
    {"gltf", gltf},       {"tfxcurves", tfxcurves}, {"animation", animation},
    {"pc2", pc2},         {"skinobj", skinobj},     {"usda", usda},
#endif
};

class Corpus : public testing::TestWithParam<Target> {
 protected:
  static std::vector<std::filesystem::path> files() {
    std::vector<std::filesystem::path> paths;
    const auto folder = std::filesystem::path(PELAGE_SOURCE_DIR) / "tests/fuzz/corpus";
    for (const auto& entry : std::filesystem::directory_iterator(folder / GetParam().name))
      paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    return paths;
  }
};

TEST_P(Corpus, KeepsEveryPromiseAndTakesWhatIsValid) {
  int valid = 0;
  for (const auto& path : files()) {
    const Outcome outcome = GetParam().run(bytesOf(path));
    EXPECT_EQ(outcome.fault, "") << path;
    if (path.filename().string().rfind("valid", 0) != 0) continue;
    EXPECT_TRUE(outcome.loaded) << path;
    ++valid;
  }
  EXPECT_GT(valid, 0);
}

TEST_P(Corpus, EveryTruncationKeepsEveryPromise) {
  for (const auto& path : files()) {
    const std::vector<std::byte> whole = bytesOf(path);
    for (size_t size = 0; size < whole.size(); ++size) {
      // A copy of its own, so that a sanitizer sees a read past the end.
      const std::vector<std::byte> part(whole.begin(),
                                        whole.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_EQ(GetParam().run(part).fault, "") << path << " cut to " << size;
    }
  }
}

// Bits that flip and characters of numbers, most of them at the start, where they do more.
TEST_P(Corpus, RandomDamageKeepsEveryPromise) {
  std::vector<std::vector<std::byte>> whole;
  for (const auto& path : files()) whole.push_back(bytesOf(path));
  Random random(11);
  for (size_t round = 0; round < 10000; ++round) {
    std::vector<std::byte> bytes = whole[round % whole.size()];
    const auto size = static_cast<uint32_t>(bytes.size());
    for (uint32_t k = 1 + random.below(4); k > 0 && size > 0; --k) {
      std::byte& byte = bytes[random.below(random.below(2) == 0 ? std::min(size, 64u) : size)];
      constexpr std::string_view kCharacters = "0123456789-+.eE ";
      if (random.below(2) == 0)
        byte ^= static_cast<std::byte>(1u << random.below(8));
      else
        byte = static_cast<std::byte>(kCharacters[random.below(kCharacters.size())]);
    }
    ASSERT_EQ(GetParam().run(bytes).fault, "") << "file " << round % whole.size() << ", " << round;
  }
}

// docs/assets.md lists the targets, in the rows of its table of fuzzers.
TEST(FuzzPage, ListsEveryTarget) {
  const std::string page = textOf(std::filesystem::path(PELAGE_SOURCE_DIR) / "docs/assets.md");
  const std::string heading = "\n## Fuzzers\n";
  const size_t start = page.find(heading);
  ASSERT_NE(start, std::string::npos);
  const std::string section =
      page.substr(start, page.find("\n## ", start + heading.size()) - start);
  std::set<std::string> listed, wanted;
  const std::regex row(R"(\n\| ([^|]*)\|)"), name("`(\\w+)`");
  for (std::sregex_iterator it(section.begin(), section.end(), row), end; it != end; ++it) {
    const std::string cell = (*it)[1].str();
    for (std::sregex_iterator one(cell.begin(), cell.end(), name); one != end; ++one)
      listed.insert((*one)[1].str());
  }
  for (const Target& target : kTargets) {
    wanted.insert(target.name);
    EXPECT_TRUE(listed.contains(target.name)) << target.name << " is not on the page";
  }
#if PELAGE_FUZZ_CURVES
  EXPECT_EQ(listed, wanted);
#endif
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace pelage::fuzz
