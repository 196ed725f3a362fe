// Levels of a list: passes that need nothing of each other, so that one set of barriers is enough
// for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pelage/pass_list.h"

namespace pelage::detail {

/// Sorts the dispatches of lists by level: one more than the highest level of the earlier passes
/// that a pass conflicts with, by read after write, write after read and write after write, of
/// ranges of buffers. Keeps its memory from list to list.
class PassLevels {
 public:
  /// Reorders the dispatches of a list, which come before its draws; those of one level keep their
  /// order. \return [level] one behind the last pass of the level; valid until the next call.
  std::span<const uint32_t> sort(PassList& list);

 private:
  /// A part of a buffer, all bytes of which were accessed alike. A level of 0: not at all.
  struct Range {
    uint64_t begin = 0, end = 0;
    uint32_t read = 0, written = 0;  ///< one more than the highest level that did
    /// The kernel whose writes commute, if no other pass accessed the range after them, and the
    /// lowest level at which another pass of it may follow.
    const Kernel* commuting = nullptr;
    uint32_t firstCommuting = 0;
  };
  struct Ranges {
    uint64_t list = 0;        ///< the number of the list that they are of
    Range only;               ///< while the buffer is bound in one way, as nearly all are
    HostArray<Range> sorted;  ///< after that; by offset, they do not overlap
  };
  std::span<Range> rangesOf(BufferId buffer, uint64_t begin, uint64_t end);
  static std::span<Range> split(Ranges& ranges, uint64_t begin, uint64_t end);
  uint32_t levelOf(const PassList& list, const Pass& pass);

  uint64_t lists_ = 0;
  HostArray<Ranges> buffers_;   ///< [table index]
  HostArray<uint32_t> levels_;  ///< [dispatch]
  HostArray<uint32_t> ends_;    ///< [level]
  HostArray<uint32_t> next_;    ///< [level] where its next pass goes
  HostArray<Pass> sorted_;
};

}  // namespace pelage::detail
