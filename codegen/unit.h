// The work on one permutation, in two steps that run in child processes: the front end, which needs
// nothing but the source, and the back end, which needs the binding plan of all kernels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codegen/back_end.h"
#include "codegen/diagnostics.h"
#include "codegen/front_end.h"

namespace pelage::codegen {

/// Where something is declared.
struct SourceLocation {
  std::string file;
  uint32_t line = 1;
};

struct FrontEndJob {
  FrontEndInput source;
  std::string kernel;
  bool desktopTier = false;
  bool precise = false;
};

struct FrontEndResult {
  bool complete = false;  ///< false: what was known when the process ended early
  Diagnostics diagnostics;
  std::vector<uint32_t> spirv;  ///< empty when it does not compile
  std::string log;
  std::vector<std::string> files;
  std::map<std::string, SourceLocation> declarations;  ///< resources, structs, blocks, functions
};

struct BackEndJob {
  std::string kernel;
  std::string file;
  std::string entry;
  SourceLocation entryLocation;
  Stage stage = Stage::kCompute;
  bool desktopTier = false;
  bool precise = false;
  std::vector<uint32_t> spirv;
  std::string log;
  std::vector<BindingPatch> patches;
};

struct BackEndResult {
  bool complete = false;
  Diagnostics diagnostics;
  std::vector<uint32_t> optimised;
  std::vector<uint32_t> spirv;
  std::string glsl;
  std::string essl;
};

std::string encode(const FrontEndJob& job);
std::string encode(const BackEndJob& job);
std::string encode(const FrontEndResult& result);
std::string encode(const BackEndResult& result);
/// Empty when the text is not an encoded result.
std::optional<FrontEndResult> decodeFrontEndResult(const std::string& text);
std::optional<BackEndResult> decodeBackEndResult(const std::string& text);

/// The child process: reads an encoded job and writes its result. Returns the exit status.
int runUnit(const std::filesystem::path& job, const std::filesystem::path& result);

}  // namespace pelage::codegen
