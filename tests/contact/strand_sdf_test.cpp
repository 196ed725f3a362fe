// Contacts of both solvers with signed distance fields.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "contact/contact_run.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "reference/sdf/sdf_builder.h"
#include "simulation/exact_solver.h"
#include "support/exact_pass.h"

namespace pelage::test {
namespace {

using reference::DistanceOracle;
using reference::FieldOptions;
using reference::SdfBuffers;
using reference::TriangleMesh;

constexpr float kFieldStep = 1.0f / 60;

/// The exact solver on buffers of its own; the roots stay in the bind pose.
class RodFieldRun {
 public:
  /// Where the log lies: far enough from the roots that these do not hold what lies on it.
  static constexpr float kLogX = 0.1f;
  RodFieldRun(Gpu& gpu, const HairAsset& asset, const SdfBuffers& sdf)
      : gpu_(gpu), pass_(gpu, {.contacts = true, .velocityShockPropagation = true}, dataOf(asset)) {
    setSdfs(sdf);
    pass_.constants.outputVertices = asset.verticesPerStrand;
    pass_.constants.frameTime = pass_.constants.frameTimeBefore = kFieldStep;
    pass_.constants.flags = ExactPass::kReset;
    settings_.damping = 0.06f;
    expectOk(gpu.device()->update(gpu.resources));
  }

  void setSdfs(const SdfBuffers& sdf) {
    pass_.contacts->setSdfs(list_, sdf.sdfs, sdf.keys, sdf.surface);
  }
  void setGravity(const Vector3d& g) { settings_.gravity = toFloat3(g); }
  void step() {
    ExactConstants& constants = pass_.constants;
    detail::setExactStep(constants, settings_, double{kFieldStep}, history_, {});
    constants.rootBegin = 0;
    constants.rootEnd = 1;
    constants.flags |= 2;
    if (constants.rotationRatio != 1) constants.flags |= 32;
    pass_.begin(list_);
    pass_.solve(list_, {.length = kFieldStep, .gravity = settings_.gravity});
    gpu_.execute(list_);
    constants.slot = (constants.slot + 1) % 4;
    constants.flags = 0;
  }
  std::vector<Float4> positions() const { return pass_.positions.read(); }

 private:
  static ExactData dataOf(const HairAsset& asset) {
    const detail::ExactStrands packed = detail::packExactStrands(asset, false);
    const auto strands = static_cast<uint32_t>(packed.strands.size());
    return {.strands = packed.strands,
            .state = stateOf(asset, detail::exactStateCount(packed.stateStride, strands)),
            .rest = detail::packExactRest(asset, packed, {}),
            .roots = rootsOf(asset),
            .stride = packed.stateStride,
            .strandRecords = packed.stateStride,
            .outputs = static_cast<uint32_t>(asset.positions.size())};
  }
  // Zeros, then the roots.
  static std::vector<Float4> stateOf(const HairAsset& asset, size_t count) {
    std::vector<Float4> state((count + 15) / 16 * 16);
    const std::vector<Float4> roots = rootsOf(asset);
    state.insert(state.end(), roots.begin(), roots.end());
    return state;
  }
  static std::vector<Float4> rootsOf(const HairAsset& asset) {
    std::vector<Float4> roots;
    for (int set = 0; set < 2; ++set)
      for (uint32_t s = 0; s < asset.strandCount; ++s) {
        roots.push_back({0, 0, 0, 1});
        roots.push_back(toFloat4(bindOf(asset, s)[0]));
      }
    return roots;
  }

