// skin_vertices against blends of matrices and dual quaternions in double precision.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>

#include "reference/skinning_reference.h"
#include "support/not_numbers.h"
#include "support/skinning_bones.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

using reference::Matrix34d;
using reference::WeightedBone;

constexpr float kBetween = 4711;  // what lies between the positions of a buffer

/// Where the positions of a buffer lie, in floats.
struct Location {
  uint32_t stride = 3, offset = 0;
};

std::vector<float> scatter(const std::vector<Vector3d>& positions, const Location& location) {
  std::vector<float> floats(location.offset + location.stride * positions.size(), kBetween);
  for (size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      floats[location.offset + location.stride * i + static_cast<size_t>(axis)] =
          static_cast<float>(positions[i][axis]);
  return floats;
}

class SkinRun {
 public:
  SkinRun(Gpu& gpu, const std::vector<Vector3d>& bind, const std::vector<VertexBinding>& bindings,
          const std::vector<Float4>& bones, bool dual, Location bindLocation = {},
          Location location = {}, Location beforeLocation = {})
      : gpu_(gpu),
        count_(static_cast<uint32_t>(bind.size())),
        location_(location),
        beforeLocation_(beforeLocation),
        bind_(gpu, "bindVertices", scatter(bind, bindLocation)),
        bindings_(gpu, "vertexBindings", bindings),
        bones_(gpu, "skinningBones", bones),
        skinned_(gpu, "skinned",
                 std::vector<float>(location.offset + location.stride * bind.size(), kBetween)),
        before_(gpu, "skinnedBefore",
                std::vector<float>(beforeLocation.offset + beforeLocation.stride * bind.size(),
                                   kBetween)) {
    constants.skinnedCount = count_;
    constants.skinningCount = static_cast<uint32_t>(bones.size() / (dual ? 2 : 3));
    constants.skinningReset = 1;
    constants.dualQuaternions = dual ? 1 : 0;
    constants.bindStride = bindLocation.stride;
    constants.bindOffset = bindLocation.offset;
    constants.skinnedStride = location.stride;
    constants.skinnedOffset = location.offset;
    constants.beforeStride = beforeLocation.stride;
    constants.beforeOffset = beforeLocation.offset;
    expectOk(gpu.device()->update(gpu.resources));
  }

  BoneSkinningConstants constants = {};

  void setBones(const std::vector<Float4>& bones) { bones_.upload(list_, bones); }

  void run() {
    PassBuilder builder(list_);
    builder.dispatch(skinVerticesVariant(), count_);
    bind_.bindTo(builder, "g_bindVertices");
    bindings_.bindTo(builder, "g_vertexBindings");
    bones_.bindTo(builder, "g_skinningBones");
    skinned_.bindTo(builder, "g_skinned");
    before_.bindTo(builder, "g_skinnedBefore");
    builder.constants("BoneSkinningConstants", constants);
    expectOk(builder.finish());
    gpu_.execute(list_);
    constants.skinningReset = 0;
  }

  std::vector<Vector3d> now() const { return gather(skinned_.read(), location_); }
  std::vector<Vector3d> before() const { return gather(before_.read(), beforeLocation_); }
  std::vector<float> floats() const { return skinned_.read(); }

 private:
  std::vector<Vector3d> gather(const std::vector<float>& floats, const Location& location) const {
    std::vector<Vector3d> positions;
    std::vector<bool> used(floats.size());
    for (size_t i = 0; i < count_; ++i) {
      const size_t at = location.offset + location.stride * i;
      positions.emplace_back(double{floats[at]}, double{floats[at + 1]}, double{floats[at + 2]});
      used[at] = used[at + 1] = used[at + 2] = true;
    }
    for (size_t i = 0; i < floats.size(); ++i) {
      if (!used[i]) {
        EXPECT_EQ(floats[i], kBetween) << "float " << i << " is not part of a position";
      }
    }
    return positions;
  }

  Gpu& gpu_;
  uint32_t count_;
  Location location_, beforeLocation_;
  PassList list_;
  GuardedBuffer<float> bind_;
  GuardedBuffer<VertexBinding> bindings_;
  GuardedBuffer<Float4> bones_;
  GuardedBuffer<float> skinned_, before_;
};

VertexBinding bindTo(std::initializer_list<std::pair<uint32_t, float>> bones) {
  VertexBinding binding = {};
  size_t i = 0;
  for (const auto& [bone, weight] : bones) {
    (&binding.bones.x)[i] = bone;
    (&binding.weights.x)[i++] = weight;
  }
  return binding;
}

/// Random vertices with one to four bones of a skeleton each.
struct Crowd {
  std::vector<Matrix34d> bones;
  std::vector<Vector3d> bind;
  std::vector<VertexBinding> bindings;

  Crowd(size_t count, bool rigidBones, uint64_t seed) {
    Random random(seed);
    const Eigen::Quaterniond base = random.rotation();
    for (int b = 0; b < 24; ++b) {
      const Eigen::AngleAxisd relativeRotation(random.between(0, 0.7),
                                               random.vector(1).normalized());
      Matrix34d m = rigidMatrix(Eigen::Quaterniond(relativeRotation) * base, random.vector(2));
      if (!rigidBones)
        m.leftCols<3>() *=
            Eigen::DiagonalMatrix<double, 3>(random.between(0.3, 3), 1, random.between(-2, 2));
      bones.push_back(rounded(m));
    }
    for (size_t i = 0; i < count; ++i) {
      bind.push_back(rounded(random.vector(1)));
      VertexBinding binding = {};
      for (size_t b = 0; b <= i % 4; ++b) {
        (&binding.bones.x)[b] = static_cast<uint32_t>(random.between(0, 23.99));
        (&binding.weights.x)[b] = static_cast<float>(random.between(0.1, 3));
      }
      bindings.push_back(binding);
    }
  }

  Vector3d expected(size_t vertex, bool dual) const {
    std::vector<WeightedBone> blend;
    for (size_t b = 0; b < 4; ++b) {
      const float weight = (&bindings[vertex].weights.x)[b];
      if (weight > 0) blend.push_back({bones[(&bindings[vertex].bones.x)[b]], double{weight}});
    }
    return (dual ? reference::skinByDualQuaternions(blend, bind[vertex])
                 : reference::skinByMatrices(blend, bind[vertex]))
        .position;
  }
};

class SkinVertices : public GpuTest {};

TEST_P(SkinVertices, MatchBlendsInDoublePrecisionInAnyVertexBuffer) {
  for (const bool dual : {false, true}) {
    const Crowd crowd(1000, dual, 11);
    for (const auto& [bindLocation, location, beforeLocation] :
         {std::tuple<Location, Location, Location>{{3, 0}, {3, 0}, {3, 0}},
          {{4, 0}, {4, 0}, {3, 0}},
          {{8, 5}, {6, 3}, {4, 1}}}) {
      SkinRun run(gpu(), crowd.bind, crowd.bindings, toBones(crowd.bones, dual), dual, bindLocation,
                  location, beforeLocation);
      run.run();
      const std::vector<Vector3d> now = run.now();
      double worst = 0;
      for (size_t i = 0; i < now.size(); ++i) {
        const Vector3d expected = crowd.expected(i, dual);
        keepLargest(worst, (now[i] - expected).norm() / (1 + expected.norm()));
      }
      EXPECT_LT(worst, 2e-6) << (dual ? "dual quaternions" : "matrices");
      EXPECT_EQ(run.before(), now) << "a reset has no motion";
    }
  }
}

TEST_P(SkinVertices, KeepThePositionsOfTheLastFrame) {
  const Crowd first(300, true, 13);
  Crowd second = first;
  for (Matrix34d& bone : second.bones) bone.col(3) += Vector3d(0.1, 0.2, -0.3);
  for (const bool dual : {false, true}) {
    SkinRun run(gpu(), first.bind, first.bindings, toBones(first.bones, dual), dual, {3, 0},
                {4, 0});
    run.run();
    const std::vector<Vector3d> before = run.now();
    run.setBones(toBones(second.bones, dual));
    run.run();
    EXPECT_EQ(run.before(), before);
    const std::vector<Vector3d> now = run.now();
    for (size_t i = 0; i < now.size(); ++i)
      EXPECT_LT((now[i] - before[i] - Vector3d(0.1, 0.2, -0.3)).norm(), 3e-6) << i;
    run.run();
    EXPECT_EQ(run.before(), now) << "bones at rest: no motion";
    EXPECT_EQ(run.now(), now);
  }
}

TEST_P(SkinVertices, StayWhereTheyWereForBonesThatAreNotNumbers) {
  const Crowd crowd(64, true, 17);
  std::vector<VertexBinding> bindings = crowd.bindings;
  for (VertexBinding& binding : bindings) binding = bindTo({{binding.bones.x, 0.5f}, {23, 0.5f}});
  bindings[5] = bindTo({{2, 1.0f}});  // the only one without the bone that breaks
  for (const bool dual : {false, true}) {
    const std::vector<Float4> good = toBones(crowd.bones, dual);
    for (const float broken : {kNan, kInf, -kInf, 3e38f}) {
      SkinRun run(gpu(), crowd.bind, bindings, good, dual);
      run.run();
      const std::vector<Vector3d> first = run.now();
      std::vector<Matrix34d> moved = crowd.bones;
      moved[2].col(3).x() += 1;
      std::vector<Float4> bones = toBones(moved, dual);
      bones[bones.size() - 1].y = broken;
      run.setBones(bones);
      run.run();
      const std::vector<Vector3d> now = run.now();
      for (size_t i = 0; i < now.size(); ++i) {
        if (i == 5)
          EXPECT_NEAR((now[i] - first[i]).x(), 1, 1e-5);
        else
          EXPECT_EQ(now[i], first[i]) << i << ", " << broken;
      }
      EXPECT_EQ(run.before(), first);
      // Without a frame before: the bind pose.
      SkinRun fresh(gpu(), crowd.bind, bindings, bones, dual);
      fresh.run();
      EXPECT_EQ(fresh.now()[0], crowd.bind[0]);
      EXPECT_EQ(fresh.before()[0], crowd.bind[0]);
    }
  }
}

TEST_P(SkinVertices, StayWhereTheyWereForSumsThatAreTooLarge) {
  const std::vector<Vector3d> bind(3, Vector3d(1, 1, 1));
  const std::vector<VertexBinding> bindings(3, bindTo({{0, 1.0f}}));
  for (const bool dual : {false, true}) {
    std::vector<Float4> bones = toBones({Matrix34d::Identity()}, dual);
    SkinRun run(gpu(), bind, bindings, bones, dual);
    run.run();
    // Usable each by itself.
    bones[1] = {9e17f, 9e17f, 9e17f, 9e17f};
    run.setBones(bones);
    run.run();
    EXPECT_EQ(run.now(), bind);
  }
}

TEST_P(SkinVertices, TakeTheFirstBoneWhereNoWeightCounts) {
  const Crowd crowd(6, true, 19);
  std::vector<VertexBinding> bindings(6);
  bindings[0] = bindTo({{3, 0.0f}, {5, 0.0f}});
  bindings[1] = bindTo({{3, -1.0f}, {5, kNan}});
  bindings[2] = bindTo({{3, 0.0f}, {24, 1.0f}});  // that one does not exist
  bindings[3] = bindTo({{3, 0.25f}, {0xffffffffu, 1.0f}});
  bindings[4] = bindTo({{0x55555556u, 1.0f}});  // times 3 is 2 in 32 bits
  bindings[5] = bindTo({{0x80000001u, 0.0f}});  // times 2 is 2
  for (const bool dual : {false, true}) {
    SkinRun run(gpu(), crowd.bind, bindings, toBones(crowd.bones, dual), dual);
    run.run();
    const std::vector<Vector3d> now = run.now();
    for (size_t i = 0; i < 4; ++i)
      EXPECT_LT((now[i] - crowd.bones[3] * crowd.bind[i].homogeneous()).norm(), 3e-6) << i;
    for (size_t i = 4; i < 6; ++i) EXPECT_EQ(now[i], crowd.bind[i]) << "no bone at all";
  }
}

TEST_P(SkinVertices, LeaveBindPositionsThatAreNotNumbersToTheReader) {
  Crowd crowd(8, true, 23);
  crowd.bind[3].y() = double{kNan};
  for (const bool dual : {false, true}) {
    SkinRun run(gpu(), crowd.bind, crowd.bindings, toBones(crowd.bones, dual), dual);
    for (int frame = 0; frame < 2; ++frame) {
      run.run();
      const std::vector<Vector3d> now = run.now();
      EXPECT_FALSE(now[3].allFinite());
      for (const size_t i : {2u, 4u}) EXPECT_LT((now[i] - crowd.expected(i, dual)).norm(), 1e-5);
    }
  }
}

TEST_P(SkinVertices, TakeAnyNumberOfVertices) {
  for (const size_t count : {1u, 63u, 65u, 70000u}) {
    const Crowd crowd(count, true, 29);
    SkinRun run(gpu(), crowd.bind, crowd.bindings, toBones(crowd.bones, false), false);
    run.run();
    const std::vector<Vector3d> now = run.now();
    double worst = 0;
    for (size_t i = 0; i < count; ++i)
      keepLargest(worst, (now[i] - crowd.expected(i, false)).norm());
    EXPECT_LT(worst, 1e-5) << count;
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, SkinVertices, testing::ValuesIn(kApis), apiTestName);

TEST(SkinVerticesBits, AreTheSameOnEveryApi) {
  for (const bool dual : {false, true}) {
    const Crowd crowd(2000, dual, 31);
    std::vector<float> floats;
    for (Gpu* gpu : startedGpus()) {
      SkinRun run(*gpu, crowd.bind, crowd.bindings, toBones(crowd.bones, dual), dual);
      run.run();
      if (floats.empty()) floats = run.floats();
      EXPECT_EQ(std::memcmp(run.floats().data(), floats.data(), floats.size() * sizeof(float)), 0)
          << apiName(gpu->api());
    }
    if (floats.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  }
}

}  // namespace
}  // namespace pelage::test
