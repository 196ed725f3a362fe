// Pass lists, buffers and objects take their arrays from the HostAllocator. A frame that is like
// those before it allocates nothing.
#include "pelage/host_allocator.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "pelage/assert.h"
#include "scene/scene_lists.h"
#include "support/steady_scene.h"

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

/// A frame's work by lists that its caller keeps.
class KeptLists {
 public:
  void run(Scene& scene, const SteadyScene& steady, Transparency method) {
    simulation_.clear();
    EXPECT_TRUE(scene.simulate(1.0f / 60, simulation_));
    EXPECT_TRUE(scene.interpolate(0.5f, simulation_));
    depth_.clear();
    if (!views_.empty()) views_[0].clear();
    EXPECT_TRUE(scene.draw(steady.view(), steady.lights(), {.method = method}, views_));
    EXPECT_TRUE(scene.drawDepth(steady.view(), {.color = HairDepthColor::kMotion}, depth_));
    finish(scene, simulation_);
    for (PassList& list : views_) finish(scene, list);
    finish(scene, depth_);
  }

 private:
  static void finish(Scene& scene, PassList& list) {
    scene.finish(list);
    EXPECT_TRUE(checkRun(list));
    setDelivered(list.run);
  }
  PassList simulation_, depth_;
  std::vector<PassList> views_;
};

constexpr Transparency kMethods[] = {Transparency::kTiles,     Transparency::kWindowed,
                                     Transparency::kHybrid4,   Transparency::kShortCut,
                                     Transparency::kAlphaTest, Transparency::kStochastic};

class SteadyFrames : public testing::TestWithParam<uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Objects, SteadyFrames, testing::Values(1, 100));

TEST_P(SteadyFrames, AllocateNothingByLists) {
  for (const Transparency method : kMethods) {
    Scene scene;
    SteadyScene steady(scene, GetParam());
    KeptLists lists;
    const uint64_t taken = allocationsOf([&] {
      steady.setInputs();
      lists.run(scene, steady, method);
    });
    EXPECT_EQ(taken, 0u) << "method " << static_cast<int>(method);
  }
}

TEST_P(SteadyFrames, AllocateNothingByAFrame) {
  Scene scene;
  SteadyScene steady(scene, GetParam());
  size_t passes = 0;
  const FrameExecutor executor = executorOf([&](const PassList& list) {
    EXPECT_TRUE(checkRun(list));
    passes += list.passes.size();
  });
  const uint64_t taken = allocationsOf([&] {
    steady.setInputs();
    Frame frame = steady.makeFrame(kMethods);
    EXPECT_TRUE(frame.run(executor));
  });
  EXPECT_GT(passes, 0u);
  EXPECT_EQ(taken, 0u);
}

// Lists and frames come and go, and are lost.
TEST_F(HostAllocatorTest, KeepsAsMuchInEachFrameThatIsAlike) {
  Scene scene;
  SteadyScene steady(scene, 7);
  uint64_t kept = 0;
  for (int frame = 0; frame < SteadyScene::kWarmUp + SteadyScene::kFrames; ++frame) {
    steady.setInputs();
    {
      Frame made = steady.makeFrame(kMethods);
      if (frame % 3 > 0) {
        EXPECT_TRUE(made.run(executorOf([](const PassList&) {})));
      }
    }
    if (frame == SteadyScene::kWarmUp) kept = tracker_.bytes();
    if (frame < SteadyScene::kWarmUp) continue;
    EXPECT_EQ(tracker_.bytes(), kept) << "frame " << frame;
  }
}

}  // namespace
}  // namespace pelage::test
