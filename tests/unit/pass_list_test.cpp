// Pass lists and hazards, on hand-made kernel tables: no codegen, no GPU.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>

#include "pelage/ids.h"
#include "pelage/pass_list.h"

namespace pelage {
namespace {

constexpr LayoutEntry kEntries[] = {
    {"g_block", "Block", ResourceKind::kUniformBuffer, Access::kRead, 7, 16, 0, 0},
    {"g_source", "float4", ResourceKind::kStorageBuffer, Access::kRead, 7, 16, 1, 0},
    {"g_target", "float4", ResourceKind::kStorageBuffer, Access::kReadWrite, 7, 16, 2, 1},
};
constexpr LayoutTable kTable = {"Test", "test", 0, kEntries};
constexpr const LayoutTable* kTables[] = {&kTable};

constexpr VariantBinding kCopyBindings[] = {
    {0, 0, Access::kRead}, {0, 1, Access::kRead}, {0, 2, Access::kWrite}};
constexpr VariantBinding kDrawBindings[] = {{0, 1, Access::kRead}};

constexpr Kernel kCopyKernel = {"copy", Stage::kCompute, kTables, {}, {}};
constexpr Kernel kVertexKernel = {"vertex", Stage::kVertex, kTables, {}, {}};
constexpr Kernel kPixelKernel = {"pixel", Stage::kPixel, kTables, {}, {}};
constexpr KernelVariant kCopy = {&kCopyKernel, "", {}, {}, {}, kCopyBindings, {64, 1, 1}, 1};
constexpr KernelVariant kVertex = {&kVertexKernel, "", {}, {}, {}, kDrawBindings, {0, 0, 0}, 2};
constexpr KernelVariant kPixel = {&kPixelKernel, "", {}, {}, {}, kDrawBindings, {0, 0, 0}, 3};

// A pixel kernel of another group that begins with the same layout.
constexpr LayoutEntry kMoreEntries[] = {
    {"g_more", "uint", ResourceKind::kStorageBuffer, Access::kReadWrite, 4, 4, 0, 2},
};
constexpr LayoutTable kMoreTable = {"More", "more", 1, kMoreEntries};
constexpr const LayoutTable* kMoreTables[] = {&kTable, &kMoreTable};
constexpr const LayoutTable* kOtherTables[] = {&kMoreTable};
constexpr VariantBinding kMoreBindings[] = {{0, 1, Access::kRead}, {1, 0, Access::kWrite}};
constexpr Kernel kMoreKernel = {"more", Stage::kPixel, kMoreTables, {}, {}};
constexpr Kernel kOtherKernel = {"other", Stage::kPixel, kOtherTables, {}, {}};
constexpr KernelVariant kMore = {&kMoreKernel, "", {}, {}, {}, kMoreBindings, {0, 0, 0}, 4};

constexpr auto kA = BufferId{1};
constexpr auto kB = BufferId{2};
constexpr std::array<float, 4> kBlock = {1, 2, 3, 4};

void addCopy(PassList& list, BufferId source, BufferId target, uint32_t threads = 100) {
  PassBuilder builder(list);
  const Result<void> added = builder.dispatch(kCopy, threads)
                                 .bind("g_source", source, 64)
                                 .bind("g_target", target, 64)
                                 .constants("g_block", kBlock)
                                 .finish();
  ASSERT_TRUE(added) << added.error().message;
}

void addDraw(PassList& list, BufferId source, BufferId indices = BufferId::kInvalid) {
  PassBuilder builder(list);
  const Result<void> added =
      builder.draw(kVertex, kPixel, {}, 3, 1, indices).bind("g_source", source, 64).finish();
  ASSERT_TRUE(added) << added.error().message;
}

TEST(PassBuilder, RoundsThreadsUpToGroups) {
  PassList list;
  addCopy(list, kA, kB, 65);
  ASSERT_EQ(list.passes.size(), 1u);
  EXPECT_EQ(list.passes[0].groups[0], 2u);
  EXPECT_EQ(list.passes[0].groups[1], 1u);
  EXPECT_STREQ(list.passes[0].name, "copy");
}

TEST(PassBuilder, AddsNothingForZeroThreads) {
  PassList list;
  addCopy(list, kA, kB, 0);
  EXPECT_TRUE(list.passes.empty());
  EXPECT_TRUE(list.bindings.empty());
  EXPECT_TRUE(list.constants.empty());
}

TEST(PassBuilder, RefusesMoreGroupsThanEveryDeviceAccepts) {
  PassList list;
  PassBuilder builder(list);
  const Result<void> added = builder.dispatch(kCopy, 64 * 65535 + 1).finish();
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("65536 thread groups on axis x"), std::string::npos)
      << added.error().message;
  EXPECT_TRUE(list.passes.empty());
}

TEST(PassBuilder, NamesTheResourceThatNobodyOffered) {
  PassList list;
  PassBuilder builder(list);
  const Result<void> added =
      builder.dispatch(kCopy, 1).bind("g_source", kA, 64).constants("g_block", kBlock).finish();
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("'g_target'"), std::string::npos) << added.error().message;
  EXPECT_TRUE(list.passes.empty());
  EXPECT_TRUE(list.bindings.empty());
}

