// Lists run once, in their order, with barriers for all that is in them; and what is known of the
// buffers after one that did not.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pelage/pass_list.h"

namespace pelage {
namespace {

constexpr LayoutEntry kEntries[] = {
    {"g_source", "float4", ResourceKind::kStorageBuffer, Access::kRead, 7, 16, 1, 0},
    {"g_target", "float4", ResourceKind::kStorageBuffer, Access::kReadWrite, 7, 16, 2, 1},
};
constexpr LayoutTable kTable = {"Test", "test", 0, kEntries};
constexpr const LayoutTable* kTables[] = {&kTable};
constexpr VariantBinding kCopyBindings[] = {{0, 0, Access::kRead}, {0, 1, Access::kWrite}};
constexpr VariantBinding kDrawBindings[] = {{0, 0, Access::kRead}};
constexpr Kernel kCopyKernel = {"copy", Stage::kCompute, kTables, {}, {}};
constexpr Kernel kVertexKernel = {"vertex", Stage::kVertex, kTables, {}, {}};
constexpr Kernel kPixelKernel = {"pixel", Stage::kPixel, kTables, {}, {}};
constexpr KernelVariant kCopy = {&kCopyKernel, "", kCopyBindings, {64, 1, 1}, 1};
constexpr KernelVariant kVertex = {&kVertexKernel, "", kDrawBindings, {0, 0, 0}, 2};
constexpr KernelVariant kPixel = {&kPixelKernel, "", kDrawBindings, {0, 0, 0}, 3};
constexpr auto kA = BufferId{1};
constexpr auto kB = BufferId{2};

void addCopy(PassList& list, BufferId source, BufferId target) {
  PassBuilder builder(list);
  builder.dispatch(kCopy, 100).bind("g_source", source, 64).bind("g_target", target, 64);
  ASSERT_TRUE(builder.finish());
}

void addDraw(PassList& list, BufferId source) {
  PassBuilder builder(list);
  builder.draw(kVertex, kPixel, {}, 3, 1).bind("g_source", source, 64);
  ASSERT_TRUE(builder.finish());
}

class ListRunTest : public testing::Test {
 protected:
  PassList list(BufferId source = kA, BufferId target = kB) {
    PassList made;
    addCopy(made, source, target);
    tracker_.resolve(made);
    return made;
  }
  static void run(const PassList& list) {
    const Result<void> ready = checkRun(list);
    ASSERT_TRUE(ready) << ready.error().message;
    setDelivered(list.run);
  }
  static void expectRefused(const PassList& list, const std::string& words) {
    const Result<void> ready = checkRun(list);
    ASSERT_FALSE(ready) << "expected: " << words;
    EXPECT_NE(ready.error().message.find(words), std::string::npos) << ready.error().message;
  }

