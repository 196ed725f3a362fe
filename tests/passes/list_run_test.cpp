// Lists run once, in their order, with barriers for all that is in them; and what is known of the
// buffers after one that did not.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "passes/copy_kernels.h"
#include "support/errors.h"

namespace pelage::test {
namespace {

class ListRunTest : public testing::Test {
 protected:
  PassList list(BufferId source = kA, BufferId target = kB) {
    return copyList(tracker_, source, target);
  }
  PassList draws() {
    PassList made;
    addDraw(made, kB);
    tracker_.resolve(made);
    return made;
  }
  static void run(const PassList& list) {
    ASSERT_TRUE(checkRun(list));
    setDelivered(list.run);
  }
  static void expectRefused(const PassList& list, const std::string& words) {
    expectError(checkRun(list), {words});
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

TEST_F(ListRunTest, BarriersForAListThatHasRunDoNotLetItRunAgain) {
  for (const bool delivered : {false, true}) {
    PassList kept = list();
    delivered ? setDelivered(kept.run) : setRecorded(kept.run);
    addDraw(kept, kB);
    tracker_.resolve(kept);
    expectRefused(kept, "has run before");
    kept.clear();
    addDraw(kept, kB);
    tracker_.resolve(kept);
    run(kept);
  }
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

TEST_F(ListRunTest, AnotherExecutorIsRefusedUntilNothingIsLeftOfWhatRan) {
  const ExecutorId here = newExecutorId(), there = newExecutorId();
  const PassList first = list();
  setRecorded(first.run, here);
  abandon(first.run);
  const PassList second = list(), third = list();
  EXPECT_TRUE(checkRun(second, there)) << "nothing has run here";
  setRecorded(second.run, there);
  setDelivered(second.run);
  expectError(checkRun(third, here), {"another runtime"});
  EXPECT_TRUE(checkRun(third, there));
  run(third);
  const PassList fourth = list();
  EXPECT_TRUE(checkRun(fourth, here)) << "nobody knows where the third one ran";
  setDelivered(fourth.run, here);
  const PassList fifth = list();
  expectError(checkRun(fifth, there), {"Scene::recover()"});
  tracker_.forgetExecutor();
  EXPECT_TRUE(checkRun(fifth, there));
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
  expectError(checkDraws(late), "after its barriers");
}

TEST_F(ListRunTest, DrawsComeBehindTheDispatchesOfTheirList) {
  PassList drawn = draws();
  expectError(checkDraws(drawn), "record() the list first");
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

/// The list's barrier for a buffer that a vertex kernel reads.
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
  PassList drawn = draws();
  const Barrier* barrier = readBarrier(drawn, kB);
  ASSERT_NE(barrier, nullptr);
  EXPECT_TRUE(barrier->beforeUpload);
  EXPECT_EQ(barrier->beforeStages & stageBit(Stage::kCompute), stageBit(Stage::kCompute))
      << "the write of the copy";
}

TEST_F(ListRunTest, WhatAnAbandonedListWasToMakeVisibleIsNotVisible) {
  run(list(kA, kB));
  PassList drawn = draws();
  ASSERT_NE(readBarrier(drawn, kB), nullptr);
  drawn = {};  // it never runs
  PassList again = draws();
  ASSERT_NE(readBarrier(again, kB), nullptr) << "nobody has waited for the copy yet";
  run(again);
  PassList third = draws();
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
}  // namespace pelage::test
