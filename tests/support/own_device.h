// A device of a test's own, and what its lists are made of: buffers of words and the kernels of
// tests/passes. For tests of the runtimes.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "runtime_test/gpu_structs.h"
#include "runtime_test/kernels.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"

namespace pelage::test {

using runtime_test::AccumulateConstants;
using runtime_test::FillConstants;

template <class T>
std::vector<T> valuesOf(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// first, first + 1, ...
inline std::vector<uint32_t> ramp(uint32_t first, size_t count) {
  std::vector<uint32_t> values(count);
  std::iota(values.begin(), values.end(), first);
  return values;
}

/// A buffer of 32-bit words.
inline BufferId addZeros(ResourceTable& table, const char* name, uint64_t count,
                         BufferUsage usage = BufferUsage::kStorage | BufferUsage::kUpload) {
  return table.add({.name = name, .size = count * 4, .stride = 4, .usage = usage});
}

inline void addAccumulate(PassList& list, BufferId source, BufferId target, uint32_t count,
                          uint32_t factor, uint32_t bias, bool doubled = false) {
  expectOk(PassBuilder(list)
               .dispatch(runtime_test::accumulateVariant({.doubled = doubled}), count)
               .bind("g_source", source, uint64_t{count} * 4)
               .bind("g_target", target, uint64_t{count} * 4)
               .constants("AccumulateConstants", AccumulateConstants{count, factor, bias, 0})
               .finish());
}
inline void accumulateOnHost(const std::vector<uint32_t>& source, std::vector<uint32_t>& target,
                             uint32_t factor, uint32_t bias, bool doubled = false) {
  for (size_t i = 0; i < target.size(); ++i)
    target[i] = 3 * target[i] + factor * (doubled ? 2 * source[i] : source[i]) + bias;
}

/// Triangles in one color. \param cornerCount  that `corners` has
inline void addFill(PassList& list, const DrawState& state, BufferId corners, uint32_t cornerCount,
                    const FillConstants& constants = {}, BufferId indices = BufferId::kInvalid,
                    uint32_t indexCount = 0) {
  expectOk(PassBuilder(list)
               .draw(runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(), state,
                     indexCount > 0 ? indexCount : cornerCount, 1, indices)
               .bind("g_corners", corners, uint64_t{cornerCount} * 16)
               .constants("FillConstants", constants)
               .finish());
}
/// Clip positions, y up.
inline const std::vector<Float4> kEverything = {{-1, -1, 0, 1}, {3, -1, 0, 1}, {-1, 3, 0, 1}};
inline const std::vector<Float4> kUpperHalf = {{-1, 0, 0, 1}, {1, 0, 0, 1}, {-1, 1, 0, 1},
                                               {-1, 1, 0, 1}, {1, 0, 0, 1}, {1, 1, 0, 1}};

class OwnDevice {
 protected:
  /// In SetUp(): skips the test where the API is not there.
  void open(Api api) {
    Result<std::unique_ptr<HeadlessDevice>> made = createDevice({.api = api, .validation = true});
    if (!made) {
      if (made.error().code == ErrorCode::kUnsupported)
        PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
      FAIL() << made.error().message;
    }
    device_ = *std::move(made);
  }
  /// In TearDown().
  void expectNoMessages() const {
    if (device_ == nullptr) return;
    EXPECT_EQ(device_->messageCount(), expectedMessages_) << "the driver or a layer complained";
  }

  template <class T>
  BufferId add(const char* name, const std::vector<T>& values,
               BufferUsage usage = BufferUsage::kStorage | BufferUsage::kUpload) {
    return table_.add(name, values, usage);
  }
  BufferId addWords(const char* name, uint64_t count,
                    BufferUsage usage = BufferUsage::kStorage | BufferUsage::kUpload) {
    return addZeros(table_, name, count, usage);
  }
  void update() { expectOk(device_->update(table_)); }
  /// As a new list, also where it has run.
  Result<void> run(PassList& list, std::vector<PassTiming>* timings = nullptr) {
    list.run.reset();
    tracker_.resolve(list);
    return device_->execute(list, timings);
  }
  void execute(PassList& list, std::vector<PassTiming>* timings = nullptr) {
    expectOk(run(list, timings));
  }
  /// Pixels of nothing after a failure.
  RenderedImage render(PassList& list, const RenderTargetDef& target,
                       std::vector<PassTiming>* timings = nullptr) {
    tracker_.resolve(list);
    Result<RenderedImage> image = device_->render(list, target, timings);
    if (image) return *std::move(image);
    ADD_FAILURE() << image.error().message;
    return {target.width, target.height, std::vector<Float4>(size_t{target.width} * target.height)};
  }
  std::vector<uint32_t> read(BufferId buffer, uint64_t offset = 0, uint64_t size = 0) {
    return valuesOf<uint32_t>(valueOf(device_->read(buffer, offset, size)));
  }

  std::unique_ptr<HeadlessDevice> device_;
  ResourceTable table_;
  HazardTracker tracker_;
  uint32_t expectedMessages_ = 0;
};

}  // namespace pelage::test
