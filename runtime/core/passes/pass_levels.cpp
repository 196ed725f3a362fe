#include "passes/pass_levels.h"

#include <algorithm>

#include "pelage/ids.h"

namespace pelage::detail {

namespace {

// The arguments of an indirect dispatch: three uint32.
constexpr uint64_t kIndirectBytes = 12;

template <class Function>
void forEachAccess(const PassList& list, const Pass& pass, const Function& function) {
  for (const PassBinding& binding : list.bindingsOf(pass)) {
    if (binding.buffer != BufferId::kInvalid && binding.size > 0)
      function(binding.buffer, binding.offset, binding.offset + binding.size,
               writes(binding.access));
  }
  if (pass.indirect != BufferId::kInvalid)
    function(pass.indirect, pass.indirectOffset, pass.indirectOffset + kIndirectBytes, false);
}

}  // namespace

// The ranges from `begin` to `end`, which become boundaries of ranges.
inline std::span<PassLevels::Range> PassLevels::rangesOf(BufferId buffer, uint64_t begin,
                                                         uint64_t end) {
  const uint32_t index = ResourceTable::indexOf(buffer);
  if (index >= buffers_.size()) buffers_.resize(size_t{index} + 1);
  Ranges& ranges = buffers_[index];
  if (ranges.list != lists_) {
    ranges.list = lists_;
    ranges.only = {.begin = begin, .end = end};
    ranges.sorted.clear();
  }
  const bool whole = ranges.only.begin == begin && ranges.only.end == end;
  if (ranges.sorted.empty() && whole) return {&ranges.only, 1};
  return split(ranges, begin, end);
}

std::span<PassLevels::Range> PassLevels::split(Ranges& ranges, uint64_t begin, uint64_t end) {
  HostArray<Range>& sorted = ranges.sorted;
  if (sorted.empty()) sorted.push_back(ranges.only);
  auto at = std::partition_point(sorted.begin(), sorted.end(),
                                 [&](const Range& range) { return range.end <= begin; });
  if (at != sorted.end() && at->begin < begin) {
    Range left = *at;
    left.end = at->begin = begin;
    at = sorted.insert(at, left) + 1;
  }
  const std::ptrdiff_t first = at - sorted.begin();
  for (uint64_t from = begin; from < end; from = (at++)->end) {
    if (at == sorted.end() || at->begin > from) {
      const uint64_t to = at == sorted.end() ? end : std::min(end, at->begin);
      at = sorted.insert(at, {.begin = from, .end = to});
    } else if (at->end > end) {
      Range left = *at;
      left.end = at->begin = end;
      at = sorted.insert(at, left);
    }
  }
  return {sorted.data() + first, static_cast<size_t>(at - sorted.begin() - first)};
}

uint32_t PassLevels::levelOf(const PassList& list, const Pass& pass) {
  const Kernel* const commuting = pass.kernel->kernel->commutes ? pass.kernel->kernel : nullptr;
  uint32_t level = 0;
  forEachAccess(list, pass, [&](BufferId buffer, uint64_t begin, uint64_t end, bool write) {
    for (const Range& range : rangesOf(buffer, begin, end)) {
      if (write && commuting != nullptr && range.commuting == commuting)
        level = std::max(level, range.firstCommuting);
      else
        level = std::max({level, range.written, write ? range.read : 0});
    }
  });
  forEachAccess(list, pass, [&](BufferId buffer, uint64_t begin, uint64_t end, bool write) {
    for (Range& range : rangesOf(buffer, begin, end)) {
      if (!write) {
        range.read = std::max(range.read, level + 1);
        range.commuting = nullptr;
        continue;
      }
      if (range.commuting != commuting) range.firstCommuting = std::max(range.written, range.read);
      range.commuting = commuting;
      range.written = std::max(range.written, level + 1);
    }
  });
  return level;
}

std::span<const uint32_t> PassLevels::sort(PassList& list) {
  ++lists_;
  levels_.clear();
  ends_.clear();
  for (const Pass& pass : list.passes) {
    if (isDraw(pass.kind)) break;
    const uint32_t level = levelOf(list, pass);
    levels_.push_back(level);
    if (level >= ends_.size()) ends_.resize(size_t{level} + 1);
    ++ends_[level];
  }
  next_.clear();
  uint32_t count = 0;
  for (uint32_t& end : ends_) {
    next_.push_back(count);
    end = count += end;
  }
  sorted_.resize(count);
  for (size_t i = 0; i < levels_.size(); ++i) sorted_[next_[levels_[i]]++] = list.passes[i];
  std::copy(sorted_.begin(), sorted_.end(), list.passes.begin());
  return ends_;
}

}  // namespace pelage::detail
