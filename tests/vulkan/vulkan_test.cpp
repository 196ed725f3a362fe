// The Vulkan runtime where it differs from those of the other APIs (tests/passes): on the headless
// device, under validation with synchronisation validation.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "runtime_test/spirv.h"
#include "support/errors.h"
#include "support/own_device.h"
#include "support/test_code.h"

namespace pelage::test {
namespace {

constexpr uint32_t kThreads = 1000;  // no multiple of the group size
constexpr uint64_t kBytes = kThreads * sizeof(uint32_t);

class VulkanHeadless : public testing::Test, protected OwnDevice {
 protected:
  // Every test has a device of its own. One more stays open, so that the loader does not unload the
  // driver in between: NVIDIA's 580 refused to be loaded again after some thirty times.
  static void SetUpTestSuite() {
    if (Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan({}); made)
      openDriver() = *std::move(made);
  }
  static void TearDownTestSuite() { openDriver().reset(); }
  static std::unique_ptr<HeadlessDevice>& openDriver() {
    static std::unique_ptr<HeadlessDevice> device;
    return device;
  }

  void SetUp() override { open(Api::kVulkan); }
  void TearDown() override { expectNoMessages(); }
};

TEST_F(VulkanHeadless, LetsReadersFinishBeforeABufferIsWritten) {
  // Nothing is written before it is read here: only the wait matters.
  std::vector<uint32_t> a = ramp(1, kThreads);
  std::vector<uint32_t> b = ramp(2, kThreads);
  const BufferId bufferA = add("a", a);
  const BufferId bufferB = add("b", b);
  const BufferId bufferC = add("c", ramp(3, kThreads));
  update();
  PassList list;
  addAccumulate(list, bufferA, bufferB, kThreads, 2, 3);
  addAccumulate(list, bufferC, bufferA, kThreads, 5, 7);
  accumulateOnHost(a, b, 2, 3);
  accumulateOnHost(ramp(3, kThreads), a, 5, 7);
  execute(list);
  ASSERT_EQ(list.barriers.size(), 1u);
  EXPECT_FALSE(writes(list.barriers[0].before));
  EXPECT_EQ(read(bufferA), a);
  EXPECT_EQ(read(bufferB), b);
}

TEST_F(VulkanHeadless, SynchronisationValidationComplainsWhenTheBarriersAreTakenAway) {
  const BufferId a = add("a", ramp(1, kThreads));
  const BufferId b = add("b", ramp(2, kThreads));
  update();
  PassList list;
  addAccumulate(list, a, b, kThreads, 2, 3);
  addAccumulate(list, b, a, kThreads, 2, 3);
  tracker_.resolve(list);
  ASSERT_GT(list.barriers.size(), 0u);
  for (Pass& pass : list.passes) pass.barrierCount = 0;
  testing::internal::CaptureStderr();
  const Result<void> done = device_->execute(list);
  const std::string messages = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(done) << done.error().message;
  expectedMessages_ = device_->messageCount();
  EXPECT_GT(expectedMessages_, 0u);
  EXPECT_NE(messages.find("SYNC-HAZARD"), std::string::npos) << messages;
}

TEST_F(VulkanHeadless, ReadsOfABufferThatIsDeclaredForWritingNeedNoBarrier) {
  const BufferId shared = add("shared", ramp(11, kThreads));
  const BufferId first = addWords("first", kThreads);
  const BufferId second = addWords("second", kThreads);
  update();
  PassList list;
  for (const BufferId out : {first, second}) {
    ASSERT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::copyTargetVariant(), kThreads)
                    .bind("g_target", shared, kBytes)
                    .bind("g_arguments", out, kBytes)
                    .constants("AccumulateConstants", AccumulateConstants{kThreads, 0, 0, 0})
                    .finish());
  }
  tracker_.resolve(list);
  EXPECT_EQ(list.barriers.size(), 0u);
  execute(list);
  EXPECT_EQ(read(first), ramp(11, kThreads));
  EXPECT_EQ(read(second), ramp(11, kThreads));
}

