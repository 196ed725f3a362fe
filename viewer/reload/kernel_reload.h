// Watches the source of kernels, and compiles it in the background when it changes.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "reload/kernel_build.h"

namespace viewer {

/// Times and sizes of the files of a folder, and of those below it, as one number: another one when
/// a file has changed.
uint64_t stateOfFolder(const std::filesystem::path& folder);

/// Threads: its own one; everything else from the main one.
class KernelReload {
 public:
  /// Watches the folder of a manifest.
  explicit KernelReload(KernelSource source);
  /// Waits for a compilation that is on its way.
  ~KernelReload();
  KernelReload(const KernelReload&) = delete;
  KernelReload& operator=(const KernelReload&) = delete;

  /// Compiles now, and waits.
  KernelBuild build() const { return buildKernels(source_); }
  /// What came of the last change, once; nothing where there was none.
  std::optional<KernelBuild> take();

 private:
  void watch();
  const KernelSource source_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false;                 // with the mutex
  std::optional<KernelBuild> built_;  // likewise
  std::thread thread_;
};

}  // namespace viewer
