// The work on one permutation, in two steps that run in child processes: the front end, which needs
// nothing but the source, and the back end, which needs the binding plan of all kernels. A third
// kind of child evaluates the constants of a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codegen/back_end.h"
#include "codegen/constants.h"
#include "codegen/diagnostics.h"
#include "codegen/front_end.h"
#include "codegen/manifest.h"
#include "codegen/reflect.h"

namespace pelage::codegen {

struct FrontEndJob {
  FrontEndInput source;
  bool precise = false;
};

struct FrontEndResult {
  bool complete = false;  ///< false: the results until the process ended early
  Diagnostics diagnostics;
  std::vector<uint32_t> spirv;  ///< empty when it does not compile
  std::string log;
  std::vector<std::string> files;
  std::map<std::string, SourceLocation> declarations;  ///< resources, structs, blocks, functions
};

/// The constants of a file; see codegen/constants.h.
struct ConstantsJob {
  FrontEndInput source;  ///< baseDir, file and includeDirs
};

struct ConstantsResult {
  bool complete = false;
  Diagnostics diagnostics;
  std::vector<std::string> files;  ///< read: the file first, then what it includes
  std::vector<SharedConstant> constants;
};

struct BackEndJob {
  std::string file;
  std::string entry;
  SourceLocation entryLocation;
  Stage stage = Stage::kCompute;
  Tier tier = Tier::kBase;
  bool precise = false;
  uint32_t firstStorageBinding = 0;
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

/// A permutation of a kernel with the results of its steps.
struct Unit {
  const ManifestKernel* kernel = nullptr;
  Permutation permutation;
  std::string key;  ///< permutationKey()
  FrontEndResult front;
  std::optional<ModuleReflection> reflection;  ///< of the front end's module, if there is one
  BackEndResult back;
  uint32_t firstStorageBinding = 0;  ///< on GL
  uint32_t storageBuffers = 0;       ///< that the optimized module has
  bool ran = false;                  ///< a child process worked for it

  /// "'skin_roots' with wind=1".
  std::string text() const;
  /// Returns where the kernel declares a name; the start of its file if that is unknown.
  SourceLocation locate(const std::string& name) const;
};

std::string encode(const FrontEndJob& job);
std::string encode(const BackEndJob& job);
std::string encode(const ConstantsJob& job);
std::string encode(const FrontEndResult& result);
std::string encode(const BackEndResult& result);
std::string encode(const ConstantsResult& result);
/// Empty when the text is not an encoded result.
std::optional<FrontEndResult> decodeFrontEndResult(const std::string& text);
std::optional<BackEndResult> decodeBackEndResult(const std::string& text);
std::optional<ConstantsResult> decodeConstantsResult(const std::string& text);

/// In the child process: reads the encoded job in `stem`.job and writes its result to
/// `stem`.result. Returns 0 if that worked.
int runUnit(const std::filesystem::path& stem);

}  // namespace pelage::codegen