  HazardTracker tracker_;
};

TEST_F(ListRunTest, AListRunsOnce) {
  const PassList first = list();
  const std::vector<PassList> copies(1, first);
  run(first);
  expectRefused(first, "has run before");
  expectRefused(copies[0], "has run before");
}

TEST_F(ListRunTest, AListThatIsRecordedDoesNotRunAgain) {
  const PassList first = list();
  setRecorded(first.run);
  expectRefused(first, "has run before");
  EXPECT_TRUE(checkDraws(first));
}

TEST_F(ListRunTest, ListsRunInTheOrderOfTheirBarriers) {
  const PassList first = list(), second = list();
  expectRefused(second, "finished before this one has not run");
  run(first);
  run(second);
  const PassList third = list(), fourth = list();
  setDelivered(fourth.run);  // by somebody who does not ask
  expectRefused(third, "finished after this one has run");
}

TEST_F(ListRunTest, ListsThatAreRecordedOneAfterAnotherAreInOrder) {
  const PassList first = list(), second = list();
  setRecorded(first.run);
  ASSERT_TRUE(checkRun(second));
  setRecorded(second.run);
  const PassList third = list();
  ASSERT_TRUE(checkRun(third));
  // The command buffer is not submitted.
  abandon(second.run);
  abandon(first.run);
  expectRefused(third, "finished before this one has not run");
  const PassList fourth = list();
  EXPECT_TRUE(checkRun(fourth));
  expectRefused(third, "was abandoned");
}

TEST_F(ListRunTest, WithoutBarriersNothingRuns) {
  PassList bare;
  EXPECT_TRUE(checkRun(bare)) << "there is nothing in it";
  addCopy(bare, kA, kB);
  expectRefused(bare, "has no barriers");
  PassList data;
  const std::vector<std::byte> bytes(16);
  addUpload(data, kA, bytes);
  expectRefused(data, "has no barriers");
}

TEST_F(ListRunTest, WhatIsAddedBehindTheBarriersIsRefused) {
  PassList late = list();
  addDraw(late, kB);
  expectRefused(late, "after its barriers");
  tracker_.resolve(late);
  run(late);
  addDraw(late, kB);
  ASSERT_FALSE(checkDraws(late));
  EXPECT_NE(checkDraws(late).error().message.find("after its barriers"), std::string::npos);
}

TEST_F(ListRunTest, DrawsComeBehindTheDispatchesOfTheirList) {
  PassList drawn;
  addDraw(drawn, kB);
  tracker_.resolve(drawn);
  const Result<void> early = checkDraws(drawn);
  ASSERT_FALSE(early);
  EXPECT_NE(early.error().message.find("record() the list first"), std::string::npos);
  run(drawn);
  EXPECT_TRUE(checkDraws(drawn));
}

TEST_F(ListRunTest, AListThatIsDestroyedIsAbandonedAndSoIsWhatWasToRunBehindIt) {
  PassList behind;
  {
    const PassList gone = list();
    behind = list();
  }
  expectRefused(behind, "has not run");
  const PassList next = list();
  expectRefused(behind, "was abandoned");
  run(next);
}

TEST_F(ListRunTest, ACopyKeepsAListAlive) {
  PassList copy;
  {
    const PassList first = list();
    copy = first;
  }
  const PassList second = list();
  run(copy);
  run(second);
}

TEST_F(ListRunTest, AbandonOpenLeavesWhatIsRecorded) {
  const PassList recorded = list(), open = list();
  setRecorded(recorded.run);
  tracker_.abandonOpen();
  expectRefused(open, "was abandoned");
  const PassList next = list();
  EXPECT_TRUE(checkRun(next)) << "behind the one that is recorded";
  setDelivered(recorded.run);
  run(next);
}

/// What a list needs that reads a buffer in a vertex kernel.
const Barrier* readBarrier(const PassList& list, BufferId buffer) {
  for (const Barrier& barrier : list.drawBarriers)
    if (barrier.buffer == buffer) return &barrier;
  return nullptr;
}

// A write that may or may not have happened is waited for, and so is the one before it.
TEST_F(ListRunTest, BarriersAreRightWhetherAnAbandonedListRanOrNot) {
  run(list(kA, kB));
  PassList upload;
  const std::vector<std::byte> bytes(16);
  addUpload(upload, kB, bytes);
  tracker_.resolve(upload);
  abandon(upload.run);
  PassList drawn;
  addDraw(drawn, kB);
  tracker_.resolve(drawn);
  const Barrier* barrier = readBarrier(drawn, kB);
  ASSERT_NE(barrier, nullptr);
  EXPECT_TRUE(barrier->beforeUpload);
  EXPECT_EQ(barrier->beforeStages & stageBit(Stage::kCompute), stageBit(Stage::kCompute))
      << "the write of the copy";
}

TEST_F(ListRunTest, WhatAnAbandonedListWasToMakeVisibleIsNotVisible) {
  run(list(kA, kB));
  PassList drawn;
  addDraw(drawn, kB);
  tracker_.resolve(drawn);
  ASSERT_NE(readBarrier(drawn, kB), nullptr);
  drawn = {};  // it never runs
  PassList again;
  addDraw(again, kB);
  tracker_.resolve(again);
  ASSERT_NE(readBarrier(again, kB), nullptr) << "nobody has waited for the copy yet";
  run(again);
  PassList third;
  addDraw(third, kB);
  tracker_.resolve(third);
  EXPECT_EQ(readBarrier(third, kB), nullptr);
}

TEST(ResourceTableTest, AnIdNamesOneTableWhereverItMoves) {
  ResourceTable table;
  const uint64_t id = table.id();
  EXPECT_GT(id, 0u);
  EXPECT_NE(ResourceTable().id(), id);
  EXPECT_NE(ResourceTable(table).id(), id) << "a copy may change on its own";
  ResourceTable moved = std::move(table);
  EXPECT_EQ(moved.id(), id);
  ResourceTable assigned;
  assigned = std::move(moved);
  EXPECT_EQ(assigned.id(), id);
}

TEST(ResourceTableTest, KnowsWhenABufferWasAdded) {
  ResourceTable table;
  const BufferId first = table.add({.name = "first", .size = 16, .stride = 16});
  const uint64_t version = table.version();
  EXPECT_EQ(table.versionOf(first), version);
  const BufferId second = table.add({.name = "second", .size = 16, .stride = 16});
  EXPECT_GT(table.versionOf(second), version);
  table.remove(first);
  EXPECT_EQ(table.versionOf(first), 0u);
}

}  // namespace
}  // namespace pelage
