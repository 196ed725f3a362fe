// GPU time of passes by timestamp queries.
#pragma once

#include <deque>
#include <vector>

#include "device.h"
#include "pelage/headless.h"

namespace pelage::vulkan {

class Timers {
 public:
  explicit Timers(const Device& device) : device_(device) {}
  ~Timers();
  Timers(const Timers&) = delete;
  Timers& operator=(const Timers&) = delete;

  struct TimedPass {
    const char* name;
    uint32_t level;  ///< ascending from 0, with no gap
  };
  /// Timestamps around levels of passes that follow one another.
  struct Span {
    VkQueryPool pool = VK_NULL_HANDLE;  ///< null when the device has no timestamps
    uint32_t first = 0;
    std::vector<TimedPass> passes;
    bool written = false;
    uint32_t stamps() const { return passes.empty() ? 1 : passes.back().level + 2; }
  };

  /// Makes room for a span; its queries must be reset (resetSpan) outside a render pass. The index
  /// is valid until the next frame. Changes nothing on an error.
  Result<size_t> reserve(uint64_t frame, std::vector<TimedPass> passes);
  void resetSpan(size_t span, VkCommandBuffer commands);
  /// Timestamp number `index` of a span: 0 is before its first level, i after level i - 1.
  void write(size_t span, uint32_t index, VkCommandBuffer commands);

  /// Reads the results of completed frames.
  void collect(uint64_t completedFrame);
  std::vector<PassTiming> results(uint64_t frame) const;

 private:
  struct Pool {
    VkQueryPool handle = VK_NULL_HANDLE;
    uint32_t size = 0;
    uint32_t used = 0;
  };
  struct Frame {
    uint64_t number = 0;
    std::vector<Pool> pools;
    std::vector<Span> spans;
  };
  struct Finished {
    uint64_t number = 0;
    std::vector<PassTiming> timings;
  };
  void read(const Frame& frame, Finished& out) const;

  const Device& device_;
  std::deque<Frame> frames_;  // the last is the current one
  std::vector<Pool> free_;
  std::deque<Finished> finished_;
};

}  // namespace pelage::vulkan
