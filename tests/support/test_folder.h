// Folders and files of tests, and programs that run in them.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pelage::test {

/// The whole file; empty if there is none.
inline std::string textOf(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return std::move(text).str();
}
inline std::vector<std::byte> bytesOf(const std::filesystem::path& path) {
  const std::string text = textOf(path);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// Empty when it is made, and removed with the object.
class TestFolder {
 public:
  TestFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pelage-test-XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr) << name;
    path_ = name;
  }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  ~TestFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// The outcome of a program; the code is -1 if it did not exit by itself.
struct ProgramOutput {
  int code = -1;
  std::string out, errors;
};

/// Runs a command of the shell in a folder, which keeps stdout.txt and stderr.txt.
inline ProgramOutput runIn(const std::filesystem::path& folder, const std::string& command) {
  const int status = std::system(
      ("cd '" + folder.string() + "' && " + command + " > stdout.txt 2> stderr.txt").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(folder / "stdout.txt"),
          textOf(folder / "stderr.txt")};
}

}  // namespace pelage::test