TEST(PassBuilder, RefusesAUniformBlockThatIsTooSmall) {
  PassList list;
  PassBuilder builder(list);
  const float three[3] = {};
  const Result<void> added = builder.dispatch(kCopy, 1)
                                 .bind("g_source", kA, 64)
                                 .bind("g_target", kB, 64)
                                 .constants("g_block", three)
                                 .finish();
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("16 bytes, got 12"), std::string::npos);
}

TEST(PassBuilder, StoresEqualBlocksInARowOnce) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kA, kB);
  EXPECT_EQ(list.constants.size(), PassList::kConstantAlignment);
  EXPECT_EQ(list.bindingsOf(list.passes[0])[0].offset, list.bindingsOf(list.passes[1])[0].offset);
}

TEST(PassBuilder, IgnoresOffersThatThePermutationDoesNotUse) {
  PassList list;
  PassBuilder builder(list);
  ASSERT_TRUE(builder.draw(kVertex, kPixel, {}, 3, 1)
                  .bind("g_source", kA, 64)
                  .bind("g_target", kB, 64)
                  .constants("g_block", kBlock)
                  .finish());
  ASSERT_EQ(list.bindings.size(), 1u);
  EXPECT_EQ(list.bindings[0].buffer, kA);
  EXPECT_EQ(list.bindings[0].stages, stageBit(Stage::kVertex) | stageBit(Stage::kPixel));
  EXPECT_TRUE(list.constants.empty());
}

TEST(PassBuilder, BindsTheLayoutsOfTheStageThatHasMore) {
  EXPECT_TRUE(layoutsFit(kVertexKernel, kMoreKernel));
  EXPECT_TRUE(layoutsFit(kMoreKernel, kVertexKernel));
  EXPECT_FALSE(layoutsFit(kVertexKernel, kOtherKernel));
  PassList list;
  PassBuilder builder(list);
  ASSERT_TRUE(builder.draw(kVertex, kMore, {}, 3, 1)
                  .bind("g_source", kA, 64)
                  .bind("g_more", kB, 4)
                  .finish());
  const Pass& pass = list.passes[0];
  EXPECT_EQ(pass.layouts().size(), 2u);
  ASSERT_EQ(list.bindingsOf(pass).size(), 2u);
  const PassBinding shared = list.bindingsOf(pass)[0], own = list.bindingsOf(pass)[1];
  EXPECT_EQ(shared.stages, stageBit(Stage::kVertex) | stageBit(Stage::kPixel));
  EXPECT_EQ(own.set, 1u);
  EXPECT_EQ(own.buffer, kB);
  EXPECT_EQ(own.stages, stageBit(Stage::kPixel));
}

TEST(PassBuilder, PutsIndirectDrawsBehindTheDispatches) {
  PassList list;
  PassBuilder builder(list);
  const auto arguments = BufferId{5};
  ASSERT_TRUE(
      builder.drawIndirect(kVertex, kPixel, {}, arguments, 16).bind("g_source", kA, 64).finish());
  addCopy(list, kA, kB);
  ASSERT_EQ(list.passes.size(), 2u);
  EXPECT_EQ(list.passes[0].kind, PassKind::kDispatch);
  EXPECT_EQ(list.passes[1].kind, PassKind::kDrawIndirect);
  EXPECT_EQ(list.passes[1].indirect, arguments);
  EXPECT_EQ(list.passes[1].indirectOffset, 16u);
}

