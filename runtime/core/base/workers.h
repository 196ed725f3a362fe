// Threads that share the items of a loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace pelage::detail {

/// Threads that wait for loops to run. Threads: one at a time.
class Workers {
 public:
  /// \param threads  that run a loop, with the one that calls run(), >= 1. Where the system has no
  /// more threads there are fewer.
  explicit Workers(uint32_t threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  uint32_t count() const;  ///< threads that run a loop
  /// Calls code(item, worker) once for each item below `items`, in any order, with worker < count()
  /// of the thread that calls; returns when all calls have. An exception of the code ends the loop
  /// early and is thrown here, one of them if there are several.
  void run(size_t items, const std::function<void(size_t item, uint32_t worker)>& code);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pelage::detail
