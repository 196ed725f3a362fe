// Devices for tests: each is made once a process; what a device lacks skips the test, and says
// what.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "support/errors.h"
#include "support/required_devices.h"
#include "support/test_tier.h"

#include "test_kernels.h"

namespace pelage::test {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

inline constexpr std::array<Api, 3> kApis = {Api::kVulkan, Api::kGl, Api::kGles};

/// Scenes are tested on one API of each runtime where other tests run their kernels on every API:
/// OpenGL ES has the host code of OpenGL.
inline constexpr std::array<Api, 2> kRuntimeApis = {Api::kVulkan, Api::kGl};

/// On which tests of the host's code run, when the kernels that run are tested on every API.
#if PELAGE_TEST_VULKAN
inline constexpr Api kFirstApi = Api::kVulkan;
#else
inline constexpr Api kFirstApi = Api::kGl;
#endif

inline Result<std::unique_ptr<HeadlessDevice>> createDeviceOfPelage(HeadlessDef def) {
  def.maxTier = std::min(def.maxTier, tierOfTests());
  if (def.api == Api::kVulkan) {
#if PELAGE_TEST_VULKAN
    return createHeadlessVulkan(def);
#endif
  } else {
#if PELAGE_TEST_GL
    return createHeadlessGl(def);
#endif
  }
  return Error{ErrorCode::kUnsupported, "this build has no runtime for it"};
}

/// A device that knows the kernels of the test, too (KERNELS of pelage_tests()).
inline Result<std::unique_ptr<HeadlessDevice>> createDevice(const HeadlessDef& def) {
  Result<std::unique_ptr<HeadlessDevice>> device = createDeviceOfPelage(def);
  if (device) {
    PELAGE_TEST_ADD_CODE(**device);
  }
  return device;
}

/// A device, the buffers that tests have on it, and the hazards between their lists. One object for
/// each API, because a device recognises buffers by the ids of one table.
class Gpu {
 public:
  static Gpu& of(Api api) {
    // Not static objects: drivers may be unloaded before those are destroyed.
    static std::array<std::unique_ptr<Gpu>, kApis.size()>* all = [] {
      static auto gpus = std::make_unique<std::array<std::unique_ptr<Gpu>, kApis.size()>>();
      struct Cleanup : testing::Environment {
        void TearDown() override {
          for (auto& gpu : *gpus) gpu.reset();
        }
      };
      testing::AddGlobalTestEnvironment(new Cleanup);
      return gpus.get();
    }();
    std::unique_ptr<Gpu>& gpu = (*all)[static_cast<size_t>(api)];
    if (!gpu) gpu.reset(new Gpu(api));
    return *gpu;
  }

  /// nullptr when there is none; error() says why.
  HeadlessDevice* device() const { return device_.get(); }
  const Error& error() const { return error_; }
  /// Makes the buffers that are new, runs what a list has, and clears it.
  void execute(PassList& list) {
    expectOk(device_->update(resources));
    hazards.resolve(list);
    expectOk(device_->execute(list));
    list.clear();
  }
  Api api() const { return api_; }

  ResourceTable resources;
  HazardTracker hazards;

 private:
  explicit Gpu(Api api) : api_(api) {
    HeadlessDef def;
    def.api = api;
    def.validation = true;
    auto made = createDevice(def);
    if (!made) {
      // Without the validation layer or a debug context the results can still be checked.
      missingDevice(made.error().message);
      def.validation = false;
      made = createDevice(def);
    }
    if (made)
      device_ = std::move(*made);
    else
      error_ = made.error();
  }

