// The steps of a build that run compilers: each result is taken from the cache, or made in a child
// process.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "codegen/cache.h"
#include "codegen/hash.h"
#include "codegen/include_scan.h"
#include "codegen/layout_plan.h"
#include "codegen/process.h"
#include "codegen/unit.h"

namespace pelage::codegen {

struct BuildOptions;

class Compiler {
 public:
  /// \param source with baseDir and includeDirs
  /// \param scratch an empty folder, for the files of the children
  Compiler(const BuildOptions& options, FrontEndInput source, std::filesystem::path scratch,
           std::string toolHash, const Cache& cache, IncludeScanner& scanner);

  size_t threads() const { return workers_.size(); }

  ConstantsResult constants(const ManifestConstants& listed);
  /// Sets Unit::front and, if there is a module, its reflection.
  void frontEnd(std::vector<Unit>& units);
  /// Sets Unit::back and the numbers of storage buffers of all units with a reflection.
  void backEnd(std::vector<Unit>& units, const LayoutPlan& plan, const Manifest& manifest);
  /// Lets the children end. PK411: one that crashed.
  /// \param file of the messages
  void finish(const std::string& file, Diagnostics& diagnostics);

 private:
  template <class Result>
  struct Job;
  Sha256 startKey(const std::string& step) const;
  /// Returns whether a child worked for the result.
  template <class Result>
  bool run(const Job<Result>& job, Worker& worker, Result& result) const;
  void frontEnd(Unit& unit, const std::string& name, Worker& worker);

  FrontEndInput source_;
  std::filesystem::path scratch_;
  std::string toolHash_;
  std::chrono::seconds timeout_;
  const Cache& cache_;
  IncludeScanner& scanner_;
  std::deque<Worker> workers_;
};

}  // namespace pelage::codegen