TEST_F(VulkanHeadless, KeepsConstantsOfPassesApart) {
  std::vector<BufferId> targets;
  const BufferId source = add("source", ramp(1, kThreads));
  constexpr uint32_t kPasses = 300;  // more constants than one chunk of them holds
  for (uint32_t i = 0; i < kPasses; ++i) targets.push_back(addWords("target", kThreads));
  update();
  PassList list;
  for (uint32_t i = 0; i < kPasses; ++i)
    addAccumulate(list, source, targets[i], kThreads, i, 1000 * i);
  execute(list);
  for (uint32_t i = 0; i < kPasses; ++i) {
    std::vector<uint32_t> expected(kThreads, 0);
    accumulateOnHost(ramp(1, kThreads), expected, i, 1000 * i);
    ASSERT_EQ(read(targets[i]), expected) << "pass " << i;
  }
}

TEST_F(VulkanHeadless, RunsAPassThatUsesNoConstantsOfItsLayout) {
  const BufferId marked = add("marked", ramp(100, kThreads));
  update();
  PassList list;
  ASSERT_TRUE(PassBuilder(list)
                  .dispatch(runtime_test::markVariant(), 1)
                  .bind("g_arguments", marked, kBytes)
                  .finish());
  EXPECT_TRUE(list.constants.empty());
  execute(list);
  std::vector<uint32_t> expected = ramp(100, kThreads);
  expected[0] = 42;
  EXPECT_EQ(read(marked), expected);
}

// Pictures of several sizes in turn need no pipelines of their own, which take longer than drawing.
TEST_F(VulkanHeadless, PipelinesStayWhenATargetHasAnotherSizeOrOtherSamples) {
  device_ = valueOf(createDeviceOfPelage({.api = Api::kVulkan, .validation = true}));
  static std::vector<KernelCode> code;  // of the test, which spoils it
  static std::vector<const KernelCode*> tables;
  for (const KernelCode* table : runtime_test::allCode()) code.push_back(*table);
  for (const KernelCode& table : code) tables.push_back(&table);
  device_->addCode(tables);
  const BufferId corners = add("corners", kEverything);
  update();
  PassList list;
  addFill(list, {}, corners, 3, {.color = {0.5f, 0.25f, 1, 1}, .offset = {}});
  const auto drawAll = [&] {
    for (const uint32_t samples : {1u, 4u}) {
      for (const uint32_t size : {8u, 24u}) {
        list.run.reset();
        EXPECT_EQ(render(list, {.width = size, .height = size, .samples = samples}).pixels[0],
                  (Float4{0.5f, 0.25f, 1, 1}));
      }
    }
  };
  drawAll();
  for (KernelCode& table : code) table.packedBytes = 0;
  drawAll();
  list.clear();
  addFill(list, {.blend = BlendMode::kPremultipliedAlpha}, corners, 3);
  tracker_.resolve(list);
  EXPECT_FALSE(device_->render(list, {.width = 8, .height = 8}, nullptr)) << "it is spoiled";
}

TEST_F(VulkanHeadless, ReusesDescriptorsAndMemoryAsBuffersComeAndGo) {
  const BufferId source = add("source", ramp(3, kThreads));
  for (uint32_t round = 0; round < 100; ++round) {
    const BufferId target = add("target", std::vector<uint32_t>(kThreads, round));
    update();
    PassList list;
    addAccumulate(list, source, target, kThreads, round, 1);
    execute(list);
    std::vector<uint32_t> expected(kThreads, round);
    accumulateOnHost(ramp(3, kThreads), expected, round, 1);
    ASSERT_EQ(read(target), expected) << "round " << round;
    table_.remove(target);
    tracker_.forget(target);
  }
  update();
}