  Gpu& gpu_;
  PassList list_;
  SimulationSettings settings_;
  detail::ExactHistory history_;
  ExactPass pass_;
};

/// The same for simulate_classic.
class ClassicFieldRun {
 public:
  /// Under the roots: without stiffness the strands would slide in between.
  static constexpr float kLogX = 0.02f;
  ClassicFieldRun(Gpu& gpu, const HairAsset& asset, const SdfBuffers& sdf) : run_(gpu, asset) {
    run_.reset(bindPoses(asset));
    run_.setSdfs(sdf.sdfs, sdf.keys, sdf.surface);
    setGravity({0, -9.81, 0});
    run_.constants.dampingKeep = 0.94f;
  }
  void setSdfs(const SdfBuffers& sdf) { run_.setSdfs(sdf.sdfs, sdf.keys, sdf.surface); }
  void setGravity(const Vector3d& g) { run_.constants.gravity = toFloat4(g); }
  void setDampingKeep(float keep) { run_.constants.dampingKeep = keep; }
  void step() {
    run_.simulate({.wind = true,
                   .globalShape = true,
                   .localShape = true,
                   .velocityShockPropagation = true,
                   .contacts = true});
    run_.run();
  }
  std::vector<Float4> positions() const { return run_.positions(); }

 private:
  StrandRun run_;
};

/// Depth of the deepest vertex behind the first two [cell], and how many are within half a cell.
struct Depth {
  double deepest = -1e9;
  int touching = 0;
};
Depth depthOf(const HairAsset& asset, const std::vector<Float4>& positions,
              const DistanceOracle& oracle, double cell, const Vector3d& shift = {0, 0, 0}) {
  Depth depth;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (i % asset.verticesPerStrand < 2) continue;
    const double distance = oracle.signedDistance(toVector(positions[i]) - shift) / cell;
    keepLargest(depth.deepest, -distance);
    if (distance < 0.5) ++depth.touching;
  }
  return depth;
}

constexpr double kFieldCell = 0.01;

/// A ball of 8 cm, drawn out along z so that nothing slides off it sideways.
TriangleMesh drawnBall(float x) {
  TriangleMesh mesh = reference::sphere(0.08f, 24, 48);
  for (Float3& p : mesh.positions) p = {p.x + x, p.y - 0.1f, 6 * p.z + 0.02f};
  return mesh;
}

/// A log below the strands, that may have gone by `way` in every frame.
struct Log {
  explicit Log(float x, float friction, const Vector3d& displacement = {0, 0, 0})
      : mesh(drawnBall(x)), oracle(mesh) {
    before = reference::moved(mesh, toFloat3(-displacement)).positions;
    reference::addSdf(buffers, mesh, oracle,
                      {.cell = kFieldCell, .friction = friction, .before = &before});
    buffers.sdfs[0].motionScale = 0;
  }
  /// Where it is after it has gone by `shift`; `moves`: it went by its way in this frame.
  SdfBuffers at(const Vector3d& shift, bool moves) const {
    SdfBuffers sdf{.sdfs = buffers.sdfs, .keys = {}, .surface = {}};
    sdf.sdfs[0].origin.x += static_cast<float>(shift.x());
    sdf.sdfs[0].origin.y += static_cast<float>(shift.y());
    sdf.sdfs[0].origin.z += static_cast<float>(shift.z());
    sdf.sdfs[0].motionScale = moves ? 1 : 0;
    return sdf;
  }

  TriangleMesh mesh;
  DistanceOracle oracle;
  std::vector<Float3> before;
  SdfBuffers buffers;
};

class StrandField : public GpuTest {
 protected:
  template <class Run>
  void hangOver(double stretch) {
    for (const float friction : {0.0f, 0.4f}) {
      const HairAsset asset = combAsset(5, 24);
      const Log log(Run::kLogX, friction);
      Run run(gpu(), asset, log.buffers);
      Depth depth;
      for (int frame = 0; frame < 90; ++frame) {
        run.step();
        if (frame % 10 != 9) continue;
        const std::vector<Float4> positions = run.positions();
        EXPECT_LT(maxStretch(asset, positions, 1), stretch);
        depth = depthOf(asset, positions, log.oracle, kFieldCell);
        EXPECT_LT(depth.deepest, 0.02) << "[cell] in frame " << frame;
      }
      EXPECT_GT(depth.touching, 10) << "it hangs elsewhere";
    }
  }

