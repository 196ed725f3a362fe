// A million steps: strands that swing without damping gain no energy and do not wander. And what
// a run in gusts may cost, in which the constants are new in every frame.
#include "stress/stress_run.h"
#include "support/plain_asset.h"

namespace pelage::test {
namespace {

constexpr uint32_t kSwinging = 32, kSwingingVertices = 4;
constexpr double kSwingingLength = 0.3;

/// Straight strands that start at different angles, from hanging to nearly upright.
HairAsset swingingAsset() {
  return strandsAt(kSwinging, kSwingingVertices, [](uint32_t s, uint32_t v) {
    const double angle = 2.5 * s / (kSwinging - 1), around = 0.7 * s;
    const Vector3d displacement(std::sin(angle) * std::cos(around), -std::cos(angle),
                                std::sin(angle) * std::sin(around));
    return toFloat3(Vector3d(0.01 * s, 0, 0) +
                    displacement * (kSwingingLength * v / (kSwingingVertices - 1)));
  });
}

/// Height of the free vertices above the lowest that the strand can hang, over its length: their
/// potential energy over m g L. The tip stands for half an edge.
double heightOf(const std::vector<Float4>& positions, uint32_t strand) {
  double sum = 0, mass = 0;
  for (uint32_t v = 2; v < kSwingingVertices; ++v) {
    const double m = v + 1 == kSwingingVertices ? 0.5 : 1;
    sum += m * toVector(positions[strand * kSwingingVertices + v]).y();
    mass += m;
  }
  return sum / mass / kSwingingLength;
}

class LongRun : public StressTest {
 protected:
  LongRun() {
    settings_.damping = 0;
    settings_.bendLength = 0.01f;
    settings_.localStiffness = 0;
    settings_.vspCoefficient = 0;
    settings_.maxSpeed = 1e6f;
    settings_.sleep.enabled = false;
    // None that could be seen; see StressTest.
    settings_.wind.velocity.z = settings_.airDrag = 1e-9f;
  }
};

TEST_P(LongRun, AMillionStepsOfAnUndampedSwingGainNoEnergyAndDoNotWander) {
  // The longest list that a frame may have: 4 steps of 1/60 s in 32 sub-steps each. The classic
  // solver has no sub-steps.
  settings_.subSteps = exact() ? 32 : 1;
  const uint32_t stepsAList = exact() ? 128 : 4;
  const uint32_t lists = fullStress()          ? 1000000 / stepsAList
                         : kSanitized          ? 50
                         : api() == Api::kGles ? 100
                         : exact()             ? 1000
                                               : 5000;
  const HairAsset asset = swingingAsset();
  const HairId id = add(asset, {.settings = settings_});
  HairObject& hair = run_.scene.hair(id);
  std::vector<double> start, highest(kSwinging, -2);
  for (uint32_t s = 0; s < kSwinging; ++s) start.push_back(heightOf(asset.positions, s));
  double stretch = 0, moved = 0;
  for (uint32_t list = 0; list < lists; ++list) {
    run_.step(4.0f / 60);
    if (list % 10 != 0 && list + 1 != lists) continue;
    const std::vector<Float4> positions = run_.positions(hair);
    ASSERT_TRUE(allFinite(positions)) << "list " << list;
    for (uint32_t s = 0; s < kSwinging; ++s) {
      keepLargest(highest[s], heightOf(positions, s));
      keepLargest(stretch, stretchOf(asset, positions, s, 1e-5));
      for (uint32_t v = 0; v < 2; ++v) {
        const size_t i = s * kSwingingVertices + v;
        keepLargest(moved, distance(positions[i], asset.positions[i]));
      }
    }
  }
  double gained = -1;
  for (uint32_t s = 0; s < kSwinging; ++s) keepLargest(gained, highest[s] - start[s]);
  EXPECT_LE(gained, 0.01) << "of m g L";
  EXPECT_LE(stretch, 1e-4);
  EXPECT_LE(moved, 1e-6) << "of the roots, in metres";

  // With damping they hang where new ones do. Stiffer, since limp hair loses its twist slowly.
  settings_.damping = hair.settings.damping = 0.2f;
  settings_.bendLength = hair.settings.bendLength = 0.05f;
  hair.settings.subSteps = 1;
  for (int frame = 0; frame < 600; ++frame) run_.step();
  const std::vector<Float4> old = run_.positions(hair);
  remove(id);
  settings_.subSteps = 1;
  const HairObject& fresh = run_.scene.hair(add(asset, {.settings = settings_}));
  for (int frame = 0; frame < 900; ++frame) run_.step();
  const std::vector<Float4> young = run_.positions(fresh);
  const double drift = maxDistance(old, young);
  EXPECT_LE(drift, 1e-4);
  std::printf(
      "[ FIGURE ] long run, %s: %u steps in %u lists; energy gained %.3g %% of m g L, stretch %.3g "
      "%%, where it hangs afterwards %.3g mm from new hair\n",
      label().c_str(), lists * stepsAList, lists, 100 * gained, 100 * stretch, 1000 * drift);
}

class GustyRun : public StressTest {
 protected:
  GustyRun() {
    settings_.gravity.x = 0.5f;
    settings_.wind.velocity = {2, 0, 1};
    settings_.vspCoefficient = 0.2f;
  }
};

// A driver that compiles a kernel anew for the constants of every frame keeps what it compiles:
// docs/decisions/0008.
TEST_P(GustyRun, TakesNoMemoryAFrame) {
  if (kSanitized) GTEST_SKIP() << "the sanitizers keep what is freed";
  constexpr int kGustyFrames = 8;
  constexpr double kMostAFrame = 1e6;
  HairObject& hair = run_.scene.hair(add(wavyAsset(8, 12), {.settings = settings_}));
  setCollider(hair, sphereCollider({0, -0.1f, 0}, 0.08f));
  for (int frame = 0; frame < kGustyFrames; ++frame) run_.step();
  const uint64_t before = residentMemory();
  if (before == 0) GTEST_SKIP() << "the system does not say how much memory there is";
  for (int frame = 0; frame < kGustyFrames; ++frame) run_.step();
  const double more = static_cast<double>(residentMemory()) - static_cast<double>(before);
  EXPECT_LE(more / kGustyFrames, kMostAFrame) << "bytes a frame";
  std::printf("[ FIGURE ] gusts, %s: %.3g MB a frame\n", label().c_str(),
              more / kGustyFrames / 1e6);
}

INSTANTIATE_TEST_SUITE_P(All, GustyRun, allSolversOnApis(), solverTestName);

INSTANTIATE_TEST_SUITE_P(All, LongRun, allSolversOnApis(), solverTestName);

}  // namespace
}  // namespace pelage::test
