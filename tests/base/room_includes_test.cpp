// Rooms use those below them, and none above, in the core and in the kernels. Tests have the same
// rooms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

// From the bottom up.
constexpr std::array<std::string_view, 11> kRooms = {"base",   "assets",  "passes",     "skinning",
                                                     "sdf",    "contact", "simulation", "shading",
                                                     "shadow", "oit",     "scene"};

// Folders of tests that are not of one room.
constexpr std::array<std::string_view, 20> kOtherTests = {
    "c",      "authoring", "bake",   "blender", "codegen",   "consumer", "demo",
    "fuzz",   "gl",        "golden", "maya",    "reference", "settings", "ray_tracing",
    "stress", "support",   "usd",    "viewer",  "webgpu",    "vulkan"};

size_t heightOf(std::string_view room) {
  return static_cast<size_t>(std::find(kRooms.begin(), kRooms.end(), room) - kRooms.begin());
}

// Public headers that belong to a room, with the lowest room that may include them. The others are
// plain data and interfaces that every room may use.
const std::map<std::string_view, std::string_view> kPublicHeaders = {
    {"skeleton_pose.h", "skinning"},
    {"sdf_collider.h", "sdf"},
    {"engine_lights.h", "shading"},
    {"hair_depth.h", "shading"},
    {"strand_texture.h", "shading"},
    {"view.h", "shading"},
    {"transparency.h", "oit"},
    {"cache_player.h", "scene"},
    {"frame.h", "scene"},
    {"hair_object.h", "scene"},
    {"headless.h", "scene"},
    {"pelage.h", "scene"},
    {"scene.h", "scene"},
    {"scene_features.h", "scene"},
};

// The room of a public header; the lowest for one that every room may use.
std::string_view publicRoomOf(std::string_view include) {
  constexpr std::string_view kFolder = "pelage/";
  if (!include.starts_with(kFolder)) return kRooms.front();
  const auto found = kPublicHeaders.find(include.substr(kFolder.size()));
  return found == kPublicHeaders.end() ? kRooms.front() : found->second;
}

// Paths in quotes that a source includes.
std::vector<std::string> includesOf(const fs::path& source) {
  std::vector<std::string> includes;
  std::ifstream in(source);
  constexpr std::string_view kStart = "#include \"";
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(kStart)) continue;
    const size_t end = line.find('"', kStart.size());
    if (end != std::string::npos)
      includes.push_back(line.substr(kStart.size(), end - kStart.size()));
  }
  return includes;
}

std::vector<fs::path> sourcesIn(const fs::path& folder) {
  std::vector<fs::path> sources;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".cpp" || extension == ".h" || extension == ".hlsl" || extension == ".hlsli")
      sources.push_back(entry.path());
  }
  std::sort(sources.begin(), sources.end());
  return sources;
}

// The room of an include of the core; empty for a public header.
std::string roomOf(const std::string& include) {
  const size_t slash = include.find('/');
  if (slash == std::string::npos || include.starts_with("pelage/")) return {};
  return include.substr(0, slash);
}

TEST(RoomIncludes, EveryFolderOfTheCoreIsARoom) {
  for (const fs::directory_entry& entry :
       fs::directory_iterator(fs::path(PELAGE_SOURCE_DIR) / "runtime/core")) {
    if (entry.is_directory())
      EXPECT_LT(heightOf(entry.path().filename().string()), kRooms.size()) << entry.path();
    else
      EXPECT_EQ(entry.path().filename(), "CMakeLists.txt");
  }
}

TEST(RoomIncludes, PointDown) {
  for (const std::string_view room : kRooms) {
    const std::vector<fs::path> sources =
        sourcesIn(fs::path(PELAGE_SOURCE_DIR) / "runtime/core" / room);
    ASSERT_FALSE(sources.empty()) << room;
    for (const fs::path& source : sources)
      for (const std::string& include : includesOf(source)) {
        const std::string used = roomOf(include);
        if (used.empty()) {
          EXPECT_TRUE(include.starts_with("pelage/"))
              << source << " includes " << include << " without its room";
          EXPECT_LE(heightOf(publicRoomOf(include)), heightOf(room))
              << source << " includes " << include;
          continue;
        }
        EXPECT_LE(heightOf(used), heightOf(room)) << source << " includes " << include;
      }
  }
}

