// A list that is wrong is refused before anything of it runs, with a message that names the pass
// and the resource; a list that is right is not. No GPU: tests/passes/wrong_lists_test.cpp holds
// the runtimes to the same messages.
#include "pelage/list_check.h"

#include <gtest/gtest.h>

#include "support/errors.h"
#include "support/wrong_lists.h"

namespace pelage::test {
namespace {

class ListCheck : public testing::Test {
 protected:
  void expectRefused(const PassList& list, const DeviceLimits& limits, ErrorCode code,
                     std::initializer_list<std::string_view> words) {
    expectError(checkList(list, resources_, limits), code, words);
  }

  ResourceTable resources_;
  WrongListBuffers buffers_{resources_};
};

TEST_F(ListCheck, TakesAListInWhichNothingIsWrong) {
  const PassList list = rightList(buffers_);
  EXPECT_TRUE(checkPasses(list));
  for (const ListPart part : {ListPart::kAll, ListPart::kDispatches, ListPart::kDraws}) {
    expectOk(checkList(list, resources_, {}, part));
  }
  EXPECT_TRUE(checkList(PassList(), resources_));
}

TEST_F(ListCheck, SaysOfAnAbandonedListThatItWas) {
  HazardTracker tracker;
  PassList list = rightList(buffers_);
  tracker.resolve(list);
  expectOk(checkList(list, resources_));
  resources_.remove(buffers_.source);
  expectError(checkList(list, resources_), "was removed");
  abandon(list.run);
  expectError(checkList(list, resources_), "the list was abandoned");
}

TEST_F(ListCheck, RefusesALookupThatIsNoFunction) {
  expectError(checkList(rightList(buffers_), BufferLookup(), {}), "the lookup of buffers is empty");
}

TEST_F(ListCheck, RefusesEveryWrongListAndNamesPassAndResource) {
  for (const WrongList& wrong : wrongLists(buffers_)) {
    const Result<void> checked = checkList(spoiled(wrong, buffers_), resources_);
    ASSERT_FALSE(checked) << wrong.what;
    EXPECT_EQ(checked.error().code, wrong.code) << wrong.what;
    for (const char* word : wrong.words)
      EXPECT_NE(checked.error().message.find(word), std::string::npos)
          << wrong.what << ": '" << word << "' is not in: " << checked.error().message;
  }
}

// Buffers of the draws need not be known when the dispatches run, and the other way round.
TEST_F(ListCheck, LooksAtThePartThatIsAboutToRun) {
  PassList list = rightList(buffers_);
  bindingTo(list, 0, buffers_.source).buffer = buffers_.removed;
  EXPECT_TRUE(checkList(list, resources_, {}, ListPart::kDraws));
  EXPECT_FALSE(checkList(list, resources_, {}, ListPart::kDispatches));
  list = rightList(buffers_);
  list.passes[1].indices = buffers_.removed;
  EXPECT_FALSE(checkList(list, resources_, {}, ListPart::kDraws));
  EXPECT_TRUE(checkList(list, resources_, {}, ListPart::kDispatches));
  EXPECT_TRUE(checkPasses(list));
}

TEST_F(ListCheck, KnowsTheLimitsOfTheDevice) {
  const PassList list = rightList(buffers_);
  const uint32_t groups = list.passes[0].groups[0];
  ASSERT_GT(groups, 1u);
  EXPECT_TRUE(checkList(list, resources_, {.groups = {groups, 1, 1}}));
  expectRefused(list, {.groups = {groups - 1, 1, 1}}, ErrorCode::kUnsupported,
                {"accumulate", "axis x", "split"});
  EXPECT_TRUE(checkList(list, resources_, {.storageBytes = WrongListBuffers::kBytes}));
  expectRefused(list, {.storageBytes = WrongListBuffers::kBytes - 1}, ErrorCode::kUnsupported,
                {"accumulate", "'g_", "'groom/", "1023", "split"});
  EXPECT_TRUE(checkList(list, resources_, {.uniformBytes = 32}));
  expectRefused(list, {.uniformBytes = 31}, ErrorCode::kUnsupported,
                {"fill_vertex", "'FillConstants'", "31"});
  PassList offset = list;
  bindingTo(offset, 0, buffers_.source).offset = 8;
  bindingTo(offset, 0, buffers_.source).size = 16;
  EXPECT_TRUE(checkList(offset, resources_, {.storageAlignment = 8}));
  expectRefused(offset, {.storageAlignment = 16}, ErrorCode::kInvalidArgument,
                {"accumulate", "'g_source'", "offset 8", "'groom/source'", "16"});
}

// The engine's own buffer may start anywhere in the API's, and have another size than the table
// says.
TEST_F(ListCheck, GoesByTheBuffersThatTheExecutorHas) {
  const PassList list = rightList(buffers_);
  KnownBuffer known = {.name = "engine",
                       .size = WrongListBuffers::kBytes,
                       .usage = BufferUsage::kStorage | BufferUsage::kIndex};
  const BufferLookup find = [&](BufferId) { return std::optional(known); };
  const DeviceLimits limits = {.storageAlignment = 16};
  EXPECT_TRUE(checkList(list, find, limits));
  known.offset = 8;
  EXPECT_FALSE(checkList(list, find, limits));
  known.offset = 0;
  known.size -= 4;
  EXPECT_FALSE(checkList(list, find, limits));
}

TEST_F(ListCheck, RefusesAListOfAnotherTable) {
  PassList list = rightList(buffers_);
  list.table = resources_.id();
  EXPECT_TRUE(checkList(list, resources_));
  const ResourceTable other = resources_;
  expectError(checkList(list, other), "another scene");
}

TEST_F(ListCheck, RefusesAnImageAndATextureWithoutOne) {
  static const LayoutEntry entries[] = {
      {"g_picture", "", ResourceKind::kSampledTexture, Access::kRead, 1, 0, 0, 0},
      {"g_image", "", ResourceKind::kStorageTexture, Access::kWrite, 1, 0, 1, 0},
      {"g_buffer", "", ResourceKind::kStorageBuffer, Access::kRead, 1, 4, 2, 0}};
  static const LayoutTable table = {"Picture", "picture", 0, entries};
  static const LayoutTable* const layouts[] = {&table};
  static const Kernel kernel = {"look", Stage::kCompute, layouts, {}, {}};
  static const KernelVariant variant = {&kernel, "wind=1", {}, {64, 1, 1}, 1};
  PassList list;
  list.bindings.push_back({.buffer = buffers_.source, .size = 4});
  PassBinding& binding = list.bindings.back();
  Pass pass;
  pass.kernel = &variant;
  pass.bindingCount = 1;
  pass.groups[0] = pass.groups[1] = pass.groups[2] = 1;
  list.passes.push_back(pass);
  expectRefused(list, {}, ErrorCode::kInvalidArgument,
                {"look [wind=1]", "'g_picture'", "no texture is bound"});
  binding = {.texture = newTextureId()};
  EXPECT_TRUE(checkPasses(list));
  binding.entry = 1;
  expectRefused(list, {}, ErrorCode::kUnsupported, {"look [wind=1]", "'g_image'", "image"});
  binding.entry = 2;
  expectRefused(list, {}, ErrorCode::kInvalidArgument, {"look [wind=1]", "'g_buffer'", "texture"});
}

}  // namespace
}  // namespace pelage::test
