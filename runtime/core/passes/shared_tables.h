// Tables that never change: objects with the same contents have one buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pelage/pass_list.h"

namespace pelage::detail {

/// Finds the buffer that has some contents already. Shared buffers go in collect() alone: what an
/// object or a frame has no use for any more may be in use by another one.
class SharedTables {
 public:
  /// The buffer with these contents, which is made where there is none.
  /// \param what  kind of the table: only those of one kind are shared
  BufferId add(ResourceTable& resources, const std::string& what, BufferDesc desc);
  bool contains(BufferId buffer) const;
  /// Call where something that had one of them has let go of it.
  void noteRelease() { released_ = true; }
  /// Removes those that are not in use, if any was let go of.
  void collect(ResourceTable& resources, HazardTracker& hazards,
               const std::function<bool(BufferId)>& isUsed);

 private:
  struct Table {
    std::string what;
    uint64_t hash = 0;  ///< of the contents
    BufferId buffer = BufferId::kInvalid;
  };
  std::vector<Table> tables_;
  bool released_ = false;
};

}  // namespace pelage::detail
