// Checks for HLSL that the front end accepts and turns into wrong numbers, invalid output or a
// crash. README.md in this folder has the table: number, trap, how it is found, what to write
// instead.
//
// PK1xx are found in the preprocessed text before the front end sees it, PK2xx in the output of the
// front end and the back ends.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/diagnostics.h"
#include "pelage/layout.h"
#include "pelage/tier.h"

namespace pelage::codegen {

/// One permutation of one kernel, and its results so far.
struct CheckInput {
  Stage stage = Stage::kCompute;
  std::string entry;
  /// Name of the kernel's file in messages; `preprocessed` starts in it.
  std::string file;
  /// The whole kernel after the preprocessor, with `#line N "file"` where the file or line jumps.
  std::string preprocessed;
  /// As written by the front end: not optimized, with OpLine and names.
  std::span<const uint32_t> rawSpirv = {};
  /// Empty if an earlier step failed.
  std::span<const uint32_t> optimisedSpirv = {};
  /// All messages of the front end and its SPIR-V builder, one per line.
  std::string frontEndLog;
  std::string glsl;  ///< GLSL 450; empty if an earlier step failed
  std::string essl;  ///< ESSL 320; empty if an earlier step failed
  /// The devices that the permutation has to run on. Tier::kWide does without ESSL.
  Tier tier = Tier::kBase;
  /// The kernel promises the same bits on every API: nothing in optimisedSpirv may be contracted.
  bool precise = false;
};

/// Checks before compilation. Reads stage, entry, file and preprocessed. After an
/// error, do not pass the text to the front end: some of the refused code crashes it.
void runSourceChecks(const CheckInput& input, Diagnostics& diagnostics);

/// Checks after compilation; also if validation, optimization or cross-compilation failed, because
/// these checks then explain why, with a line. Reads everything except `preprocessed`; empty parts
/// are skipped, so it may be called after the front end and again after the back end.
void runModuleChecks(const CheckInput& input, Diagnostics& diagnostics);

/// Returns the module with NoContraction on every floating-point instruction that can carry it, for
/// kernels with `precise`: the language's own qualifier reaches neither dot() nor the functions
/// that a precise expression calls. Dot products and products with matrices become products and
/// sums, first component first, because a driver may sum inside them in any order. Call it before
/// optimization. A malformed module is returned unchanged.
std::vector<uint32_t> forbidContraction(std::span<const uint32_t> spirv);

}  // namespace pelage::codegen