  /// How far vertices that lie on the log are taken along z by 40 frames in which the log goes
  /// and gravity leans by these, after 60 frames at rest [m].
  template <class Run>
  double takenAlong(float friction, const Vector3d& displacement, const Vector3d& gravity) {
    const HairAsset asset = combAsset(3, 24);
    const Log log(Run::kLogX, friction, displacement);
    Run run(gpu(), asset, log.buffers);
    for (int frame = 0; frame < 60; ++frame) run.step();
    const std::vector<Float4> before = run.positions();
    run.setGravity(gravity);
    for (int frame = 1; frame <= 40; ++frame) {
      run.setSdfs(log.at(displacement * frame, true));
      run.step();
    }
    const std::vector<Float4> after = run.positions();
    EXPECT_LT(depthOf(asset, after, log.oracle, kFieldCell, displacement * 40).deepest, 0.02);
    double taken = 0;
    int count = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      if (i % asset.verticesPerStrand < 2) continue;
      if (log.oracle.signedDistance(toVector(before[i])) > 0.2 * kFieldCell) continue;
      taken += double{after[i].z} - double{before[i].z};
      ++count;
    }
    EXPECT_GT(count, 5);
    std::printf("[ FIGURE ] friction %g: taken along by %g m\n", double{friction}, taken / count);
    return taken / count;
  }

  template <class Run>
  void frictionHolds() {
    const Vector3d leaning(0, -9.81, 0.8);
    const double free = takenAlong<Run>(0, {0, 0, 0}, leaning);
    EXPECT_LT(std::abs(takenAlong<Run>(0.6f, {0, 0, 0}, leaning)), 0.2 * std::abs(free));
  }
  template <class Run>
  void frictionTakesAlong() {
    const Vector3d displacement(0, 0, 5e-4), down(0, -9.81, 0);
    const double free = takenAlong<Run>(0, displacement, down);
    EXPECT_GT(takenAlong<Run>(1.0f, displacement, down), 0.6 * 40 * displacement.z());
    EXPECT_LT(free, 0.3 * 40 * displacement.z());
  }

  /// How deep anything gets into or below a plate of 1.2 cells in frames that gravity makes longer
  /// by `cells` cells each [cell].
  template <class Run>
  double fallThrough(double cells) {
    const HairAsset asset = combAsset(3, 16);
    const double cell = 0.02;
    const TriangleMesh plate =
        reference::box({-0.4f, static_cast<float>(-0.1 - 1.2 * cell), -0.3f}, {0.4f, -0.1f, 0.35f});
    const DistanceOracle oracle(plate);
    SdfBuffers sdf;
    reference::addSdf(sdf, plate, oracle, {.cell = cell});
    Run run(gpu(), asset, sdf);
    const double frame = double{kFieldStep};
    run.setGravity({0, -cells * cell / (frame * frame), 0});
    double below = 0;
    for (int i = 0; i < 12; ++i) {
      run.step();
      for (const Float4& p : run.positions()) {
        EXPECT_TRUE(isFinite(p));
        keepLargest(below, (-0.1 - double{p.y}) / cell);
      }
    }
    std::printf("[ FIGURE ] %g cells: %g cells below\n", cells, below);
    return below;
  }
};

// K6
TEST_P(StrandField, RodsHangOverALogAtTheirLengths) { hangOver<RodFieldRun>(1e-3); }
TEST_P(StrandField, ClassicStrandsHangOverALogAtTheirLengths) { hangOver<ClassicFieldRun>(1e-5); }

TEST_P(StrandField, FrictionHoldsRodsOnALog) { frictionHolds<RodFieldRun>(); }
TEST_P(StrandField, FrictionHoldsClassicStrandsOnALog) { frictionHolds<ClassicFieldRun>(); }

TEST_P(StrandField, ALogThatMovesTakesRodsAlong) { frictionTakesAlong<RodFieldRun>(); }
TEST_P(StrandField, ALogThatMovesTakesClassicStrandsAlong) {
  frictionTakesAlong<ClassicFieldRun>();
}

TEST_P(StrandField, FastRodsDoNotFallThroughAPlate) {
  for (const double cells : {1.0, 6.0}) EXPECT_LT(fallThrough<RodFieldRun>(cells), 0.25) << cells;
}
TEST_P(StrandField, FastClassicStrandsDoNotFallThroughAPlate) {
  for (const double cells : {1.0, 6.0})
    EXPECT_LT(fallThrough<ClassicFieldRun>(cells), 0.25) << cells;
}

