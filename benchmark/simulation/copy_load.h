// Copies on a device: the floor that memory sets, a load that raises the clocks, a reference.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "pelage/scene.h"

namespace bench {

/// Copies a number of float4 sets from one buffer to another, by a thread an element. Its buffers
/// are removed with it.
class CopyLoad {
 public:
  /// \param scene  whose table the device knows buffers by
  /// \param elements  float4 of a set
  CopyLoad(pelage::HeadlessDevice& device, pelage::Scene& scene, uint32_t elements, uint64_t sets);
  ~CopyLoad();
  CopyLoad(const CopyLoad&) = delete;
  CopyLoad& operator=(const CopyLoad&) = delete;

  /// Bytes that one copy reads and writes together.
  uint64_t bytes() const;
  /// Runs this many copies as passes of one list, and returns the time of each.
  pelage::Result<std::vector<pelage::PassTiming>> run(int count);

 private:
  pelage::HeadlessDevice& device_;
  pelage::Scene& scene_;
  uint32_t elements_;
  uint64_t sets_;
  pelage::BufferId from_ = pelage::BufferId::kInvalid, to_ = pelage::BufferId::kInvalid;
};

}  // namespace bench
