#include "test_project.h"

#include <gtest/gtest.h>

#include <fstream>

namespace pelage::codegen::test {

namespace fs = std::filesystem;

TestProject::TestProject() { fs::create_directories(folder_ / "src"); }

void TestProject::write(const std::string& name, std::string_view text) const {
  const fs::path path = folder() / "src" / name;
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  ASSERT_TRUE(stream.good()) << path;
}

void TestProject::copy(const fs::path& source) const {
  fs::copy(source, folder_ / "src",
           fs::copy_options::recursive | fs::copy_options::overwrite_existing);
}

BuildOptions TestProject::options() const {
  BuildOptions options;
  options.manifest = manifest();
  options.outputDir = output();
  options.tool = PELAGE_CODEGEN_TOOL;
  return options;
}

std::map<std::string, std::string> TestProject::outputs() const {
  std::map<std::string, std::string> files;
  if (!fs::exists(output())) return files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(output())) {
    const std::string name = entry.path().lexically_relative(output()).generic_string();
    if (entry.is_regular_file() && !name.starts_with("cache/"))
      files[name] = fileText(entry.path());
  }
  return files;
}

std::string manifestWith(std::string_view kernels) {
  return "{\n  \"namespace\": \"fixture\",\n  \"groups\": {\"g\": [\"First\", \"Second\"]},\n"
         "  \"kernels\": [\n" +
         std::string(kernels) + "\n  ]\n}\n";
}

std::string computeKernel(std::string_view name, std::string_view more) {
  const std::string n(name);
  return "    {\"name\": \"" + n + "\", \"file\": \"" + n +
         ".hlsl\", \"stage\": \"compute\", \"group\": \"g\"" + std::string(more) + "}";
}

std::string fileText(const fs::path& path) {
  EXPECT_TRUE(fs::is_regular_file(path)) << path;
  return pelage::test::textOf(path);
}

}  // namespace pelage::codegen::test