TEST_F(VulkanHeadless, WaitsForTheGpuOnlyWhereATableHasChanged) {
  (void)add("one", ramp(1, kThreads));
  update();
  const double before = device_->busySeconds();
  update();
  EXPECT_EQ(device_->busySeconds(), before);
  const BufferId two = add("two", ramp(2, kThreads));
  update();
  EXPECT_GT(device_->busySeconds(), before);
  EXPECT_EQ(read(two), ramp(2, kThreads));
}

// Four devices share two queues, each on its own thread; the one that made them is gone.
TEST_F(VulkanHeadless, DevicesThatShareQueuesRunOnThreadsOfTheirOwn) {
  constexpr uint32_t kDevices = 4, kRounds = 20;
  Result<std::unique_ptr<HeadlessDevice>> first =
      createDeviceOfPelage({.validation = true, .queues = 2});
  ASSERT_TRUE(first);
  EXPECT_EQ((*first)->busySeconds(), 0);
  std::vector<std::unique_ptr<HeadlessDevice>> devices;
  for (uint32_t i = 0; i < kDevices; ++i) devices.push_back(valueOf((*first)->another()));
  EXPECT_EQ(devices[0]->info().uuid, (*first)->info().uuid);
  first->reset();
  std::vector<std::vector<uint32_t>> results(kDevices);
  const auto start = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> threads;
    for (uint32_t i = 0; i < kDevices; ++i)
      threads.emplace_back([&, i] {
        PELAGE_TEST_ADD_CODE(*devices[i]);
        ResourceTable table;
        HazardTracker tracker;
        const BufferId source = table.add("source", ramp(i, kThreads), BufferUsage::kStorage);
        const BufferId target = addZeros(table, "target", kThreads);
        PassList list;
        addAccumulate(list, source, target, kThreads, 2, 3);
        bool ran = bool(devices[i]->update(table));
        for (uint32_t round = 0; ran && round < kRounds; ++round) {
          list.run.reset();
          tracker.resolve(list);
          ran = bool(devices[i]->execute(list));
        }
        if (ran) results[i] = valuesOf<uint32_t>(valueOf(devices[i]->read(target)));
      });
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  EXPECT_GT(devices[0]->busySeconds(), 0);
  EXPECT_LE(devices[0]->busySeconds(), wall.count()) << "time in which several run counts once";
  for (uint32_t i = 0; i < kDevices; ++i) {
    std::vector<uint32_t> expected(kThreads, 0);
    for (uint32_t round = 0; round < kRounds; ++round)
      accumulateOnHost(ramp(i, kThreads), expected, 2, 3);
    EXPECT_EQ(results[i], expected) << "device " << i;
    EXPECT_EQ(devices[i]->messageCount(), 0u);
  }
}

// Bad input: an error that names pass and resource, and a device that still works.

class VulkanErrors : public VulkanHeadless {
 protected:
  static std::vector<uint32_t> spirvOf(const KernelVariant& variant) {
    return *KernelCodes(runtime_test::allSpirv()).spirv(variant);
  }
  // The module of a permutation that the test has copied.
  void giveSpirv(KernelVariant& variant, std::span<const uint32_t> words) {
    variant.hash = freshHash();
    const KernelCode* const code[] = {makeSpirv(*variant.kernel, variant.hash, words)};
    device_->addCode(code);
  }
  void SetUp() override {
    VulkanHeadless::SetUp();
    if (device_ == nullptr) return;
    a_ = add("first/positions", ramp(1, kThreads));
    b_ = add("first/tangents", ramp(2, kThreads));
    update();
    addAccumulate(list_, a_, b_, kThreads, 2, 3);
  }
  void TearDown() override {
    if (device_ == nullptr) return;
    // The error has changed nothing: a good list gives the numbers of an untouched device.
    tracker_ = {};
    PassList good;
    addAccumulate(good, a_, b_, kThreads, 2, 3);
    execute(good);
    std::vector<uint32_t> expected = ramp(2, kThreads);
    accumulateOnHost(ramp(1, kThreads), expected, 2, 3);
    EXPECT_EQ(read(b_), expected);
    VulkanHeadless::TearDown();
  }

