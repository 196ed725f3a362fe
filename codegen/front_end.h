// The only interface to glslang: HLSL to SPIR-V, and the check that a GLSL text parses. Another
// front end would only replace front_end.cpp: docs/decisions/0018-front-end.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pelage/layout.h"

namespace pelage::codegen {

/// Registers are told apart by their class in the binding numbers of the raw module:
/// binding = class base + register number. A binding below kUniformBase comes from a resource
/// without register().
struct RegisterBase {
  static constexpr uint32_t kUniform = 10000;  ///< b
  static constexpr uint32_t kTexture = 20000;  ///< t
  static constexpr uint32_t kUav = 30000;      ///< u
  static constexpr uint32_t kSampler = 40000;  ///< s
};

/// One HLSL compilation.
struct FrontEndInput {
  std::filesystem::path baseDir;  ///< files below it are named relative to it
  std::string file;               ///< relative to baseDir
  std::string entry;
  Stage stage = Stage::kCompute;
  std::vector<std::pair<std::string, std::string>> macros;
  std::vector<std::filesystem::path>
      includeDirs;  ///< searched after the includer's folder, baseDir
  /// Compiled instead of the file's content if set; #line gives its origin.
  std::optional<std::string> text;
};

struct FrontEndMessage {
  std::string file;
  uint32_t line = 0;
  std::string text;
  bool isError = true;
};

struct FrontEndOutput {
  bool ok = false;
  std::vector<uint32_t> spirv;  ///< with names and line numbers
  std::vector<FrontEndMessage> messages;
  std::string log;                        ///< all messages, unchanged
  std::vector<std::string> files;         ///< files read: the source first, then its includes
  std::vector<std::string> missingFiles;  ///< files that were searched and do not exist
};

struct PreprocessOutput {
  bool ok = false;
  std::string text;  ///< with #line directives
  std::vector<FrontEndMessage> messages;
  std::vector<std::string> files;
  std::vector<std::string> missingFiles;
};

/// Runs the preprocessor alone.
PreprocessOutput preprocessHlsl(const FrontEndInput& input);

/// Compiles HLSL to unoptimised SPIR-V 1.3 for Vulkan 1.1 with storage buffers in their own class.
FrontEndOutput compileHlsl(const FrontEndInput& input);

/// Parses GLSL 450 core or ESSL 320. Returns an empty text if it is accepted, otherwise the
/// parser's messages.
std::string parseGlsl(std::string_view text, Stage stage);

/// Name and version of the front end, for cache keys.
std::string frontEndVersion();

/// Returns the compiler's name of `file`: relative to baseDir if it is below it, otherwise
/// absolute.
std::string displayName(const std::filesystem::path& file, const std::filesystem::path& baseDir);

}  // namespace pelage::codegen
