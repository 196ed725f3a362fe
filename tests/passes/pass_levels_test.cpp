// Levels of random lists, held against all pairs of their passes.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "passes/copy_kernels.h"
#include "passes/pass_levels.h"

namespace pelage::test {
namespace {

constexpr Kernel kSumKernel = {"sum", Stage::kCompute, kTables, {}, {}, nullptr, true};
constexpr KernelVariant kSum = {&kSumKernel, "", kCopyBindings, {64, 1, 1}, 9};
constexpr uint64_t kRange = 256;

struct AccessedRange {
  BufferId buffer;
  uint64_t begin, end;
  bool write;
};

std::vector<AccessedRange> accessesOf(const PassList& list, const Pass& pass) {
  std::vector<AccessedRange> all;
  for (const PassBinding& b : list.bindingsOf(pass))
    if (b.buffer != BufferId::kInvalid)
      all.push_back({b.buffer, b.offset, b.offset + b.size, writes(b.access)});
  if (pass.indirect != BufferId::kInvalid)
    all.push_back({pass.indirect, pass.indirectOffset, pass.indirectOffset + 12, false});
  return all;
}

// The buffers that two passes must not access at the same time.
std::vector<BufferId> conflictsOf(const PassList& list, const Pass& a, const Pass& b) {
  const bool commute = a.kernel->kernel == b.kernel->kernel && a.kernel->kernel->commutes;
  std::vector<BufferId> buffers;
  for (const AccessedRange& x : accessesOf(list, a)) {
    for (const AccessedRange& y : accessesOf(list, b)) {
      if (x.buffer != y.buffer || x.begin >= y.end || y.begin >= x.end) continue;
      if ((x.write || y.write) && !(commute && x.write && y.write)) buffers.push_back(x.buffer);
    }
  }
  return buffers;
}

// Passes with ranges of few buffers; Pass::bytes is the number in the order of the calls.
PassList randomList(uint32_t seed) {
  std::mt19937 random(seed);
  const auto below = [&](uint32_t end) { return static_cast<uint32_t>(random() % end); };
  PassList list;
  const uint32_t count = 1 + below(60), buffers = 2 + below(6);
  while (list.passes.size() < count) {
    const auto range = [&](const char* name, PassBuilder& builder) {
      const uint64_t offset = below(4) * kRange, size = (1 + below(4)) * kRange;
      builder.bind(name, BufferId{1 + below(buffers)}, size, offset);
    };
    PassBuilder builder(list);
    const KernelVariant& kernel = below(3) == 0 ? kSum : kCopy;
    if (below(5) == 0)
      builder.dispatchIndirect(kernel, BufferId{1 + below(buffers)}, below(4) * kRange);
    else
      builder.dispatch(kernel, 64);
    range("g_source", builder);
    range("g_target", builder);
    expectOk(builder.constants("g_block", kBlock).bytes(list.passes.size()).finish());
  }
  if (below(2) == 0) addDraw(list, kA);
  return list;
}

std::vector<uint32_t> levelsOf(PassList& list) {
  detail::PassLevels levels;
  std::vector<uint32_t> all;
  uint32_t level = 0;
  for (const uint32_t end : levels.sort(list)) {
    EXPECT_LT(all.size(), end) << "an empty level";
    all.resize(end, level++);
  }
  return all;
}

TEST(PassLevels, HoldNoTwoPassesThatConflict) {
  for (uint32_t seed = 0; seed < 300; ++seed) {
    PassList list = randomList(seed);
    const std::vector<uint32_t> levels = levelsOf(list);
    for (size_t j = 0; j < levels.size(); ++j) {
      // A level is there because something in the one before it is needed.
      bool needed = levels[j] == 0;
      for (size_t i = 0; i < levels.size(); ++i) {
        if (i == j || conflictsOf(list, list.passes[i], list.passes[j]).empty()) continue;
        ASSERT_NE(levels[i], levels[j]) << "seed " << seed;
        ASSERT_EQ(levels[i] < levels[j], list.passes[i].bytes < list.passes[j].bytes)
            << "seed " << seed;
        needed |= levels[i] + 1 == levels[j];
      }
      EXPECT_TRUE(needed) << "seed " << seed << ", pass " << list.passes[j].bytes;
    }
  }
}

TEST(PassLevels, KeepAllPassesAndTheirOrderInALevel) {
  for (uint32_t seed = 0; seed < 100; ++seed) {
    const PassList before = randomList(seed);
    PassList list = before;
    const std::vector<uint32_t> levels = levelsOf(list);
    ASSERT_EQ(list.passes.size(), before.passes.size());
    for (size_t i = 1; i < levels.size(); ++i)
      EXPECT_TRUE(levels[i] != levels[i - 1] || list.passes[i - 1].bytes < list.passes[i].bytes);
    std::vector<bool> seen(levels.size());
    for (size_t i = 0; i < levels.size(); ++i) seen[list.passes[i].bytes] = true;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), true), std::ssize(levels));
    for (size_t i = levels.size(); i < list.passes.size(); ++i)
      EXPECT_TRUE(isDraw(list.passes[i].kind));
  }
}

// The barriers also cover memory that earlier lists have written.
TEST(PassLevels, HaveABarrierBetweenPassesThatConflict) {
  HazardTracker tracker;
  for (uint32_t seed = 0; seed < 200; ++seed) {
    PassList list = randomList(seed), sorted = list;
    const std::vector<uint32_t> levels = levelsOf(sorted);
    tracker.resolve(list);
    setDelivered(list.run);
    for (size_t j = 0; j < levels.size(); ++j) {
      ASSERT_EQ(list.passes[j].bytes, sorted.passes[j].bytes);
      EXPECT_TRUE(j == 0 || levels[j] != levels[j - 1] || list.passes[j].barrierCount == 0)
          << "a barrier inside of a level";
      for (size_t i = 0; i < j; ++i) {
        for (const BufferId buffer : conflictsOf(list, list.passes[i], list.passes[j])) {
          bool found = false;
          for (size_t between = i + 1; between <= j; ++between)
            for (const Barrier& barrier : list.barriersOf(list.passes[between]))
              found |= barrier.buffer == buffer;
          EXPECT_TRUE(found) << "seed " << seed << ", passes " << i << " and " << j;
        }
      }
    }
  }
}

TEST(PassLevels, AreOneAPassInItsOrderWhereTheyAreOff) {
  PassList list = randomList(7);
  HazardTracker tracker;
  tracker.setLevels(false);
  tracker.resolve(list);
  for (size_t i = 0; i < list.passes.size(); ++i)
    EXPECT_TRUE(isDraw(list.passes[i].kind) || list.passes[i].bytes == i);
}

TEST(PassLevels, PutObjectsThatShareNothingBesideEachOther) {
  PassList list;
  for (uint32_t object = 0; object < 12; ++object)
    for (uint32_t step = 0; step < 3; ++step)
      addCopy(list, BufferId{10 * object + step + 1}, BufferId{10 * object + step + 2});
  EXPECT_EQ(levelsOf(list).back(), 2u);
}

}  // namespace
}  // namespace pelage::test
