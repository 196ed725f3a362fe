// Pass lists and hazards, on hand-made kernel tables: no codegen, no GPU.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "passes/copy_kernels.h"
#include "pelage/ids.h"
#include "support/counted_new.h"
#include "support/errors.h"

namespace pelage::test {
namespace {

constexpr VertexAttribute kInputs[] = {{0, VertexFormat::kUint4, 0},
                                       {1, VertexFormat::kFloat2, 48}};
constexpr VertexInput kInput = {kInputs, 32, true};
constexpr Kernel kInputKernel = {"input", Stage::kVertex, kTables, {}, {}, &kInput};
constexpr KernelVariant kWithInput = {&kInputKernel, "", kDrawBindings, {0, 0, 0}, 5};

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
constexpr KernelVariant kMore = {&kMoreKernel, "", kMoreBindings, {0, 0, 0}, 4};

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
  expectError(builder.dispatch(kCopy, 64 * 65535 + 1).finish(), "65536 thread groups on axis x");
  EXPECT_TRUE(list.passes.empty());
}

TEST(PassBuilder, NamesTheResourceThatNobodyOffered) {
  PassList list;
  PassBuilder builder(list);
  expectError(
      builder.dispatch(kCopy, 1).bind("g_source", kA, 64).constants("g_block", kBlock).finish(),
      "'g_target'");
  EXPECT_TRUE(list.passes.empty());
  EXPECT_TRUE(list.bindings.empty());
}

TEST(PassBuilder, RefusesAUniformBlockThatIsTooSmall) {
  PassList list;
  PassBuilder builder(list);
  const float three[3] = {};
  expectError(builder.dispatch(kCopy, 1)
                  .bind("g_source", kA, 64)
                  .bind("g_target", kB, 64)
                  .constants("g_block", three)
                  .finish(),
              "16 bytes, got 12");
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

// As pelage-codegen makes them.
struct TestBindings {
  std::optional<std::array<float, 4>> block = {};
  BufferRange source = {};
  BufferRange target = {};
};
const LayoutTable& layoutOf(const TestBindings&) { return kTable; }
BoundResource boundTo(const TestBindings& bindings, uint8_t entry) {
  if (entry == 0) return BoundResource(bindings.block);
  return BoundResource(entry == 1 ? bindings.source : bindings.target);
}
struct MoreBindings {
  BufferRange more = {};
};
const LayoutTable& layoutOf(const MoreBindings&) { return kMoreTable; }
BoundResource boundTo(const MoreBindings& bindings, uint8_t) {
  return BoundResource(bindings.more);
}

constexpr TestBindings kBound = {.block = kBlock, .source = {kA, 64, 16}, .target = {kB, 32}};

std::string messageOf(const Result<void>& result) { return result ? "" : result.error().message; }

TEST(PassBuilder, AddsWithTypedBindingsWhatItAddsWithNames) {
  PassList named, typed;
  PassBuilder byName(named), byType(typed);
  ASSERT_TRUE(byName.dispatch(kCopy, 100)
                  .bind("g_target", kB, 32)
                  .bind("g_source", kA, 64, 16)
                  .constants("g_block", kBlock)
                  .finish());
  ASSERT_TRUE(byType.dispatch(kCopy, 100).finish(kBound));
  ASSERT_TRUE(byName.draw(kVertex, kMore, {}, 3, 1)
                  .bind("g_source", kA, 64, 16)
                  .bind("g_more", kB, 4)
                  .finish());
  const MoreBindings more{.more = {kB, 4}};
  ASSERT_TRUE(byType.draw(kVertex, kMore, {}, 3, 1).finish(more, kBound)) << "in any order";
  EXPECT_EQ(typed.constants, named.constants);
  ASSERT_EQ(typed.passes.size(), named.passes.size());
  ASSERT_EQ(typed.bindings.size(), named.bindings.size());
  for (size_t i = 0; i < named.bindings.size(); ++i) {
    const PassBinding& a = named.bindings[i];
    const PassBinding& b = typed.bindings[i];
    EXPECT_EQ(std::tie(a.set, a.entry, a.buffer, a.offset, a.size, a.access, a.stages),
              std::tie(b.set, b.entry, b.buffer, b.offset, b.size, b.access, b.stages));
  }
}

TEST(PassBuilder, NamesTheResourceThatTypedBindingsLeaveEmpty) {
  TestBindings bindings = kBound;
  bindings.target = {};
  PassList list;
  PassBuilder builder(list);
  EXPECT_EQ(messageOf(builder.dispatch(kCopy, 1).finish(bindings)),
            "pass copy needs resource 'g_target', which the TestBindings leave empty");
  bindings = kBound;
  bindings.block.reset();
  EXPECT_EQ(messageOf(builder.dispatch(kCopy, 1).finish(bindings)),
            "pass copy needs resource 'g_block', which the TestBindings leave empty");
  EXPECT_TRUE(list.passes.empty() && list.bindings.empty());
  bindings.target = {};
  EXPECT_EQ(messageOf(builder.draw(kVertex, kPixel, {}, 3, 1).finish(bindings)), "")
      << "the permutation does not use them";
}

TEST(PassBuilder, RefusesBindingsThatDoNotGoWithTheLayouts) {
  const MoreBindings more{.more = {kB, 4}};
  PassList list;
  PassBuilder builder(list);
  EXPECT_EQ(messageOf(builder.draw(kVertex, kMore, {}, 3, 1).finish(kBound)),
            "pass more needs resource 'g_more', which nobody offered: give the MoreBindings to "
            "finish(), or bind() it");
  EXPECT_EQ(messageOf(builder.dispatch(kCopy, 1).finish(kBound, more)),
            "pass copy has no layout for the bindings of layout 'More'");
  EXPECT_EQ(messageOf(builder.dispatch(kCopy, 1).finish(kBound, kBound)),
            "pass copy got the bindings of layout 'Test' twice");
  EXPECT_TRUE(list.passes.empty() && list.bindings.empty());
}

// The layout of the same name as another manifest has it: other numbers, and a texture of its own.
constexpr LayoutEntry kForeignEntries[] = {
    {"g_target", "float4", ResourceKind::kStorageBuffer, Access::kWrite, 1, 16, 0, 0},
    {"g_picture", "", ResourceKind::kSampledTexture, Access::kRead, 1, 0, 1, 0},
    {"g_source", "float4", ResourceKind::kStorageBuffer, Access::kRead, 1, 16, 2, 0},
    {"g_block", "Block", ResourceKind::kUniformBuffer, Access::kRead, 1, 16, 3, 0},
};
constexpr LayoutTable kForeignTable = {"Test", "other", 0, kForeignEntries};
constexpr const LayoutTable* kForeignTables[] = {&kForeignTable};
constexpr Kernel kForeignKernel = {"copy", Stage::kCompute, kForeignTables, {}, {}};
constexpr VariantBinding kForeignBindings[] = {
    {0, 0, Access::kWrite}, {0, 1, Access::kRead}, {0, 2, Access::kRead}, {0, 3, Access::kRead}};
constexpr KernelVariant kForeign = {&kForeignKernel, "", kForeignBindings, {64, 1, 1}, 6};

TEST(PassBuilder, FindsResourcesOfALayoutOfAnotherManifestByTheirNames) {
  const TextureId texture = newTextureId();
  EXPECT_NE(texture, newTextureId());
  const NamedResource offered[] = {{.name = "g_other"}, {.name = "g_picture", .texture = texture}};
  PassList list;
  PassBuilder builder(list);
  ASSERT_EQ(messageOf(builder.dispatch(kForeign, 100).offer(offered).finish(kBound)), "");
  ASSERT_EQ(list.bindings.size(), 4u);
  EXPECT_EQ(list.bindings[0].buffer, kB);
  EXPECT_EQ(list.bindings[1].texture, texture);
  EXPECT_EQ(list.bindings[1].buffer, BufferId::kInvalid);
  EXPECT_EQ(list.bindings[2].buffer, kA);
  EXPECT_EQ(list.bindings[2].offset, 16u);
  EXPECT_EQ(list.bindings[3].size, 16u);
  EXPECT_EQ(messageOf(builder.dispatch(kForeign, 100).finish(kBound)),
            "pass copy needs resource 'g_picture', which the TestBindings leave empty");
}

TEST(PassBuilder, RefusesALayoutOfAnotherManifestWithOtherResources) {
  static constexpr LayoutEntry entries[] = {
      {"g_source", "float2", ResourceKind::kStorageBuffer, Access::kRead, 1, 8, 0, 0}};
  static constexpr LayoutTable table = {"Test", "other", 0, entries};
  static constexpr const LayoutTable* tables[] = {&table};
  static constexpr Kernel kernel = {"copy", Stage::kCompute, tables, {}, {}};
  static constexpr VariantBinding bindings[] = {{0, 0, Access::kRead}};
  static constexpr KernelVariant variant = {&kernel, "", bindings, {64, 1, 1}, 7};
  PassList list;
  const std::string message = messageOf(PassBuilder(list).dispatch(variant, 1).finish(kBound));
  EXPECT_NE(message.find("resource 'g_source' of layout 'Test' has another kind or size"),
            std::string::npos)
      << message;
  EXPECT_TRUE(list.passes.empty() && list.bindings.empty());
}

TEST(PassBuilder, AllocatesNothingForTypedBindings) {
  PassList list;
  ASSERT_TRUE(PassBuilder(list).dispatch(kCopy, 100).finish(kBound));
  list.clear();  // keeps its memory
  const uint64_t before = g_newCount;
  const Result<void> added = PassBuilder(list).dispatch(kCopy, 100).finish(kBound);
  EXPECT_EQ(g_newCount, before);
  EXPECT_TRUE(added);
  EXPECT_EQ(list.bindings.size(), 3u);
  ASSERT_TRUE(PassBuilder(list)
                  .dispatch(kCopy, 100)
                  .bind("g_source", kA, 64)
                  .bind("g_target", kB, 64)
                  .constants("g_block", kBlock)
                  .finish());
  EXPECT_GT(g_newCount, before) << "what counts allocations works";
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

  const PassList next = copyList(tracker, kA, kB);
  ASSERT_EQ(next.barriers.size(), 1u);
  EXPECT_TRUE(next.barriers[0].beforeIndirect);
}

TEST(HazardTracker, OrdersCopiesOfTheSameBufferUnlessBothRead) {
  constexpr auto kC = BufferId{3};
  const struct {
    const char* name;
    BufferId from[2], to[2];
    BufferId buffer;  ///< of the barrier between the two copies, if there is one
    Access before, after;
  } cases[] = {
      {"reads", {kA, kA}, {kB, kC}, BufferId::kInvalid, Access::kNone, Access::kNone},
      {"read after write", {kA, kB}, {kB, kC}, kB, Access::kWrite, Access::kRead},
      {"write after read", {kA, kC}, {kB, kA}, kA, Access::kRead, Access::kWrite},
      {"write after write", {kA, kA}, {kB, kB}, kB, Access::kWrite, Access::kWrite},
      {"both in one pass", {kA, kA}, {kA, kA}, kA, Access::kWrite, Access::kReadWrite},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    PassList list;
    for (const int pass : {0, 1}) addCopy(list, c.from[pass], c.to[pass]);
    HazardTracker().resolve(list);
    ASSERT_EQ(list.barriers.size(), c.buffer == BufferId::kInvalid ? 0u : 1u);
    if (list.barriers.empty()) continue;
    const auto barriers = list.barriersOf(list.passes[1]);
    ASSERT_EQ(barriers.size(), 1u);
    EXPECT_EQ(barriers[0].buffer, c.buffer);
    EXPECT_EQ(barriers[0].before, c.before);
    EXPECT_EQ(barriers[0].after, c.after);
  }
}

TEST(HazardTracker, DoesNotRepeatABarrierForASecondReader) {
  PassList list;
  addCopy(list, kA, kB);
  addCopy(list, kB, BufferId{3});
  addCopy(list, kB, BufferId{4});
  HazardTracker().resolve(list);
  EXPECT_EQ(list.barriers.size(), 1u);
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
    // Two uploads into one buffer: one barrier.
    addUpload(list, kA, data);
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

TEST(VertexInput, KnowsTheBytesOfItsElements) {
  EXPECT_EQ(kInput.bytes(0), 0u);
  EXPECT_EQ(kInput.bytes(1), 56u);
  EXPECT_EQ(kInput.bytes(3), 2 * 32 + 56u);
}

TEST(PassBuilder, WantsVerticesForKernelsThatHaveInputs) {
  PassList list;
  const auto draw = [&](const KernelVariant& vertex, const BufferRange& vertices) {
    PassBuilder builder(list);
    return builder.draw(vertex, kPixel, {}, 3, 1)
        .bind("g_source", kA, 64)
        .vertices(vertices)
        .finish();
  };
  expectError(draw(kWithInput, {}), "vertices()");
  expectError(draw(kVertex, {kB, 64}), "no vertex inputs");
  EXPECT_TRUE(list.passes.empty() && list.bindings.empty());
  ASSERT_TRUE(draw(kWithInput, {kB, 64}));
  EXPECT_EQ(list.passes[0].vertices.buffer, kB);
}

TEST(HazardTracker, OrdersVertexReadsAgainstWrites) {
  HazardTracker tracker;
  PassList list;
  addCopy(list, kA, kB);
  const auto drawVertices = [](PassList& to) {
    PassBuilder builder(to);
    expectOk(builder.draw(kWithInput, kPixel, {}, 3, 1)
                 .bind("g_source", kA, 64)
                 .vertices({kB, 64})
                 .finish());
  };
  drawVertices(list);
  drawVertices(list);
  tracker.resolve(list);
  ASSERT_EQ(list.drawBarriers.size(), 1u);
  EXPECT_TRUE(list.drawBarriers[0].afterVertex);
  EXPECT_FALSE(list.drawBarriers[0].afterIndex);
  EXPECT_EQ(list.drawBarriers[0].before, Access::kWrite);

  // A later draw sees everything that one draw has made visible.
  PassList again;
  drawVertices(again);
  tracker.resolve(again);
  EXPECT_TRUE(again.drawBarriers.empty());

  const PassList next = copyList(tracker, kA, kB);
  ASSERT_EQ(next.barriers.size(), 1u);
  EXPECT_TRUE(next.barriers[0].beforeVertex);
}

TEST(HazardTracker, OrdersIndexReadsAgainstWrites) {
  HazardTracker tracker;
  PassList list;
  addCopy(list, kA, kB);
  addDraw(list, kA, kB);
  tracker.resolve(list);
  ASSERT_EQ(list.drawBarriers.size(), 1u);
  EXPECT_TRUE(list.drawBarriers[0].afterIndex);

  const PassList next = copyList(tracker, kA, kB);
  ASSERT_EQ(next.barriers.size(), 1u);
  EXPECT_TRUE(next.barriers[0].beforeIndex);
}

TEST(HazardTracker, ForgetsARemovedBuffer) {
  HazardTracker tracker;
  const PassList list = copyList(tracker, kA, kB);
  tracker.forget(kB);
  const PassList next = copyList(tracker, kA, kB);
  EXPECT_TRUE(next.barriers.empty());
}

TEST(HazardTracker, KnowsNothingOfTheBufferThatHadAPlaceBefore) {
  ResourceTable table;
  const BufferId a = table.add({.name = "a", .size = 16});
  const BufferId b = table.add({.name = "b", .size = 16});
  HazardTracker tracker;
  const PassList list = copyList(tracker, a, b);
  table.remove(b);
  const BufferId c = table.add({.name = "c", .size = 16});
  ASSERT_EQ(ResourceTable::indexOf(c), ResourceTable::indexOf(b));
  const PassList next = copyList(tracker, a, c);
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

TEST(ResourceTable, UsesSlotsAgainAndNoId) {
  ResourceTable table;
  const BufferId kept = table.add({.name = "kept", .size = 16});
  std::set<BufferId> ids;
  // More than a place has ids for.
  for (int round = 0; round < 10000; ++round) {
    const BufferId id = table.add({.name = "comes and goes", .size = 16});
    EXPECT_TRUE(ids.insert(id).second);
    EXPECT_EQ(table.at(ResourceTable::indexOf(id)), id);
    const uint64_t version = table.version();
    table.remove(id);
    EXPECT_NE(table.version(), version);
    EXPECT_EQ(table.find(id), nullptr);
    EXPECT_EQ(table.at(ResourceTable::indexOf(id)), BufferId::kInvalid);
  }
  EXPECT_LE(table.end(), 5u);
  EXPECT_EQ(table.count(), 1u);
  EXPECT_EQ(table.totalBytes(), 16u);
  EXPECT_NE(table.find(kept), nullptr);
  EXPECT_EQ(table.find(BufferId::kInvalid), nullptr);
}

// Runtimes that have the buffer keep it; one that makes it from now on fills it with these.
TEST(ResourceTable, HasTheInitialDataThatWereSetLast) {
  ResourceTable table;
  const auto bytesOf = [](int value) { return std::vector<std::byte>(16, std::byte(value)); };
  const BufferId other = table.add({.name = "other", .size = 16, .initial = bytesOf(3)});
  const BufferId id = table.add({.name = "state", .size = 16});
  const uint64_t version = table.version();
  for (const int value : {1, 2}) {
    table.setInitial(id, bytesOf(value));
    EXPECT_EQ(table.find(id)->initial, pelage::BufferContents(bytesOf(value)));
  }
  EXPECT_EQ(table.find(id)->name, "state");
  EXPECT_EQ(table.find(other)->initial, pelage::BufferContents(bytesOf(3)));
  EXPECT_EQ(table.version(), version) << "no buffer came or went";
}

}  // namespace
}  // namespace pelage::test
