// Compiles kernels while the program runs: on demand, and in the background when their source
// changes.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pelage/kernel_code.h"
#include "pelage/result.h"

namespace viewer {

/// The source of kernels, and the results of the program's own build.
struct KernelSource {
  std::filesystem::path manifest;  ///< manifest.json of pelage's kernels
  std::filesystem::path
      headers;                  ///< folder "pelage" of the headers that the program was built with
  std::filesystem::path tool;   ///< pelage-codegen
  std::filesystem::path cache;  ///< of compiled permutations
};

/// Returns the source that this program was built from; the manifest is empty if it no longer
/// exists.
KernelSource builtKernels();

/// Tables with code of kernels that replaces the program's own, under the same ids. A runtime must
/// be made with them before all other tables.
class KernelTables {
 public:
  /// Adds the code of some permutations of a kernel. \param packed the packed code. \param bytes
  /// its unpacked size. \param ranges the permutations in the unpacked code.
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
  std::vector<std::unique_ptr<Table>> tables_;  // KernelCode points into them
  std::vector<const pelage::KernelCode*> pointers_;
  std::vector<std::string> names_;
};

struct KernelBuild {
  std::shared_ptr<const KernelTables> tables;  ///< nullptr with an error
  std::string error;                           ///< lines "file:line: error: ...", or another reason
};

/// Compiles kernels. Errors: those of codegen; resources, constants or structs that differ from the
/// program's, which must be built again for them. Cost: seconds; milliseconds for permutations in
/// the cache.
KernelBuild buildKernels(const KernelSource& source);

/// Returns a hash of the names, times and sizes of all files below a folder: it changes with a
/// file.
uint64_t stateOfFolder(const std::filesystem::path& folder);

/// Watches the source of kernels, and compiles it in the background when it changes. Threads: it
/// has one of its own; call it from the main one.
class KernelReload {
 public:
  /// Begins to watch the folder of the manifest.
  explicit KernelReload(KernelSource source);
  /// Waits for a compilation that has begun.
  ~KernelReload();
  KernelReload(const KernelReload&) = delete;
  KernelReload& operator=(const KernelReload&) = delete;

  /// Compiles now, and waits.
  KernelBuild build() const { return buildKernels(source_); }
  /// Returns the result of the last change, once; nothing if nothing has changed.
  std::optional<KernelBuild> take();

 private:
  void watch();
  const KernelSource source_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false;                 // guarded by mutex_
  std::optional<KernelBuild> built_;  // guarded by mutex_
  std::thread thread_;
};

/// The code of kernels that a program uses in place of its own, and the code that has drawn a
/// frame.
class LiveKernels {
 public:
  /// Watches a folder of kernels; without one, the source that this program was built from, unless
  /// a script plays. Errors: a folder is named, and the program's build folder does not exist.
  pelage::Result<void> open(const std::filesystem::path& folder, bool scripted);
  /// Compiles now, and waits. It comes after open() with a folder.
  KernelBuild build() const { return reload_->build(); }
  /// Returns the result of the last change, once; nothing if nothing has changed.
  std::optional<KernelBuild> take() { return reload_ ? reload_->take() : std::nullopt; }
  /// The code for Canvas::setCode(); empty for the program's own.
  pelage::KernelCodeList list() const { return code_ ? code_->list() : pelage::KernelCodeList(); }
  const std::shared_ptr<const KernelTables>& code() const { return code_; }
  /// The code that has drawn a frame.
  const std::shared_ptr<const KernelTables>& proven() const { return proven_; }
  /// Sets the code; nullptr: the program's own. \return the code until now: keep it until the
  /// runtime has the new one.
  std::shared_ptr<const KernelTables> use(std::shared_ptr<const KernelTables> code) {
    return std::exchange(code_, std::move(code));
  }
  /// A frame was drawn with the code.
  void prove() { proven_ = code_; }

 private:
  std::shared_ptr<const KernelTables> code_, proven_;
  std::unique_ptr<KernelReload> reload_;
};

}  // namespace viewer
