// Contacts of both solvers with signed distance fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "reference/sdf/sdf_builder.h"
#include "simulation/exact_solver.h"
#include "support/extremes.h"
#include "support/required_devices.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using reference::DistanceOracle;
using reference::FieldOptions;
using reference::Pose;
using reference::SdfBuffers;
using reference::TriangleMesh;

constexpr float kStep = 1.0f / 60;

/// simulate_exact on buffers of its own; the roots stay in the bind pose.
class RodFieldRun {
 public:
  /// Where the log lies: far enough from the roots that these do not hold what lies on it.
  static constexpr float kLogX = 0.1f;
  RodFieldRun(Gpu& gpu, const HairAsset& asset, const SdfBuffers& sdf)
      : gpu_(gpu),
        packed_(detail::packExactStrands(asset, false)),
        strandCount_(static_cast<uint32_t>(packed_.strands.size())),
        positions_(gpu, "positions", std::vector<Float4>(asset.positions.size())),
        tangents_(gpu, "tangents", std::vector<Float4>(asset.positions.size())),
        state_(gpu, "state",
               stateOf(asset, detail::exactStateCount(packed_.stateStride, strandCount_))),
        rest_(gpu, "rest", detail::packExactRest(asset, packed_, {})),
        roots_(gpu, "rootFrames", rootsOf(asset)),
        sleep_(gpu, "sleep", std::vector<uint32_t>(12 + 3 * size_t{strandCount_} + 64)),
        contacts_(gpu, contactStrands(packed_), asset.verticesPerStrand, asset.positions.size()) {
    setSdfs(sdf);
    constants_.strandCount = strandCount_;
    constants_.simulatedCount = constants_.fadeStart = strandCount_;
    constants_.stateStride = constants_.strandRecords = packed_.stateStride;
    constants_.rootCount = strandCount_;
    constants_.outputCount = static_cast<uint32_t>(asset.positions.size());
    constants_.outputVertices = asset.verticesPerStrand;
    constants_.frameTime = constants_.frameTimeBefore = kStep;
    const detail::HairContacts& contacts = contacts_.contacts();
    constants_.contactHead = contacts.head(0);
    constants_.contactList = contacts.list();
    constants_.contactMasks = contacts.masks();
    constants_.contactMaskWords = contacts.maskWords();
    constants_.flags = 1;
    settings_.damping = 0.06f;
    expectOk(gpu.device()->update(gpu.resources));
  }

  void setSdfs(const SdfBuffers& sdf) { contacts_.setSdfs(list_, sdf.sdfs, sdf.keys, sdf.surface); }
  void setGravity(const Vector3d& g) {
    settings_.gravity = {static_cast<float>(g.x()), static_cast<float>(g.y()),
                         static_cast<float>(g.z())};
  }
  void step() {
    detail::setExactStep(constants_, settings_, double{kStep}, history_, {});
    constants_.rootBegin = 0;
    constants_.rootEnd = 1;
    constants_.flags |= 2;
    if (constants_.rotationRatio != 1) constants_.flags |= 32;
    contacts_.begin(list_);
    // As scenes do: the pose of a reset, contacts, the step, and again where a vertex ended far
    // from where its contact was found.
    if ((constants_.flags & 1) != 0) solve(kPose);
    find(false);
    solve(0);
    find(true);
    constants_.flags &= ~1u;
    solve(kAgain);
    gpu_.hazards.resolve(list_);
    expectOk(gpu_.device()->execute(list_));
    list_.clear();
    constants_.slot = (constants_.slot + 1) % 4;
    constants_.flags = 0;
  }
  std::vector<Float4> positions() const { return positions_.read(); }

 private:
  // Bits of ExactConstants::flags.
  static constexpr uint32_t kAgain = 128, kPose = 256;

