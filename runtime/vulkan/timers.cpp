#include "timers.h"

#include <algorithm>

namespace pelage::vulkan {
namespace {

constexpr uint32_t kQueriesPerPool = 256;
constexpr size_t kResultsKept = 8;

}  // namespace

Timers::~Timers() {
  for (const Frame& frame : frames_)
    for (const Pool& pool : frame.pools)
      device_.vk.DestroyQueryPool(device_.handle, pool.handle, device_.callbacks);
  for (const Pool& pool : free_)
    device_.vk.DestroyQueryPool(device_.handle, pool.handle, device_.callbacks);
}

Result<size_t> Timers::reserve(uint64_t frame, std::vector<TimedPass> passes) {
  if (frames_.empty() || frames_.back().number != frame) frames_.push_back({frame, {}, {}});
  Frame& now = frames_.back();
  Span span;
  span.passes = std::move(passes);
  if (device_.timestampBits > 0) {
    const uint32_t queries = span.stamps();
    if (now.pools.empty() || now.pools.back().size - now.pools.back().used < queries) {
      now.pools.reserve(now.pools.size() + 1);
      const auto fit = std::find_if(free_.begin(), free_.end(),
                                    [&](const Pool& pool) { return pool.size >= queries; });
      if (fit != free_.end()) {
        now.pools.push_back(*fit);
        free_.erase(fit);
      } else {
        auto info = tagged<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
        info.queryType = VK_QUERY_TYPE_TIMESTAMP;
        info.queryCount = std::max(queries, kQueriesPerPool);
        Pool pool{VK_NULL_HANDLE, info.queryCount, 0};
        const VkResult result =
            device_.vk.CreateQueryPool(device_.handle, &info, device_.callbacks, &pool.handle);
        if (result != VK_SUCCESS) return vulkanError(result, "timestamps of the passes");
        now.pools.push_back(pool);
      }
      now.pools.back().used = 0;
    }
    span.pool = now.pools.back().handle;
    span.first = now.pools.back().used;
    now.pools.back().used += queries;
  }
  now.spans.push_back(std::move(span));
  return now.spans.size() - 1;
}

void Timers::resetSpan(size_t index, VkCommandBuffer commands) {
  const Span& span = frames_.back().spans[index];
  if (span.pool == VK_NULL_HANDLE) return;
  device_.vk.CmdResetQueryPool(commands, span.pool, span.first, span.stamps());
}

void Timers::write(size_t index, uint32_t timestamp, VkCommandBuffer commands) {
  Span& span = frames_.back().spans[index];
  span.written = true;
  if (span.pool == VK_NULL_HANDLE) return;
  // One timestamp between two levels: passes of a level run at the same time.
  device_.vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, span.pool,
                               span.first + timestamp);
}

void Timers::read(const Frame& frame, Finished& out) const {
  const uint32_t bits = device_.timestampBits;
  const uint64_t mask = bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
  std::vector<uint64_t> stamps;
  for (const Span& span : frame.spans) {
    if (!span.written) continue;
    stamps.assign(span.stamps(), 0);
    const bool known = span.pool != VK_NULL_HANDLE &&
                       device_.vk.GetQueryPoolResults(
                           device_.handle, span.pool, span.first,
                           static_cast<uint32_t>(stamps.size()), stamps.size() * sizeof(uint64_t),
                           stamps.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT) == VK_SUCCESS;
    for (auto pass = span.passes.begin(); pass != span.passes.end();) {
      const uint32_t level = pass->level;
      const auto end = std::find_if(pass, span.passes.end(),
                                    [&](const TimedPass& other) { return other.level != level; });
      const auto ticks = static_cast<double>((stamps[level + 1] - stamps[level]) & mask);
      const double share = ticks * static_cast<double>(device_.limits().timestampPeriod) * 1e-6 /
                           static_cast<double>(end - pass);
      for (; pass != end; ++pass) out.timings.push_back({pass->name, known ? share : -1});
    }
  }
}

void Timers::collect(uint64_t completedFrame) {
  while (!frames_.empty() && frames_.front().number <= completedFrame) {
    Frame& frame = frames_.front();
    finished_.push_back({frame.number, {}});
    read(frame, finished_.back());
    if (finished_.size() > kResultsKept) finished_.pop_front();
    free_.insert(free_.end(), frame.pools.begin(), frame.pools.end());
    frames_.pop_front();
  }
}

std::vector<PassTiming> Timers::results(uint64_t frame) const {
  const auto found = std::find_if(finished_.begin(), finished_.end(),
                                  [&](const Finished& f) { return f.number == frame; });
  return found != finished_.end() ? found->timings : std::vector<PassTiming>{};
}

}  // namespace pelage::vulkan