TEST(RoomIncludes, OfPublicHeadersPointDown) {
  const fs::path folder = fs::path(PELAGE_SOURCE_DIR) / "include/pelage";
  for (const auto& [header, room] : kPublicHeaders)
    EXPECT_TRUE(fs::exists(folder / header)) << header << " of " << room;
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() || name == "vulkan.h" || name == "gl.h" || name == "ray_tracing.h")
      continue;
    for (const std::string& include : includesOf(entry.path())) {
      ++count;
      EXPECT_LE(heightOf(publicRoomOf(include)), heightOf(publicRoomOf("pelage/" + name)))
          << name << " includes " << include;
    }
  }
  EXPECT_GT(count, 100u);
}

// The folders in one of the tree.
std::vector<std::string> foldersIn(const std::string& folder) {
  std::vector<std::string> folders;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(fs::path(PELAGE_SOURCE_DIR) / folder))
    if (entry.is_directory()) folders.push_back(entry.path().filename().string());
  return folders;
}

TEST(RoomIncludes, KernelsHaveTheRoomsOfTheCore) {
  const std::vector<std::string> folders = foldersIn("kernels");
  EXPECT_GE(folders.size(), 8u);
  for (const std::string& folder : folders) EXPECT_LT(heightOf(folder), kRooms.size()) << folder;
}

TEST(RoomIncludes, OfKernelsPointDown) {
  const fs::path root = fs::path(PELAGE_SOURCE_DIR) / "kernels";
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension();
    if (extension != ".hlsl" && extension != ".hlsli") continue;
    const std::string room = entry.path().lexically_relative(root).begin()->string();
    for (const std::string& include : includesOf(entry.path())) {
      const fs::path beside = (entry.path().parent_path() / include).lexically_normal();
      ASSERT_TRUE(fs::exists(beside)) << entry.path() << " includes " << include;
      const std::string used = beside.lexically_relative(root).begin()->string();
      EXPECT_LE(heightOf(used), heightOf(room)) << entry.path() << " includes " << include;
      ++count;
    }
  }
  EXPECT_GT(count, 100u);
}

TEST(RoomIncludes, TestsHaveTheRoomsOfTheCore) {
  std::vector<std::string> folders = foldersIn("tests");
  for (const std::string_view room : kRooms)
    EXPECT_EQ(std::count(folders.begin(), folders.end(), room), 1) << room;
  std::erase_if(folders, [](const std::string& folder) {
    return heightOf(folder) < kRooms.size() ||
           std::find(kOtherTests.begin(), kOtherTests.end(), folder) != kOtherTests.end();
  });
  EXPECT_TRUE(folders.empty()) << "tests/" << folders.front() << " is no room";
}

// What is built on the core takes its public headers, and of its rooms the lowest alone.
TEST(RoomIncludes, OfOtherLibrariesAreOfPublicHeadersAndTheBase) {
  for (const std::string_view folder :
       {"runtime/c", "runtime/demo", "runtime/ray_tracing", "runtime/vulkan", "runtime/gl"}) {
    const std::vector<fs::path> sources = sourcesIn(fs::path(PELAGE_SOURCE_DIR) / folder);
    ASSERT_FALSE(sources.empty()) << folder;
    for (const fs::path& source : sources)
      for (const std::string& include : includesOf(source)) {
        const std::string used = roomOf(include);
        if (heightOf(used) == kRooms.size()) continue;
        EXPECT_EQ(used, "base") << source << " includes " << include;
      }
  }
}

// A path that both the core and the folder have is the folder's own.
TEST(RoomIncludes, OfToolsAreOfPublicHeaders) {
  const fs::path root = PELAGE_SOURCE_DIR;
  // It measures the functions with which a scene builds SDFs.
  const fs::path exception = root / "benchmark/sdf/pelage_sdf.cpp";
  size_t count = 0;
  for (const std::string_view folder : {"tools", "sample", "benchmark", "viewer"})
    for (const fs::path& source : sourcesIn(root / folder)) {
      const std::string extension = source.extension().string();
      if (source == exception || (extension != ".cpp" && extension != ".h")) continue;
      for (const std::string& include : includesOf(source)) {
        const bool own =
            fs::exists(root / folder / include) || fs::exists(source.parent_path() / include);
        EXPECT_TRUE(own || !fs::exists(root / "runtime/core" / include))
            << source << " includes " << include;
        ++count;
      }
    }
  EXPECT_GT(count, 500u);
}

}  // namespace