  BufferId a_ = BufferId::kInvalid;
  BufferId b_ = BufferId::kInvalid;
  PassList list_;
};

TEST_F(VulkanErrors, NameAnOffsetThatTheDeviceCannotBind) {
  for (PassBinding& binding : list_.bindings) {
    if (binding.buffer == a_) {
      binding.offset = 2;
      binding.size = 8;
    }
  }
  expectError(run(list_), {"accumulate", "g_source", "storage buffer offset alignment"});
}

TEST_F(VulkanErrors, NameAKernelWithoutSpirv) {
  KernelVariant empty = runtime_test::accumulateVariant({.doubled = true});
  empty.hash = freshHash();
  list_.passes[0].kernel = &empty;
  expectError(run(list_), {"accumulate", "doubled=1", "SPIR-V"});
}

TEST_F(VulkanErrors, NameAKernelWhoseSpirvIsCutOff) {
  KernelVariant cut = runtime_test::accumulateVariant();
  list_.passes[0].kernel = &cut;
  const std::vector<uint32_t> whole = spirvOf(runtime_test::accumulateVariant());
  giveSpirv(cut, std::span(whole).first(6));
  expectError(run(list_), {"accumulate", "SPIR-V", "word 5"});
  giveSpirv(cut, std::vector<uint32_t>(20, 0x12345678u));
  expectError(run(list_), {"accumulate", "SPIR-V"});
}

TEST_F(VulkanErrors, NameAFeatureThatTheDeviceWasNotGiven) {
  // The module with OpCapability Float64 in front of its own capabilities.
  const KernelVariant& plain = runtime_test::accumulateVariant();
  std::vector<uint32_t> words = spirvOf(plain);
  const uint32_t capability[] = {2u << 16 | 17u, 10u};
  words.insert(words.begin() + 5, std::begin(capability), std::end(capability));
  KernelVariant needy = plain;
  giveSpirv(needy, words);
  list_.passes[0].kernel = &needy;
  expectError(run(list_), {"accumulate", "shaderFloat64"});
}

// Making a device.

// An environment variable for the time of a scope.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    had_ = std::getenv(name) != nullptr;
    setenv(name, value, 1);
  }
  ~Environment() {
    if (had_) {
      setenv(name_, old_.c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::string old_;
  bool had_ = false;
};

TEST(VulkanHeadlessDevice, NamesThePackageWithTheValidationLayerWhenItIsMissing) {
  const Environment nowhere("VK_LAYER_PATH", "/nonexistent");
  HeadlessDef def = {.validation = true};
  expectError(createHeadlessVulkan(def), ErrorCode::kUnsupported, "apt-get install");
}

TEST(VulkanHeadlessDevice, NamesThePackageWithADriverWhenThereIsNone) {
  const Environment newName("VK_DRIVER_FILES", "/nonexistent.json");
  const Environment oldName("VK_ICD_FILENAMES", "/nonexistent.json");
  expectError(createHeadlessVulkan({}), ErrorCode::kUnsupported, "apt-get install");
}

TEST(VulkanHeadlessDevice, LeavesNothingBehind) {
  testing::internal::CaptureStderr();
  {
    HeadlessDef def = {.validation = true};
    Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessVulkan(def);
    if (!made && made.error().code == ErrorCode::kUnsupported) {
      testing::internal::GetCapturedStderr();
      PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
    }
    ASSERT_TRUE(made);
    ResourceTable table;
    const BufferId buffer = table.add({"a", 4096, 4, BufferUsage::kStorage, {}});
    ASSERT_TRUE((*made)->update(table));
    PassList list;
    ASSERT_TRUE((*made)->render(list, {.width = 16, .height = 16, .samples = 4}));
    ASSERT_TRUE((*made)->read(buffer));
  }
  // The layer reports objects that outlive their device.
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace pelage::test
