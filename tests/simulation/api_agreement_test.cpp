// The precise kernels give the same bits on every API of one driver.
#include <gtest/gtest.h>

#include <cstring>

#include "support/strand_run.h"

namespace pelage::test {
namespace {

using reference::Pose;

/// Everything that the kernels wrote after 120 frames of two sub-steps with all features.
std::vector<uint32_t> simulatedBits(Gpu& gpu, bool dualQuaternions) {
  const HairAsset asset = wavyAsset(65, 17, 13);
  Random random(4);
  std::vector<FollowHairRecord> follows(130);
  for (uint32_t f = 0; f < 130; ++f) {
    follows[f].guides = {f / 2, (f + 7) % 65, (f + 9) % 65, 0};
    follows[f].weights = {0.5f, f % 3 == 0 ? 0.0f : 0.3f, f % 2 == 0 ? 0.0f : 0.2f, 0};
    follows[f].offset = toFloat4(random.vector(0.004), 0.5);
  }
  std::vector<RootBinding> bindings(65);
  for (RootBinding& binding : bindings) {
    binding.bones = {0, 1, 2, 1};
    binding.weights = {static_cast<float>(random.unit()), static_cast<float>(random.unit()),
                       static_cast<float>(random.unit()), 0};
  }
  const size_t rows = dualQuaternions ? 2 : 3;
  StrandRun run(gpu, asset, follows, std::vector<Float4>(3 * rows), bindings);
  SimulationConstants& c = run.constants;
  c.boneCount = 3;
  c.gravity = {0.5f, -9.81f, 0.3f, 0};
  c.dampingKeep = 0.97f;
  c.timeStep = 1.0f / 120;
  c.forceShare = 0.25f;
  c.localStiffness = 0.6f;
  c.globalStiffness = 0.05f;
  c.globalRange = 0.5f;
  c.vspCoefficient = 0.5f;
  c.vspThreshold = 30;
  run.setColliders(
      {{{0.1f, -0.1f, 0, 0.08f}, {0.2f, -0.1f, 0, 0.05f}, {0.1f, -0.1f, 0, 0.4f}, {}, {}},
       {{-0.1f, -0.1f, 0, 0.08f},
        {-0.1f, -0.1f, 0, 0.08f},
        {-0.12f, -0.1f, 0, 0},
        {-0.12f, -0.1f, 0, 0},
        {}}});
  for (int frame = 0; frame < 120; ++frame) {
    std::vector<Float4> bones;
    for (int bone = 0; bone < 3; ++bone) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * std::sin(0.1 * frame + bone),
                                                      Vector3d(bone, 1, 0.5).normalized()));
      const Vector3d shift(0.1 * std::sin(0.13 * frame), 0.05 * bone, 0);
      if (dualQuaternions) {
        const Eigen::Quaterniond dual =
            Eigen::Quaterniond(0, shift.x() / 2, shift.y() / 2, shift.z() / 2) * turn;
        bones.push_back(toFloat4(turn.vec(), turn.w()));
        bones.push_back(toFloat4(dual.vec(), dual.w()));
      } else {
        const Eigen::Matrix3d m = turn.toRotationMatrix() * (1 + 0.2 * bone);
        for (int row = 0; row < 3; ++row)
          bones.push_back(toFloat4(m.row(row).transpose(), shift[row]));
      }
    }
    run.setBones(bones);
    c.flags = frame == 0 ? 1 : 0;
    run.skinRoots(dualQuaternions);
    c.wind = {3.0f + static_cast<float>(frame % 7), 0.5f, -2, 4};
    for (int part = 0; part < 2; ++part) {
      c.rootBegin = 0.5f * static_cast<float>(part);
      c.rootEnd = c.rootBegin + 0.5f;
      run.simulate(StrandRun::terms(true, true, true, true, true));
    }
    run.updateFollowHairs();
    run.run();
  }
  std::vector<uint32_t> bits;
  const auto append = [&](const auto& data) {
    const size_t from = bits.size();
    bits.resize(from + data.size() * sizeof(data[0]) / sizeof(uint32_t));
    std::memcpy(bits.data() + from, data.data(), data.size() * sizeof(data[0]));
  };
  append(run.positions());
  append(run.tangents());
  append(run.roots());
  append(run.state());
  run.checkGuards();
  return bits;
}

TEST(ApiAgreement, SimulationHasTheSameBitsOnVulkanAndGl) {
  const std::vector<Gpu*> gpus = gpusOfOneDriver();
  if (gpus.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  for (const bool dual : {false, true}) {
    const std::vector<uint32_t> expected = simulatedBits(*gpus[0], dual);
    for (size_t k = 1; k < gpus.size(); ++k) {
      const std::vector<uint32_t> bits = simulatedBits(*gpus[k], dual);
      ASSERT_EQ(bits.size(), expected.size());
      size_t different = 0;
      for (size_t i = 0; i < bits.size(); ++i) different += bits[i] != expected[i] ? 1 : 0;
      EXPECT_EQ(different, 0u) << "of " << bits.size() << " words on "
                               << gpus[k]->device()->info().name << "; dual quaternions " << dual;
    }
  }
}

}  // namespace
}  // namespace pelage::test