/// Let a vertex slide on a slab that is inclined by `degrees`: its strand comes from 500 m to the
/// side, so that it holds it there and nowhere else [m].
double slideOnSlab(Gpu& gpu, double degrees, float friction, int steps) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vector3d down(std::cos(angle), -std::sin(angle), 0),
      up(std::sin(angle), std::cos(angle), 0);
  const HairAsset asset = vertexOnALongStrand();
  const TriangleMesh slab =
      reference::rotated(reference::box({-0.5f, -0.1f, -0.1f}, {2.0f, 0, 0.1f}), {0, 0, 1},
                         static_cast<float>(-angle));
  SdfBuffers sdf;
  reference::addSdf(sdf, slab, DistanceOracle(slab), {.cell = 0.05, .friction = friction});
  ClassicFieldRun run(gpu, asset, sdf);
  run.setDampingKeep(1);
  for (int step = 0; step < steps; ++step) run.step();
  const Vector3d end = toVector(run.positions()[2]);
  EXPECT_LT(std::abs(end.dot(up)), 1e-3) << "off the slab";
  return end.dot(down);
}

// K29
TEST_P(StrandField, ASlopeHoldsAndLetsSlideAsCoulombSays) {
  EXPECT_LT(std::abs(slideOnSlab(gpu(), 10, 0.3f, 200)), 1e-3);
  const double angle = 25 * std::numbers::pi / 180;
  const int steps = 40;
  const double expected = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle)) *
                          std::pow(double{kFieldStep}, 2) * steps * (steps + 1) / 2;
  EXPECT_NEAR(slideOnSlab(gpu(), 25, 0.3f, steps), expected, 0.02 * expected);
}

TEST_P(StrandField, HeldVerticesStayWhereTheyAre) {
  // Vertex 9 is in the middle of the ball.
  HairAsset asset = combAsset(2, 24);
  asset.positions[9].w = asset.positions[24 + 9].w = 0;
  expectOk(asset.process());
  const Vector3d middle = toVector(asset.positions[9]);
  const TriangleMesh ball =
      reference::sphere(0.05f, 16, 32, {static_cast<float>(middle.x()), 0, 0});
  const DistanceOracle oracle(ball);
  SdfBuffers sdf;
  reference::addSdf(sdf, ball, oracle, {.cell = kFieldCell, .friction = 0.5f});
  ClassicFieldRun run(gpu(), asset, sdf);
  for (int step = 0; step < 20; ++step) run.step();
  const std::vector<Float4> positions = run.positions();
  for (const size_t held : {size_t{0}, size_t{1}, size_t{9}, size_t{24 + 9}})
    EXPECT_LT((toVector(positions[held]) - toVector(asset.positions[held])).norm(), 1e-6) << held;
  // Four segments lead out of it.
  for (size_t i = 14; i < 24; ++i)
    EXPECT_GT(oracle.signedDistance(toVector(positions[i])) / kFieldCell, -0.1) << i;
}

INSTANTIATE_TEST_SUITE_P(Apis, StrandField, testing::ValuesIn(kRuntimeApis), apiTestName);

template <class Run>
void expectSameBits(const char* solver) {
  const HairAsset asset = combAsset(3, 20);
  const Log log(Run::kLogX, 0.4f, {0, 0, 5e-4});
  std::vector<Float4> first;
  for (Gpu* gpu : startedGpus()) {
    Run run(*gpu, asset, log.buffers);
    for (int frame = 1; frame <= 30; ++frame) {
      run.setSdfs(log.at({0, 0, 5e-4 * frame}, true));
      run.step();
    }
    const std::vector<Float4> positions = run.positions();
    if (first.empty()) first = positions;
    EXPECT_TRUE(positions == first) << solver << " on " << apiName(gpu->api());
  }
  if (first.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

TEST(StrandFieldBits, AreTheSameOnEveryApi) {
  expectSameBits<RodFieldRun>("exact");
  expectSameBits<ClassicFieldRun>("classic");
}

}  // namespace
}  // namespace pelage::test
