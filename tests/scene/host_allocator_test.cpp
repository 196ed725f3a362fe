// Pass lists, buffers and objects take their arrays from the HostAllocator. A frame that is like
// the one before takes as much of it, and gives as much back.
#include "pelage/host_allocator.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "pelage/assert.h"
#include "scene/scene_lists.h"
#include "support/counted_new.h"
#include "support/delivery_scene.h"
#include "support/views.h"

namespace pelage::test {
namespace {

/// An engine's memory, which knows each array that it has given out.
class Tracker {
 public:
  HostAllocator allocator() { return {.user = this, .allocate = &allocate, .free = &free}; }

  uint64_t count() const { return count_; }
  uint64_t bytes() const { return bytes_; }
  size_t live() const { return sizes_.size(); }
  bool faultless() const { return faultless_; }
  bool refuses = false;

 private:
  static void* allocate(void* user, size_t bytes, size_t alignment) {
    Tracker& self = *static_cast<Tracker*>(user);
    if (self.refuses) return nullptr;
    void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    self.sizes_[memory] = {bytes, alignment};
    self.bytes_ += bytes;
    ++self.count_;
    self.faultless_ = self.faultless_ && bytes > 0 && (alignment & (alignment - 1)) == 0;
    return memory;
  }
  static void free(void* user, void* memory, size_t bytes, size_t alignment) {
    Tracker& self = *static_cast<Tracker*>(user);
    const auto found = self.sizes_.find(memory);
    self.faultless_ = self.faultless_ && found != self.sizes_.end() &&
                      found->second == std::pair(bytes, alignment);
    if (found != self.sizes_.end()) self.sizes_.erase(found);
    self.bytes_ -= bytes;
    std::free(memory);
  }

  std::map<void*, std::pair<size_t, size_t>> sizes_;
  uint64_t count_ = 0, bytes_ = 0;
  bool faultless_ = true;
};

class HostAllocatorTest : public testing::Test {
 protected:
  void SetUp() override { setHostAllocator(tracker_.allocator()); }
  void TearDown() override {
    EXPECT_EQ(tracker_.live(), 0u);
    EXPECT_EQ(tracker_.bytes(), 0u);
    EXPECT_TRUE(tracker_.faultless()) << "an array was freed with another size, or twice";
    setHostAllocator({});
  }