TEST(HazardTracker, OrdersTheArgumentsOfAnIndirectDrawWithTheOtherReadsOfTheDraws) {
  HazardTracker tracker;
  PassList list;
  addCopy(list, kA, kB);
  addDraw(list, kB);
  PassBuilder builder(list);
  ASSERT_TRUE(builder.drawIndirect(kVertex, kPixel, {}, kB).bind("g_source", kA, 64).finish());
  tracker.resolve(list);
  EXPECT_EQ(list.barriers.size(), 0u);
  ASSERT_EQ(list.drawBarriers.size(), 1u);  // one for both draws
  EXPECT_EQ(list.drawBarriers[0].buffer, kB);
  EXPECT_TRUE(list.drawBarriers[0].afterIndirect);
  EXPECT_EQ(list.drawBarriers[0].afterStages, stageBit(Stage::kVertex) | stageBit(Stage::kPixel));

  PassList next;
  addCopy(next, kA, kB);
  tracker.resolve(next);
  ASSERT_EQ(next.barriers.size(), 1u);
  EXPECT_TRUE(next.barriers[0].beforeIndirect);
}

TEST(HazardTracker, LeavesIndependentPassesAlone) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kA, BufferId{3});
  HazardTracker().resolve(list);
  EXPECT_TRUE(list.barriers.empty());
}

TEST(HazardTracker, OrdersAReadAfterAWrite) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kB, BufferId{3});
  HazardTracker().resolve(list);
  EXPECT_EQ(list.barriersOf(list.passes[0]).size(), 0u);
  ASSERT_EQ(list.barriersOf(list.passes[1]).size(), 1u);
  const Barrier barrier = list.barriersOf(list.passes[1])[0];
  EXPECT_EQ(barrier.buffer, kB);
  EXPECT_EQ(barrier.before, Access::kWrite);
  EXPECT_EQ(barrier.after, Access::kRead);
}

TEST(HazardTracker, OrdersAWriteAfterARead) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, BufferId{3}, kA);
  HazardTracker().resolve(list);
  ASSERT_EQ(list.barriersOf(list.passes[1]).size(), 1u);
  EXPECT_EQ(list.barriersOf(list.passes[1])[0].buffer, kA);
  EXPECT_EQ(list.barriersOf(list.passes[1])[0].before, Access::kRead);
  EXPECT_EQ(list.barriersOf(list.passes[1])[0].after, Access::kWrite);
}

TEST(HazardTracker, OrdersAWriteAfterAWrite) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kA, kB);
  HazardTracker().resolve(list);
  ASSERT_EQ(list.barriers.size(), 1u);
  EXPECT_EQ(list.barriers[0].before, Access::kWrite);
  EXPECT_EQ(list.barriers[0].after, Access::kWrite);
}

TEST(HazardTracker, DoesNotRepeatABarrierForASecondReader) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kB, BufferId{3});
  addCopy(list, kB, BufferId{4});
  HazardTracker().resolve(list);
  EXPECT_EQ(list.barriers.size(), 1u);
}

TEST(HazardTracker, TreatsABufferThatIsReadAndWrittenByOnePassAsBoth) {
  PassList list;
  addCopy(list, kA, kA);
  addCopy(list, kA, kA);
  HazardTracker().resolve(list);
  ASSERT_EQ(list.barriers.size(), 1u);
  EXPECT_EQ(list.barriers[0].after, Access::kReadWrite);
}

TEST(HazardTracker, MakesAWriteVisibleToEachStageThatReadsIt) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kB, BufferId{3});
  addDraw(list, kB);
  HazardTracker().resolve(list);
  EXPECT_EQ(list.barriers.size(), 1u);
  ASSERT_EQ(list.drawBarriers.size(), 1u);
  EXPECT_EQ(list.drawBarriers[0].afterStages, stageBit(Stage::kVertex) | stageBit(Stage::kPixel));
  EXPECT_EQ(list.drawBarriers[0].beforeStages, stageBit(Stage::kCompute));
}

TEST(HazardTracker, OrdersUploadsAgainstTheLastFrameAndTheNextPass) {
  HazardTracker tracker;
  PassList list;
  const std::array<std::byte, 16> data = {};
  for (int frame = 0; frame < 2; ++frame) {
    list.clear();
    addUpload(list, kA, data);
    addCopy(list, kA, kB);
    tracker.resolve(list);
    ASSERT_EQ(list.uploadBarriers.size(), frame == 0 ? 0u : 1u);
    if (frame == 1) {
      EXPECT_EQ(list.uploadBarriers[0].before, Access::kWrite | Access::kRead);
      EXPECT_TRUE(list.uploadBarriers[0].afterUpload);
    }
    const auto barriers = list.barriersOf(list.passes[0]);
    ASSERT_EQ(barriers.size(), frame == 0 ? 1u : 2u);  // the second frame also writes kB again
    EXPECT_EQ(barriers[0].buffer, kA);
    EXPECT_TRUE(barriers[0].beforeUpload);
  }
}