  Api api_;
  std::unique_ptr<HeadlessDevice> device_;
  Error error_;
};

/// The driver behind a device, as far as its name shows: lavapipe and llvmpipe are one.
inline std::string driverFamily(const DeviceInfo& info) {
  return info.software ? "software" : info.name.substr(0, info.name.find('/'));
}

/// The devices of all APIs that have the driver of the first one; no API may fail to start.
inline std::vector<Gpu*> gpusOfOneDriver() {
  std::vector<Gpu*> gpus;
  for (const Api api : kApis) {
    Gpu& gpu = Gpu::of(api);
    if (gpu.device() == nullptr) {
      EXPECT_EQ(gpu.error().code, ErrorCode::kUnsupported) << gpu.error().message;
      continue;
    }
    const std::string family = driverFamily(gpu.device()->info());
    if (gpus.empty() || family == driverFamily(gpus[0]->device()->info())) gpus.push_back(&gpu);
  }
  return gpus;
}

/// The devices of all APIs that start.
inline std::vector<Gpu*> startedGpus() {
  std::vector<Gpu*> gpus;
  for (const Api api : kApis)
    if (Gpu::of(api).device() != nullptr) gpus.push_back(&Gpu::of(api));
  return gpus;
}

/// Runs a kernel on so many threads. \param offer  binds what it reads and writes
template <class Offer>
void dispatch(Gpu& gpu, const KernelVariant& kernel, size_t threads, const Offer& offer) {
  PassList list;
  PassBuilder builder(list);
  builder.dispatch(kernel, static_cast<uint32_t>(threads));
  offer(builder);
  expectOk(builder.finish());
  gpu.execute(list);
}

/// Base of tests that run on every API: TEST_P with the Api as parameter.
class GpuTest : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    gpu_ = &Gpu::of(GetParam());
    if (gpu_->device() == nullptr) {
      if (gpu_->error().code == ErrorCode::kUnsupported)
        PELAGE_SKIP_WITHOUT_DEVICE() << gpu_->error().message;
      FAIL() << gpu_->error().message;
    }
    messages_ = gpu_->device()->messageCount();
  }
  void TearDown() override {
    if (gpu_->device() != nullptr) {
      EXPECT_EQ(gpu_->device()->messageCount(), messages_) << "the driver or a layer complained";
    }
  }

  Gpu& gpu() { return *gpu_; }

 private:
  Gpu* gpu_ = nullptr;
  uint32_t messages_ = 0;
};

inline std::string apiTestName(const testing::TestParamInfo<Api>& info) {
  return apiName(info.param);
}

/// A storage buffer with a pattern behind its elements, all of which is bound, so that a write past
/// the end is seen and not dropped by a robust driver.
template <class T>
class GuardedBuffer {
 public:
  GuardedBuffer(Gpu& gpu, std::string name, const std::vector<T>& data)
      : gpu_(gpu), count_(data.size()) {
    BufferDesc desc;
    desc.name = std::move(name);
    desc.size = bytes() + kGuardBytes;
    desc.stride = sizeof(T);
    desc.usage = BufferUsage::kStorage | BufferUsage::kUpload | BufferUsage::kReadback;
    desc.initial.assign(desc.size, kGuard);
    if (count_ > 0) std::memcpy(desc.initial.data(), data.data(), bytes());
    id_ = gpu.resources.add(std::move(desc));
  }
  ~GuardedBuffer() {
    gpu_.hazards.forget(id_);
    gpu_.resources.remove(id_);
  }
  GuardedBuffer(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(const GuardedBuffer&) = delete;

  void bindTo(PassBuilder& pass, std::string_view name) const {
    pass.bind(name, id_, bytes() + kGuardBytes);
  }
  void upload(PassList& list, const std::vector<T>& data) const {
    ASSERT_EQ(data.size(), count_);
    addUpload(list, id_, std::as_bytes(std::span(data)));
  }
  /// Reads the elements back and checks the pattern behind them.
  std::vector<T> read() const {
    Result<std::vector<std::byte>> raw = gpu_.device()->read(id_);
    if (!raw) {
      ADD_FAILURE() << raw.error().message;
      return std::vector<T>(count_);
    }
    EXPECT_TRUE(std::all_of(raw->begin() + static_cast<ptrdiff_t>(bytes()), raw->end(),
                            [](std::byte b) { return b == kGuard; }))
        << "something wrote past the end of " << gpu_.resources.find(id_)->name;
    std::vector<T> result(count_);
    if (count_ > 0) std::memcpy(result.data(), raw->data(), bytes());
    return result;
  }
  BufferId id() const { return id_; }

 private:
  static constexpr std::byte kGuard{0xa5};
  static constexpr uint64_t kGuardBytes = 1024;
  uint64_t bytes() const { return count_ * sizeof(T); }

  Gpu& gpu_;
  size_t count_;
  BufferId id_;
};

}  // namespace pelage::test
