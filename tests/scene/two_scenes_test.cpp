// Two scenes on two threads, each with a device of its own, do not know of each other: each has the
// bits that it has alone.
#include <gtest/gtest.h>

#include <barrier>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/delivery_scene.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"

namespace pelage::test {
namespace {

/// Contents of each buffer after each frame; or the reason why there are none.
struct Recording {
  std::vector<std::vector<std::vector<std::byte>>> frames;
  std::string error;
  bool skipped = false;

  void check(const Result<void>& done) {
    if (!done && error.empty()) error = done.error().message;
  }
};

// All of a scene's life, on the thread that calls it. `beat` is called before every frame.
template <class Beat>
Recording play(Api api, Solver solver, Beat&& beat) {
  Recording recording;
  Result<std::unique_ptr<HeadlessDevice>> device = createDevice({.api = api});
  if (!device) {
    recording.error = device.error().message;
    recording.skipped = device.error().code == ErrorCode::kUnsupported;
  }
  Scene scene;
  DeliveryScene inputs(scene, solver);
  PassList list;
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    beat();
    if (!recording.error.empty()) continue;
    inputs.setInputs(frame);
    recording.check(inputs.simulate(frame, list));
    scene.finish(list);
    recording.check((*device)->update(scene.resources()));
    recording.check((*device)->execute(list));
    auto& results = recording.frames.emplace_back();
    for (const BufferId buffer : inputs.results()) {
      Result<std::vector<std::byte>> bytes = (*device)->read(buffer);
      recording.check(bytes ? Result<void>() : bytes.error());
      results.push_back(bytes ? *std::move(bytes) : std::vector<std::byte>());
    }
  }
  return recording;
}

class TwoScenes : public testing::TestWithParam<Api> {};
INSTANTIATE_TEST_SUITE_P(All, TwoScenes, testing::ValuesIn(kRuntimeApis), apiTestName);

TEST_P(TwoScenes, OnTwoThreadsHaveTheBitsOfEachAlone) {
  constexpr Solver kSolvers[] = {Solver::kExact, Solver::kClassic};
  Recording alone[2], together[2];
  for (size_t i = 0; i < 2; ++i) {
    alone[i] = play(GetParam(), kSolvers[i], [] {});
    if (alone[i].skipped) PELAGE_SKIP_WITHOUT_DEVICE() << alone[i].error;
    ASSERT_EQ(alone[i].error, "");
    ASSERT_NE(alone[i].frames[2][0], alone[i].frames[9][0]) << "it moved at all";
  }
  // The frames of both begin at one time.
  std::barrier<> frames(2);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 2; ++i) {
    threads.emplace_back(
        [&, i] { together[i] = play(GetParam(), kSolvers[i], [&] { frames.arrive_and_wait(); }); });
  }
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(together[i].error, "");
    EXPECT_EQ(together[i].frames, alone[i].frames) << "scene " << i;
  }
}

}  // namespace
}  // namespace pelage::test
