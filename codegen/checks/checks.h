// Checks against what the HLSL front end accepts and turns into wrong numbers, invalid output or a
// crash. README.md in this folder has the table: number, trap, how it is found, what to write
// instead.
//
// PK1xx are found in the preprocessed text before the front end sees it, PK2xx in what the front
// end and the back ends made of it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/diagnostics.h"
#include "pelage/layout.h"

namespace pelage::codegen {

/// One permutation of one kernel, and what has been made of it so far.
struct CheckInput {
  std::string_view kernelName;
  Stage stage = Stage::kCompute;
  std::string entry;
  /// Name of the kernel's file as messages should show it; `preprocessed` starts in it.
  std::string file;
  /// The whole kernel after the preprocessor, with `#line N "file"` where the file or line jumps.
  std::string preprocessed;
  /// As the front end wrote it: not optimised, with OpLine and names.
  std::span<const uint32_t> rawSpirv = {};
  /// Empty when a step before it failed.
  std::span<const uint32_t> optimisedSpirv = {};
  /// All that the front end and its SPIR-V builder said, one message a line.
  std::string frontEndLog;
  std::string glsl;  ///< GLSL 450; empty when a step before it failed
  std::string essl;  ///< ESSL 320; empty when a step before it failed
  /// The kernel needs only desktop limits: no GLES 3.2, groups of 1024 threads, 32 KB groupshared.
  bool desktopTier = false;
  /// The kernel promises the same bits on every API: nothing in optimisedSpirv may be contracted.
  bool precise = false;
};

/// Before compilation. Reads kernelName, stage, entry, file and preprocessed. After an error do not
/// hand the text to the front end: some of what is refused here crashes it.
void runSourceChecks(const CheckInput& input, Diagnostics& diagnostics);

/// After compilation; also when validation, optimisation or cross-compilation failed, because these
/// checks then say why, with a line. Reads everything but `preprocessed`; what is empty is skipped,
/// so it may be called after the front end and again after the back end.
void runModuleChecks(const CheckInput& input, Diagnostics& diagnostics);

/// The module with NoContraction on every floating-point instruction that can carry it, for kernels
/// with `precise`: the language's own qualifier reaches neither dot() nor the functions that a
/// precise expression calls. Dot products and products with matrices become products and sums,
/// first component first, because a driver may sum inside them as it likes. To be done before
/// optimisation. A malformed module comes back as it is.
std::vector<uint32_t> forbidContraction(std::span<const uint32_t> spirv);

}  // namespace pelage::codegen
