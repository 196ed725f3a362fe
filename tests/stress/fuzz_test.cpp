// Random strands, materials, forces, steps and root motions, through Scene on every device: no NaN,
// and no strand longer or shorter than it was made. The strands are those of the reference's fuzz.
#include "stress/fuzz_group.h"
#include "stress/stress_run.h"

namespace pelage::test {
namespace {

constexpr int kFuzzedFrames = 90;
constexpr uint32_t kObjects = 12;  ///< of a scene; they share the time steps

/// Size of the fuzz. Few objects on lavapipe: see StressTest.
struct Extent {
  uint32_t strands;  ///< of all objects
  uint32_t group;    ///< strands of an object, which share the settings
  bool cached;
};

/// An object in the scene, and what became of its strands.
struct Trial {
  FuzzGroup group;
  HairId id = HairId::kInvalid;
  std::vector<double> stretch;  ///< [strand] the worst so far
  std::vector<bool> finite;     ///< [strand]
};

class Fuzz : public StressTest {
 protected:
  Extent extent() const {
    if (fullStress()) return {30000, 50, false};
    const uint32_t share = kSanitized ? 5 : 1;
    if (api() == Api::kVulkan && run_.device()->info().software) return {250 / share, 125, true};
    return {(api() == Api::kGles ? 250 : 1000) / share, 50, false};
  }

  Trial addTrial(uint32_t number, const Extent& e) {
    Trial trial;
    trial.group =
        makeFuzzGroup(number * e.group, e.group, kFuzzedFrames, settings_.solver, e.cached);
    trial.stretch.resize(e.group);
    trial.finite.assign(e.group, true);
    expectOk(trial.group.asset.process());
    std::vector<BoneInfluences> influences(e.group);
    for (uint32_t s = 0; s < e.group; ++s) {
      influences[s].bones[0] = s;
      influences[s].weights[0] = 1;
    }
    trial.id = add(trial.group.asset, {.name = "group " + std::to_string(number),
                                       .settings = trial.group.settings,
                                       .influences = influences,
                                       .boneCount = e.group});
    return trial;
  }

  void check(Trial& trial) {
    const HairBuffers& buffers = run_.scene.hair(trial.id).buffers();
    const std::vector<Float4> positions = run_.read(buffers.positions);
    const std::vector<Float4> tangents = run_.read(buffers.tangents);
    double size = 0;
    for (const Float4& p : positions)
      if (isFinite(p)) keepLargest(size, toVector(p).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    // The classic solver leaves errors below 4.8e-7 of the coordinates alone.
    const double rounding = size * (exact() ? 2e-5 : 6e-5);
    const HairAsset& asset = trial.group.asset;
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      const size_t from = size_t{s} * asset.verticesPerStrand;
      for (size_t i = from; i < from + asset.verticesPerStrand; ++i)
        trial.finite[s] = trial.finite[s] && isFinite(positions[i]) && isFinite(tangents[i]);
      keepLargest(trial.stretch[s], stretchOf(asset, positions, s, rounding));
    }
  }
};

TEST_P(Fuzz, EveryStrandStaysFiniteAndKeepsItsLength) {
  const Extent e = extent();
  const uint32_t objects = e.strands / e.group;
  uint32_t broken = 0, stretched = 0, worstStrand = 0;
  double worst = 0, worstHeld = 0;
  for (uint32_t from = 0; from < objects; from += kObjects) {
    std::vector<Trial> trials;
    for (uint32_t number = from; number < std::min(from + kObjects, objects); ++number)
      trials.push_back(addTrial(number, e));
    for (size_t frame = 0; frame < kFuzzedFrames; ++frame) {
      for (const Trial& trial : trials) {
        run_.scene.hair(trial.id).setBones(trial.group.bones[frame + 1]);
        run_.scene.hair(trial.id).setColliders(trial.group.colliders[frame + 1]);
      }
      run_.step(trials[0].group.steps[frame]);
      for (Trial& trial : trials) check(trial);
    }
    for (size_t t = 0; t < trials.size(); ++t) {
      for (uint32_t s = 0; s < e.group; ++s) {
        const uint32_t seed = (from + static_cast<uint32_t>(t)) * e.group + s;
        const double stretch = trials[t].stretch[s];
        // Strands that the classic solver holds at both ends may stretch: docs/decisions/0003.
        const bool span = !exact() && trials[t].group.heldTips;
        const bool fits = stretch <= (span ? 0.05 : 0.01);
        if (!trials[t].finite[s]) ++broken;
        if (!fits) ++stretched;
        if (!trials[t].finite[s] || !fits) {
          ADD_FAILURE() << "strand " << seed << (trials[t].finite[s] ? "" : " is not finite,")
                        << " is stretched by " << 100 * stretch << " %";
        }
        if (span) {
          keepLargest(worstHeld, stretch);
        } else if (stretch > worst) {
          worst = stretch;
          worstStrand = seed;
        }
      }
      remove(trials[t].id);
    }
  }
  std::printf(
      "[ FIGURE ] fuzz, %s: %u strands x %d frames, %u with a NaN, %u stretched by over 1 %%, at "
      "worst by %.3g %% (strand %u); classic, held at both ends: %.3g %%\n",
      label().c_str(), objects * e.group, kFuzzedFrames, broken, stretched, 100 * worst,
      worstStrand, 100 * worstHeld);
}

INSTANTIATE_TEST_SUITE_P(All, Fuzz, allSolversOnApis(), solverTestName);

}  // namespace
}  // namespace pelage::test
