// The fuzzers' corpus, and every truncation of it, through the fuzzers' functions: for builds
// without libFuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "targets.h"

namespace pelage::fuzz {
namespace {

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
    {"pc2", pc2},         {"skinobj", skinobj},
#endif
};

std::vector<std::byte> readAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

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
    const Outcome outcome = GetParam().run(readAll(path));
    EXPECT_EQ(outcome.fault, "") << path;
    if (path.filename().string().rfind("valid", 0) != 0) continue;
    EXPECT_TRUE(outcome.loaded) << path;
    ++valid;
  }
  EXPECT_GT(valid, 0);
}

TEST_P(Corpus, EveryTruncationKeepsEveryPromise) {
  for (const auto& path : files()) {
    const std::vector<std::byte> whole = readAll(path);
    for (size_t size = 0; size < whole.size(); ++size) {
      // A copy of its own, so that a sanitizer sees a read past the end.
      const std::vector<std::byte> part(whole.begin(),
                                        whole.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_EQ(GetParam().run(part).fault, "") << path << " cut to " << size;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace pelage::fuzz
