// pelage/pelage.h is all of the core, and the version is the same wherever it is stated.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include "pelage/pelage.h"
#include "support/test_folder.h"

namespace {

namespace fs = std::filesystem;
using pelage::test::textOf;

TEST(PublicHeaders, AreAllInTheOneThatHasTheCore) {
  const fs::path folder = fs::path(PELAGE_SOURCE_DIR) / "include/pelage";
  const std::string text = textOf(folder / "pelage.h");
  const std::set<std::string> apart = {"pelage.h",      "vulkan.h",   "gl.h",         "headless.h",
                                       "mesh_import.h", "pelage_c.h", "ray_tracing.h"};
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (entry.is_directory() || apart.contains(name)) continue;
    ++count;
    EXPECT_NE(text.find("#include \"pelage/" + name + "\""), std::string::npos) << name;
  }
  EXPECT_GT(count, 20u);
}

TEST(PublicHeaders, HaveTheVersionOfTheProject) {
  EXPECT_EQ(pelage::libraryVersion(), static_cast<uint32_t>(PELAGE_VERSION));
  EXPECT_EQ(std::to_string(PELAGE_VERSION_MAJOR) + "." + std::to_string(PELAGE_VERSION_MINOR) +
                "." + std::to_string(PELAGE_VERSION_PATCH),
            PELAGE_TEST_PROJECT_VERSION);
}

}  // namespace