  static std::vector<ContactStrand> contactStrands(const detail::ExactStrands& packed) {
    std::vector<ContactStrand> strands;
    for (const ExactStrand& s : packed.strands)
      strands.push_back({.target = s.target, .count = s.count, .root = s.root, .pad0 = 0});
    return strands;
  }
  void find(bool again) {
    const Float3 g = settings_.gravity;
    contacts_.find(list_,
                   {.positions = positions_.id(),
                    .roots = gpu_.resources.whole(roots_.id()),
                    .rootCount = strandCount_,
                    .strands = strandCount_,
                    .origin = {}},
                   {.length = kStep, .gravity = g, .again = again});
  }
  void solve(uint32_t flags) {
    ExactConstants constants = constants_;
    constants.flags |= flags;
    const KernelVariant& variant =
        *simulateExactVariant({.contacts = true, .velocityShockPropagation = true});
    PassBuilder builder(list_);
    if ((flags & kAgain) != 0)
      builder.dispatchIndirect(variant, contacts_.contacts().words(),
                               contacts_.contacts().solveArguments(0));
    else
      builder.dispatch(variant, strandCount_);
    positions_.bindTo(builder, "g_positions");
    tangents_.bindTo(builder, "g_tangents");
    state_.bindTo(builder, "g_state");
    rest_.bindTo(builder, "g_rest");
    sleep_.bindTo(builder, "g_sleep");
    contacts_.bindTo(builder);
    builder.constants("ExactConstants", constants);
    expectOk(builder.finish());
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
  detail::ExactStrands packed_;
  uint32_t strandCount_;
  PassList list_;
  ExactConstants constants_ = {};
  SimulationSettings settings_;
  detail::ExactHistory history_;
  GuardedBuffer<Float4> positions_, tangents_, state_, rest_, roots_;
  GuardedBuffer<uint32_t> sleep_;
  ContactPass contacts_;
};

/// The same for simulate_classic.
class ClassicFieldRun {
 public:
  /// Under the roots: without stiffness the strands would slide in between.
  static constexpr float kLogX = 0.02f;
  ClassicFieldRun(Gpu& gpu, const HairAsset& asset, const SdfBuffers& sdf) : run_(gpu, asset) {
    std::vector<Pose> roots;
    for (uint32_t s = 0; s < asset.strandCount; ++s) roots.push_back(bindPose(asset, s));
    run_.reset(roots);
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

/// Strands of 0.3 m along x, beside each other along z, with roots at the origin and there.
HairAsset combAsset(uint32_t strands, uint32_t vertices, const std::vector<uint32_t>& held = {}) {
  HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  for (uint32_t s = 0; s < strands; ++s)
    for (uint32_t v = 0; v < vertices; ++v) {
      const bool fixed = v < 2 || std::find(held.begin(), held.end(), v) != held.end();
      asset.positions.push_back(
          toFloat4(Vector3d(0.3 * v / (vertices - 1), 0, 0.01 * s), fixed ? 0 : 1));
    }
  expectOk(asset.process());
  return asset;
}

double worstStretch(const HairAsset& asset, const std::vector<Float4>& positions) {
  double worst = 0;
  for (size_t i = 1; i < positions.size(); ++i) {
    if (i % asset.verticesPerStrand < 2) continue;
    const double rest = double{asset.restLengths[i - 1]};
    const double length = (toVector(positions[i]) - toVector(positions[i - 1])).norm();
    if (!std::isfinite(length)) return std::numeric_limits<double>::infinity();
    keepLargest(worst, std::abs(length - rest) / rest);
  }
  return worst;
}

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

constexpr double kCell = 0.01;

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
    before = mesh.positions;
    for (Float3& p : before) {
      p.x -= static_cast<float>(displacement.x());
      p.y -= static_cast<float>(displacement.y());
      p.z -= static_cast<float>(displacement.z());
    }
    reference::addSdf(buffers, mesh, oracle,
                      {.cell = kCell, .friction = friction, .before = &before});
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
        EXPECT_LT(worstStretch(asset, positions), stretch);
        depth = depthOf(asset, positions, log.oracle, kCell);
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
    EXPECT_LT(depthOf(asset, after, log.oracle, kCell, displacement * 40).deepest, 0.02);
    double taken = 0;
    int count = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      if (i % asset.verticesPerStrand < 2) continue;
      if (log.oracle.signedDistance(toVector(before[i])) > 0.2 * kCell) continue;
      taken += double{after[i].z} - double{before[i].z};
      ++count;
    }
    EXPECT_GT(count, 5);
    std::printf("[ FIGURE ] friction %g: taken along by %g m\n", double{friction}, taken / count);
    return taken / count;
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
    const double frame = double{kStep};
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

TEST_P(StrandField, FrictionHoldsRodsOnALog) {
  const Vector3d leaning(0, -9.81, 0.8);
  const double free = takenAlong<RodFieldRun>(0, {0, 0, 0}, leaning);
  EXPECT_LT(std::abs(takenAlong<RodFieldRun>(0.6f, {0, 0, 0}, leaning)), 0.2 * std::abs(free));
}
TEST_P(StrandField, FrictionHoldsClassicStrandsOnALog) {
  const Vector3d leaning(0, -9.81, 0.8);
  const double free = takenAlong<ClassicFieldRun>(0, {0, 0, 0}, leaning);
  EXPECT_LT(std::abs(takenAlong<ClassicFieldRun>(0.6f, {0, 0, 0}, leaning)), 0.2 * std::abs(free));
}

TEST_P(StrandField, ALogThatMovesTakesRodsAlong) {
  const Vector3d displacement(0, 0, 5e-4), down(0, -9.81, 0);
  const double free = takenAlong<RodFieldRun>(0, displacement, down);
  EXPECT_GT(takenAlong<RodFieldRun>(1.0f, displacement, down), 0.6 * 40 * displacement.z());
  EXPECT_LT(free, 0.3 * 40 * displacement.z());
}
TEST_P(StrandField, ALogThatMovesTakesClassicStrandsAlong) {
  const Vector3d displacement(0, 0, 5e-4), down(0, -9.81, 0);
  const double free = takenAlong<ClassicFieldRun>(0, displacement, down);
  EXPECT_GT(takenAlong<ClassicFieldRun>(1.0f, displacement, down), 0.6 * 40 * displacement.z());
  EXPECT_LT(free, 0.3 * 40 * displacement.z());
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
  HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = 3;
  for (const double z : {1000.0, 500.0, 0.0})
    asset.positions.push_back(toFloat4(Vector3d(0, 0, z), z > 0 ? 0 : 1));
  expectOk(asset.process());
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
                          std::pow(double{kStep}, 2) * steps * (steps + 1) / 2;
  EXPECT_NEAR(slideOnSlab(gpu(), 25, 0.3f, steps), expected, 0.02 * expected);
}

TEST_P(StrandField, HeldVerticesStayWhereTheyAre) {
  // Vertex 9 is in the middle of the ball.
  const HairAsset asset = combAsset(2, 24, {9});
  const Vector3d middle = toVector(asset.positions[9]);
  const TriangleMesh ball =
      reference::sphere(0.05f, 16, 32, {static_cast<float>(middle.x()), 0, 0});
  const DistanceOracle oracle(ball);
  SdfBuffers sdf;
  reference::addSdf(sdf, ball, oracle, {.cell = kCell, .friction = 0.5f});
  ClassicFieldRun run(gpu(), asset, sdf);
  for (int step = 0; step < 20; ++step) run.step();
  const std::vector<Float4> positions = run.positions();
  for (const size_t held : {size_t{0}, size_t{1}, size_t{9}, size_t{24 + 9}})
    EXPECT_LT((toVector(positions[held]) - toVector(asset.positions[held])).norm(), 1e-6) << held;
  // Four segments lead out of it.
  for (size_t i = 14; i < 24; ++i)
    EXPECT_GT(oracle.signedDistance(toVector(positions[i])) / kCell, -0.1) << i;
}

INSTANTIATE_TEST_SUITE_P(Apis, StrandField, testing::ValuesIn(kApis), apiTestName);

template <class Run>
void expectSameBits(const char* solver) {
  const HairAsset asset = combAsset(3, 20);
  const Log log(Run::kLogX, 0.4f, {0, 0, 5e-4});
  std::vector<Float4> first;
  for (const Api api : kApis) {
    Gpu& gpu = Gpu::of(api);
    if (gpu.device() == nullptr) continue;
    Run run(gpu, asset, log.buffers);
    for (int frame = 1; frame <= 30; ++frame) {
      run.setSdfs(log.at({0, 0, 5e-4 * frame}, true));
      run.step();
    }
    const std::vector<Float4> positions = run.positions();
    if (first.empty()) first = positions;
    EXPECT_TRUE(positions == first) << solver << " on " << apiName(api);
  }
  if (first.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

TEST(StrandFieldBits, AreTheSameOnEveryApi) {
  expectSameBits<RodFieldRun>("exact");
  expectSameBits<ClassicFieldRun>("classic");
}

}  // namespace
}  // namespace pelage::test
