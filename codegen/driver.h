// Runs all steps from a manifest to the generated files.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "codegen/diagnostics.h"
#include "codegen/program.h"

namespace pelage::codegen {

struct BuildOptions {
  std::filesystem::path manifest;
  std::vector<std::filesystem::path> includeDirs;
  std::filesystem::path outputDir;       ///< gets include/<namespace>/*.h, *.cpp and code/*.cpp
  std::filesystem::path reflectionFile;  ///< empty: reflection.json in outputDir
  std::filesystem::path depFile;         ///< empty: none. Needs stampFile.
  std::filesystem::path stampFile;       ///< empty: none. Touched after every success.
  std::filesystem::path cacheDir;        ///< empty: "cache" in outputDir
  std::filesystem::path tool;            ///< pelage-codegen, which the children run
  std::filesystem::path wgslTranslator;  ///< wgsl/translate.mjs with its packages; empty: no WGSL
  std::filesystem::path node = "node";   ///< Node.js, which runs it
  bool msl = false;                      ///< MSL and its slots, for Metal
  bool hlsl = false;                     ///< how DXC makes the kernels, for Direct3D 12
  bool keepNames = false;                ///< debug names in SPIR-V, indentation in GLSL
  unsigned jobs = 0;                     ///< parallel children; 0: one per hardware thread
  std::chrono::seconds timeout{120};     ///< of a child
};

struct BuildResult {
  Diagnostics diagnostics;  ///< with paths that start like BuildOptions::manifest
  bool ok = false;          ///< no errors, everything written
  size_t permutations = 0;
  size_t compiled = 0;  ///< permutations for which a compiler ran
  size_t fromCache = 0;
  size_t distinct = 0;  ///< variants after removing equal ones
  Program program;

  /// "pelage-codegen: 24 permutations, 0 compiled, 24 from cache, 19 distinct".
  std::string summary() const;
};

/// Compiles, checks and writes. After an error no output is written.
BuildResult build(const BuildOptions& options);

}  // namespace pelage::codegen
