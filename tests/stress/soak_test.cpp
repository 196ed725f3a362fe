// A scene that runs for long while objects come and go, views of every method too: nothing of them
// stays, in the table, on the device or in the process.
#include <chrono>

#include "stress/stress_run.h"
#include "support/delivery_scene.h"

namespace pelage::test {
namespace {

View viewOfSoak(uint32_t pixels) {
  View view;
  view.eye = {0.2f, 0.04f, 0.6f};
  view.worldToClip = lookAt(view.eye, {0.2f, 0.04f, 0}, {0, 1, 0}, 0.8f, 1, 0.05f, 5);
  view.width = view.height = pixels;
  return view;
}

class Soak : public testing::TestWithParam<Api> {
 protected:
  Soak() : run_(GetParam()) {}

  /// Everything comes, runs, and goes again. The numbers are those of every round: lavapipe
  /// compiles kernels anew for others, and keeps them (docs/decisions/0008).
  void round(uint32_t number) {
    const Solver solvers[] = {Solver::kExact, Solver::kClassic};
    Scene& scene = run_.scene;
    DeliveryScene world(scene, solvers[number % 2]);
    world.hair(0).material.fiberRadius = 0.001f;
    for (int frame = 0; frame < 3; ++frame) {
      world.setInputs(frame);
      Result<Frame> made = required(scene.simulate(DeliveryScene::seconds(frame)));
      const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 32};
      const auto method =
          static_cast<Transparency>((3 * number + static_cast<uint32_t>(frame)) % 8);
      const uint32_t pixels = 16 + 8 * (number % 2);
      ASSERT_TRUE(made->draw(viewOfSoak(pixels), {&light, 1}, {.method = method}));
      const RenderTargetDef target = {.width = pixels, .height = pixels};
      const auto images = required(run_.device()->render(*made, {&target, 1}));
      EXPECT_GE(scene.resources().totalBytes(), scene.drawBytes().shadows);
    }
    world.remove();
    scene.trim();
    expectOk(run_.device()->update(scene.resources()));
  }

  SceneRun run_;
};

TEST_P(Soak, ObjectsAndViewsThatComeAndGoLeaveNothing) {
  if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  using Clock = std::chrono::steady_clock;
  constexpr uint32_t kPeriod = 8;  // rounds in which every method, solver and size has its turn
  const auto length = std::chrono::seconds(fullStress() ? 1800 : 3);
  const HeadlessDevice& device = *run_.device();
  const ResourceTable& table = run_.scene.resources();
  Clock::time_point start;
  uint64_t before = 0, deviceBytes = 0;
  uint32_t slots = 0, number = 0;
  for (;; ++number) {
    if (number == kPeriod) {
      start = Clock::now();
      before = residentMemory();
    }
    if (number % kPeriod == 0 && number > kPeriod && Clock::now() - start > length) break;
    ASSERT_NO_FATAL_FAILURE(round(number));
    EXPECT_EQ(table.totalBytes(), 0u) << "round " << number;
    EXPECT_EQ(table.count(), 0u) << "round " << number;
    // Later rounds have no more than the first ones.
    if (number >= kPeriod) {
      EXPECT_LE(table.end(), slots) << "round " << number;
      EXPECT_LE(device.bufferBytes(), deviceBytes) << "round " << number;
    }
    slots = std::max(slots, table.end());
    deviceBytes = std::max(deviceBytes, device.bufferBytes());
  }
  if (kSanitized || before == 0) return;  // the sanitizers keep what is freed
  const double grown = static_cast<double>(residentMemory()) - static_cast<double>(before);
  EXPECT_LE(grown, 16e6) << "bytes of the process after " << number - kPeriod << " rounds";
  std::printf("[ FIGURE ] soak, %s: %u frames, %u of them measured, process grew by %.3g MB\n",
              apiName(GetParam()), 3 * number, 3 * (number - kPeriod), grown / 1e6);
}

INSTANTIATE_TEST_SUITE_P(All, Soak, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
