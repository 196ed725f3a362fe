// Kernels compiled from their source while the program runs.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pelage/kernel_code.h"

namespace viewer {

/// Where kernels come from, and what the program was built of.
struct KernelSource {
  std::filesystem::path manifest;  ///< manifest.json of pelage's kernels
  std::filesystem::path headers;   ///< folder "pelage" with those that the program was built with
  std::filesystem::path tool;      ///< pelage-codegen
  std::filesystem::path cache;     ///< of compiled permutations
};

/// The source that this program was built of; an empty manifest where it is not there (any more).
KernelSource builtKernels();

/// Code of kernels that differs from the program's own, under the ids of the latter: tables for a
/// runtime that is made with them before all others.
class KernelTables {
 public:
  /// Adds the code of some permutations of a kernel. \param ranges  into the packed bytes'
  /// contents.
  void add(const pelage::Kernel* kernel, pelage::CodeFormat format, std::string packed,
           uint32_t bytes, std::vector<pelage::KernelCode::Range> ranges);
  pelage::KernelCodeList list() const { return pointers_; }
  /// Names of the kernels, each once.
  const std::vector<std::string>& kernels() const { return names_; }

 private:
  struct Table {
    pelage::KernelCode code;
    std::string packed;
    std::vector<pelage::KernelCode::Range> ranges;
  };
  std::vector<std::unique_ptr<Table>> tables_;  // code points into them
  std::vector<const pelage::KernelCode*> pointers_;
  std::vector<std::string> names_;
};

struct KernelBuild {
  std::shared_ptr<const KernelTables> tables;  ///< nullptr with an error
  std::string error;                           ///< lines "file:line: error: ...", or why not
};

/// Compiles kernels. Errors: what codegen says of the source; resources, constants or structs that
/// are not those that the program was built with, which it has to be built again for. Cost:
/// seconds; permutations that the cache has take milliseconds.
KernelBuild buildKernels(const KernelSource& source);

}  // namespace viewer
