// Golden reflection. Another front end would have to match it. To accept a change that is meant,
// run this test with PELAGE_UPDATE_GOLDEN=1 in the environment and read the difference.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "test_project.h"

namespace pelage::codegen::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Without the hashes: they change with every version of the compilers, the rest must not.
std::string comparable(const std::string& text) {
  Json json = Json::parse(text);
  for (Json& kernel : json.at("kernels")) {
    for (Json& variant : kernel.at("variants")) variant.erase("hash");
  }
  return json.dump(2) + "\n";
}

void expectGolden(const std::string& actual, const std::string& name) {
  const fs::path golden = fs::path(PELAGE_CODEGEN_TEST_DIR) / "golden" / name;
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(golden, std::ios::binary) << actual;
    GTEST_SKIP() << "wrote " << golden;
  }
  const std::string expected = fileText(golden);
  if (actual == expected) return;
  size_t line = 1, i = 0;
  while (i < actual.size() && i < expected.size() && actual[i] == expected[i]) {
    line += actual[i++] == '\n';
  }
  const auto lineAt = [i](const std::string& text) {
    const size_t begin = i == 0 ? 0 : text.rfind('\n', i - 1) + 1;
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  ADD_FAILURE() << golden.string() << ":" << line << ": expected " << lineAt(expected)
                << "\nactual   " << lineAt(actual);
}

std::string reflect(const fs::path& manifest) {
  const TestProject project;
  BuildOptions options = project.options();
  options.manifest = manifest;
  const BuildResult result = build(options);
  EXPECT_TRUE(result.ok) << result.diagnostics.format();
  return result.ok ? comparable(fileText(project.output() / "reflection.json")) : "";
}

TEST(CodegenReflection, OfTheFixtureMatchesTheGoldenFile) {
  expectGolden(reflect(fs::path(PELAGE_CODEGEN_TEST_DIR) / "kernels" / "manifest.json"),
               "fixture.json");
}

TEST(CodegenReflection, OfPelagesKernelsMatchesTheGoldenFile) {
  // That of the build.
  expectGolden(comparable(fileText(PELAGE_KERNELS_REFLECTION)), "pelage.json");
}

}  // namespace
}  // namespace pelage::codegen::test
