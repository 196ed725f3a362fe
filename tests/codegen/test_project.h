// A folder with a manifest and kernels that a test writes, compiles and changes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "codegen/driver.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage::codegen::test {

class TestProject {
 public:
  TestProject();

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path manifest() const { return folder_ / "src" / "manifest.json"; }
  std::filesystem::path output() const { return folder_ / "out"; }

  /// Writes src/<name>.
  void write(const std::string& name, std::string_view text) const;
  /// Copies the contents of a folder to src.
  void copy(const std::filesystem::path& source) const;
  BuildOptions options() const;
  BuildResult build() const { return codegen::build(options()); }
  /// The generated files by name; not the cache.
  std::map<std::string, std::string> outputs() const;

 private:
  pelage::test::TestFolder folder_;
};

/// A manifest with one group "g" of the layouts "First" and "Second", and these kernels.
std::string manifestWith(std::string_view kernels);
/// A compute kernel of one file for it: {"name": name, "file": name.hlsl, ...}.
std::string computeKernel(std::string_view name, std::string_view more = "");

/// The whole file, or a failed test.
std::string fileText(const std::filesystem::path& path);

}  // namespace pelage::codegen::test