  Tracker tracker_;
};

template <class Array>
uint64_t bytesOf(const Array& array) {
  return array.capacity() * sizeof(array[0]);
}

uint64_t bytesOf(const PassList& list) {
  return bytesOf(list.passes) + bytesOf(list.bindings) + bytesOf(list.specValues) +
         bytesOf(list.barriers) + bytesOf(list.uploadBarriers) + bytesOf(list.drawBarriers) +
         bytesOf(list.uploads) + bytesOf(list.uploadData) + bytesOf(list.constants);
}

TEST_F(HostAllocatorTest, HasTheArraysOfAPassListAndNothingElseOfIt) {
  PassList list;
  EXPECT_EQ(tracker_.count(), 0u);
  list.passes.resize(3);
  list.bindings.resize(5);
  list.specValues.resize(2);
  list.barriers.resize(4);
  list.uploadBarriers.resize(1);
  list.drawBarriers.resize(2);
  const std::vector<std::byte> data(64);
  addUpload(list, BufferId{1}, data);
  list.constants.resize(256);
  EXPECT_EQ(tracker_.bytes(), bytesOf(list));
  EXPECT_EQ(tracker_.live(), 9u);
  list.clear();
  EXPECT_EQ(tracker_.live(), 9u) << "a list keeps its memory";
  const PassList copy = list;
  const PassList moved = std::move(list);
  EXPECT_EQ(tracker_.bytes(), bytesOf(moved) + bytesOf(copy));
}

TEST_F(HostAllocatorTest, HasTheContentsOfBuffersUntilTheyAreRemoved) {
  ResourceTable table;
  BufferDesc desc = {.name = "table", .size = 1 << 20, .stride = 4};
  desc.initial.resize(desc.size);
  const BufferId buffer = table.add(std::move(desc));
  EXPECT_GE(tracker_.bytes(), 1u << 20);
  const uint64_t before = tracker_.bytes();
  table.setInitial(buffer, std::vector<std::byte>(1 << 20));
  EXPECT_EQ(tracker_.bytes(), before);
  table.remove(buffer);
  EXPECT_LE(tracker_.bytes(), 4096u);
}

TEST_F(HostAllocatorTest, TakesContentsThatAreAStandardVector) {
  const std::vector<std::byte> plain(16, std::byte{3});
  ResourceTable table;
  const BufferId buffer = table.add({.name = "plain", .size = 16, .stride = 4, .initial = plain});
  const BufferDesc* desc = table.find(buffer);
  ASSERT_NE(desc, nullptr);
  EXPECT_EQ(desc->initial, BufferContents(plain));
  EXPECT_GE(tracker_.bytes(), 16u);
}

TEST_F(HostAllocatorTest, ThatHasNothingLeftEndsAsOperatorNewDoes) {
  HostArray<uint32_t> array;
  tracker_.refuses = true;
  EXPECT_THROW(array.resize(100), std::bad_alloc);
  tracker_.refuses = false;
  EXPECT_TRUE(array.empty());
}

std::string g_assertion;

TEST(SetHostAllocator, RefusesHalfAnAllocatorAndOneThatComesLate) {
  setAssertHandler(
      [](const char*, const char* message, const char*, int) { g_assertion = message; });
  Tracker tracker;
  setHostAllocator({.user = &tracker, .allocate = tracker.allocator().allocate});
  expectHas(g_assertion, "both functions, or none");
  g_assertion.clear();
  {
    const HostArray<int> array(3);
    setHostAllocator(tracker.allocator());
    expectHas(g_assertion, "before all else");
  }
  setAssertHandler(nullptr);
  const HostArray<int> array(3);
  EXPECT_EQ(tracker.count(), 0u) << "the one that was refused is not used";
}

View smallView() {
  return cameraView({.eye = {0.2f, 0.04f, 0.6f}, .target = {0.2f, 0.04f, 0}, .fov = 0.8f});
}

/// Allocations of a frame.
struct Taken {
  uint64_t arrays = 0, others = 0, liveBytes = 0;
  bool operator==(const Taken&) const = default;
};

// A frame is run as far as the scene knows. \param lists  nullptr: by a Frame
Taken runFrame(Scene& scene, const Tracker& tracker, std::vector<PassList>* lists) {
  const uint64_t arrays = tracker.count(), news = g_newCount;
  const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 32};
  if (lists == nullptr) {
    Result<Frame> frame = scene.simulate(1.0f / 60);
    EXPECT_TRUE(frame);
    EXPECT_TRUE(frame->draw(smallView(), {&light, 1}));
    EXPECT_TRUE(frame->run(executorOf([](const PassList&) {})));
  } else {
    lists->resize(std::max<size_t>(lists->size(), 2));
    std::vector<PassList> views(std::make_move_iterator(lists->begin() + 1),
                                std::make_move_iterator(lists->end()));
    views[0].clear();
    EXPECT_TRUE(scene.simulate(1.0f / 60, (*lists)[0]));
    EXPECT_TRUE(scene.draw(smallView(), {&light, 1}, {}, views));
    lists->resize(1);
    for (PassList& view : views) lists->push_back(std::move(view));
    for (PassList& list : *lists) {
      scene.finish(list);
      setDelivered(list.run);
    }
  }
  return {tracker.count() - arrays, g_newCount - news, tracker.bytes()};
}

// Hair, colliders and a skeleton, with everything that has a history, in a loop that changes only
// in what moves.
TEST_F(HostAllocatorTest, FramesThatAreAlikeTakeAsMuchAndKeepNothing) {
  constexpr int kWarmUp = 24, kFrames = 48;
  for (const Solver solver : {Solver::kExact, Solver::kClassic})
    for (const bool byLists : {false, true}) {
      Scene scene;
      DeliveryScene world(scene, solver);
      std::vector<PassList> lists;
      Taken first, most;
      for (int frame = 0; frame < kWarmUp + kFrames; ++frame) {
        const Taken taken = runFrame(scene, tracker_, byLists ? &lists : nullptr);
        if (frame == kWarmUp) first = taken;
        if (frame < kWarmUp) continue;
        EXPECT_EQ(taken.liveBytes, first.liveBytes) << "frame " << frame;
        most.arrays = std::max(most.arrays, taken.arrays);
        most.others = std::max(most.others, taken.others);
      }
      std::printf("[ FIGURE ] %s, %s: %llu arrays and %llu other allocations a frame at most\n",
                  solver == Solver::kExact ? "exact" : "classic", byLists ? "lists" : "Frame",
                  static_cast<unsigned long long>(most.arrays),
                  static_cast<unsigned long long>(most.others));
      EXPECT_LE(most.arrays, 200u);
      EXPECT_LE(most.others, 2000u);
    }
}

}  // namespace
}  // namespace pelage::test