TEST(HazardTracker, OrdersIndexReadsAgainstWrites) {
  HazardTracker tracker;
  PassList list;
  addCopy(list, kA, kB);
  addDraw(list, kA, kB);
  tracker.resolve(list);
  ASSERT_EQ(list.drawBarriers.size(), 1u);
  EXPECT_TRUE(list.drawBarriers[0].afterIndex);

  PassList next;
  addCopy(next, kA, kB);
  tracker.resolve(next);
  ASSERT_EQ(next.barriers.size(), 1u);
  EXPECT_TRUE(next.barriers[0].beforeIndex);
}

TEST(HazardTracker, ForgetsARemovedBuffer) {
  HazardTracker tracker;
  PassList list;
  addCopy(list, kA, kB);
  tracker.resolve(list);
  tracker.forget(kB);
  PassList next;
  addCopy(next, kA, kB);
  tracker.resolve(next);
  EXPECT_TRUE(next.barriers.empty());
}

TEST(HazardTracker, KnowsNothingOfTheBufferThatHadAPlaceBefore) {
  ResourceTable table;
  const BufferId a = table.add({.name = "a", .size = 16});
  const BufferId b = table.add({.name = "b", .size = 16});
  HazardTracker tracker;
  PassList list;
  addCopy(list, a, b);
  tracker.resolve(list);
  table.remove(b);
  const BufferId c = table.add({.name = "c", .size = 16});
  ASSERT_EQ(ResourceTable::placeOf(c), ResourceTable::placeOf(b));
  PassList next;
  addCopy(next, a, c);
  tracker.resolve(next);
  EXPECT_TRUE(next.barriers.empty());
}

TEST(Slots, GiveNoIdTwice) {
  detail::Slots<HairId, int> slots;
  const HairId kept = slots.add(std::make_unique<int>(1));
  std::set<HairId> ids = {kept, HairId::kInvalid};
  // More than a place has ids for.
  for (int round = 0; round < 70000; ++round) {
    const HairId id = slots.add(std::make_unique<int>(2));
    ASSERT_TRUE(ids.insert(id).second) << "round " << round;
    ASSERT_NE(slots.find(id), nullptr);
    slots.remove(id);
    ASSERT_EQ(slots.find(id), nullptr);
  }
  EXPECT_EQ(slots.size(), 3u);
  EXPECT_EQ(*slots.find(kept), 1);
  EXPECT_EQ(slots.find(HairId::kInvalid), nullptr);
}

TEST(ResourceTable, UsesPlacesAgain) {
  ResourceTable table;
  const BufferId kept = table.add({.name = "kept", .size = 16});
  std::set<BufferId> ids;
  // More than a place has ids for.
  for (int round = 0; round < 10000; ++round) {
    const BufferId id = table.add({.name = "comes and goes", .size = 16});
    EXPECT_TRUE(ids.insert(id).second);
    EXPECT_EQ(table.at(ResourceTable::placeOf(id)), id);
    table.remove(id);
    EXPECT_EQ(table.at(ResourceTable::placeOf(id)), BufferId::kInvalid);
  }
  EXPECT_LE(table.end(), 5u);
  EXPECT_NE(table.find(kept), nullptr);
  EXPECT_EQ(table.find(BufferId::kInvalid), nullptr);
}

TEST(ResourceTable, NeverReusesAnId) {
  ResourceTable table;
  const BufferId first = table.add({.name = "first", .size = 16});
  const uint64_t version = table.version();
  table.remove(first);
  EXPECT_EQ(table.find(first), nullptr);
  EXPECT_NE(table.version(), version);
  const BufferId second = table.add({.name = "second", .size = 32});
  EXPECT_NE(first, second);
  EXPECT_EQ(table.find(first), nullptr);
  EXPECT_EQ(table.count(), 1u);
  EXPECT_EQ(table.totalBytes(), 32u);
}

}  // namespace
}  // namespace pelage
