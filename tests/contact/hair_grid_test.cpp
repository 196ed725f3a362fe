// The grid through which hair touches hair: its kernels on buffers of the tests' own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "support/not_numbers.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kGridSize = 24;      // nodes an axis
constexpr float kGridCell = 0.02f;      // [m]
constexpr float kGridMaxSpeed = 16;     // [m/s]
constexpr float kGridStep = 1.0f / 60;  // [s]

/// Vertices with masses and velocities, without strands between them.
struct Cloud {
  std::vector<Float4> positions, before;
};

Cloud randomCloud(uint32_t count, uint64_t seed = 1) {
  Cloud cloud;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const Vector3d p = Vector3d(0.23, 0.23, 0.23) + random.vector(0.08);
    const Vector3d v = random.vector(1.5);
    cloud.positions.push_back(toFloat4(p));
    cloud.before.push_back(
        toFloat4(p - v * static_cast<double>(kGridStep), random.between(0.005, 0.02)));
  }
  return cloud;
}

double massOf(const Cloud& cloud) {
  double mass = 0;
  for (const Float4& v : cloud.before) mass += static_cast<double>(v.w);
  return mass;
}

Vector3d velocityOf(const Cloud& cloud, size_t i) {
  return (toVector(cloud.positions[i]) - toVector(cloud.before[i])) /
         static_cast<double>(kGridStep);
}

struct Node {
  double mass = 0;  // [m]
  Vector3d momentum = {0, 0, 0};
};

class GridRun {
 public:
  GridRun(Gpu& gpu, const Cloud& cloud, float rest = 0)
      : gpu_(gpu),
        count_(static_cast<uint32_t>(cloud.positions.size())),
        positions_(gpu, "gridPositions", cloud.positions),
        before_(gpu, "gridBefore", cloud.before),
        rest_(gpu, "gridRest", std::vector<float>(count_, rest)),
        nodes_(gpu, "gridNodes",
               std::vector<uint32_t>(4 * kGridSize * kGridSize * kGridSize, 0xabcdefu)),
        forces_(gpu, "gridForces", std::vector<Float4>(count_, {1, 2, 3, 4})),
        others_(gpu, "otherForces", std::vector<Float4>(count_, {10, 20, 30, 40})) {
    constants.gridOrigin = {0, 0, 0, kGridCell};
    constants.gridVelocity = {0, 0, 0, kGridMaxSpeed};
    constants.massScale =
        static_cast<float>(std::exp2(std::floor(std::log2(0x1p31 / massOf(cloud)))));
    constants.momentumScale = constants.massScale / (2 * kGridMaxSpeed);
    constants.pressure = 1;
    constants.frictionRate = 30;
    constants.lookAhead = 0;
    constants.inverseStep = 60;
    constants.gridSize = kGridSize;
    constants.gridVertexCount = count_;
    expectOk(gpu.device()->update(gpu.resources));
  }

  HairGridConstants constants = {};

  void splat(bool friction = true) {
    const uint32_t channels = friction ? 4 : 1;
    constants.gridFriction = friction ? 1 : 0;
    pass(clearHairGridVariant({}), kGridSize * kGridSize * kGridSize * channels);
    pass(splatHairGridVariant({}), count_ * 2 * channels);
    run();
  }
  void measure() {
    pass(measureHairGridVariant({}), count_);
    run();
  }
  void apply(bool friction, bool pressure, bool forces = false) {
    constants.gridFriction = friction ? 1 : 0;
    constants.pressure = pressure ? 1 : 0;
    constants.addsForces = forces ? 1 : 0;
    pass(applyHairGridVariant({}), count_);
    run();
  }
  std::vector<uint32_t> words() const { return nodes_.read(); }
  std::vector<Node> nodes() const {
    const std::vector<uint32_t> raw = nodes_.read();
    std::vector<Node> nodes(raw.size() / 4);
    for (size_t i = 0; i < nodes.size(); ++i) {
      nodes[i].mass = raw[4 * i] / static_cast<double>(constants.massScale);
      for (int axis = 0; axis < 3; ++axis)
        nodes[i].momentum[axis] = static_cast<int32_t>(raw[4 * i + 1 + static_cast<size_t>(axis)]) /
                                  static_cast<double>(constants.momentumScale);
    }
    return nodes;
  }
  std::vector<Float4> forces() const { return forces_.read(); }
  std::vector<Float4> before() const { return before_.read(); }
  std::vector<float> rest() const { return rest_.read(); }

 private:
  void pass(const KernelVariant& variant, uint32_t threadsX, uint32_t threadsY = 1) {
    PassBuilder builder(list_);
    builder.dispatch(variant, threadsX, threadsY);
    positions_.bindTo(builder, "g_gridPositions");
    before_.bindTo(builder, "g_gridBefore");
    rest_.bindTo(builder, "g_gridRest");
    nodes_.bindTo(builder, "g_gridNodes");
    forces_.bindTo(builder, "g_gridForces");
    others_.bindTo(builder, "g_otherForces");
    builder.constants("HairGridConstants", constants);
    expectOk(builder.finish());
  }
  void run() { gpu_.execute(list_); }

  Gpu& gpu_;
  uint32_t count_;
  PassList list_;
  GuardedBuffer<Float4> positions_, before_;
  GuardedBuffer<float> rest_;
  GuardedBuffer<uint32_t> nodes_;
  GuardedBuffer<Float4> forces_, others_;
};

class HairGrid : public GpuTest {};

TEST_P(HairGrid, NodesHaveTheMassAndTheMomentumOfTheVertices) {
  const Cloud cloud = randomCloud(700);
  GridRun run(gpu(), cloud);
  run.splat();
  Node sum, expected;
  for (const Node& node : run.nodes()) {
    sum.mass += node.mass;
    sum.momentum += node.momentum;
  }
  for (size_t i = 0; i < cloud.positions.size(); ++i) {
    const double mass = static_cast<double>(cloud.before[i].w);
    expected.mass += mass;
    expected.momentum += velocityOf(cloud, i) * mass;
  }
  // Half a quantum for each of 8 corners, and the float's own rounding.
  const double quanta = 4 * 700;
  EXPECT_NEAR(sum.mass, expected.mass,
              quanta / static_cast<double>(run.constants.massScale) + 1e-6 * expected.mass);
  EXPECT_LT((sum.momentum - expected.momentum).norm(),
            2 * quanta / static_cast<double>(run.constants.momentumScale) + 1e-5 * expected.mass);
}

TEST_P(HairGrid, AVertexGoesToTheEightNodesAroundIt) {
  // A quarter of the way in x, on the nodes in y, half-way in z.
  Cloud cloud;
  cloud.positions = {{5.25f * kGridCell, 7 * kGridCell, 9.5f * kGridCell, 0}};
  cloud.before = cloud.positions;
  cloud.before[0].w = 0.25f;
  GridRun run(gpu(), cloud);
  run.splat();
  const std::vector<Node> nodes = run.nodes();
  const auto at = [&](size_t x, size_t y, size_t z) {
    return nodes[(z * kGridSize + y) * kGridSize + x].mass;
  };
  EXPECT_NEAR(at(5, 7, 9), 0.25 * 0.75 * 0.5, 1e-6);
  EXPECT_NEAR(at(6, 7, 10), 0.25 * 0.25 * 0.5, 1e-6);
  EXPECT_NEAR(at(5, 8, 9), 0, 1e-6);
}

TEST_P(HairGrid, NoSumOverflowsWhenAllHairIsInOnePlaceAtFullSpeed) {
  Cloud cloud;
  for (int i = 0; i < 3000; ++i) {
    cloud.positions.push_back({10 * kGridCell, 10 * kGridCell, 10 * kGridCell, 0});
    // Twice the limit, which the kernel brings down to it.
    cloud.before.push_back(
        {10 * kGridCell + 2 * kGridMaxSpeed * kGridStep, 10 * kGridCell, 10 * kGridCell, 0.01f});
  }
  GridRun run(gpu(), cloud);
  run.splat();
  const Node node = run.nodes()[(10 * kGridSize + 10) * kGridSize + 10];
  EXPECT_NEAR(node.mass, massOf(cloud), 1e-4 * massOf(cloud));
  EXPECT_NEAR(node.momentum.x(), -static_cast<double>(kGridMaxSpeed) * massOf(cloud),
              1e-3 * massOf(cloud));
}

TEST_P(HairGrid, VerticesThatAreNotFiniteOrOutsideAddNothingAndFeelNothing) {
  Cloud cloud = randomCloud(64);
  Cloud bad = cloud;
  const auto add = [&](Float4 position, Float4 before) {
    bad.positions.push_back(position);
    bad.before.push_back(before);
  };
  add({kNan, 0.2f, 0.2f, 0}, {0.2f, 0.2f, 0.2f, 0.01f});
  add({0.2f, kInf, 0.2f, 0}, {0.2f, 0.2f, 0.2f, 0.01f});
  add({0.2f, 0.2f, 0.2f, 0}, {0.2f, kNan, 0.2f, 0.01f});
  add({0.2f, 0.2f, 0.2f, 0}, {0.2f, 0.2f, 0.2f, kNan});
  add({0.2f, 0.2f, 0.2f, 0}, {0.2f, 0.2f, 0.2f, 0});  // without mass
  add({-0.01f, 0.2f, 0.2f, 0}, {-0.01f, 0.2f, 0.2f, 0.01f});
  add({0.2f, 0.2f, 1e15f, 0}, {0.2f, 0.2f, 1e15f, 0.01f});
  // Less than a cell behind the last node of each axis.
  const float behind = (static_cast<float>(kGridSize) - 0.6f) * kGridCell;
  add({behind, 0.2f, 0.2f, 0}, {behind, 0.2f, 0.2f, 0.01f});
  add({0.2f, behind, 0.2f, 0}, {0.2f, behind, 0.2f, 0.01f});
  add({0.2f, 0.2f, behind, 0}, {0.2f, 0.2f, behind, 0.01f});
  GridRun good(gpu(), cloud), run(gpu(), bad);
  run.constants.massScale = good.constants.massScale;
  run.constants.momentumScale = good.constants.momentumScale;
  good.splat();
  run.splat();
  EXPECT_EQ(run.words(), good.words());
  run.apply(true, true);
  const std::vector<Float4> forces = run.forces();
  for (size_t i = 0; i < forces.size(); ++i) {
    EXPECT_TRUE(isFinite(forces[i])) << i;
    if (i >= cloud.positions.size()) {
      EXPECT_EQ(forces[i], (Float4{0, 0, 0, 0})) << i;
    }
  }
}

TEST_P(HairGrid, RestDensityIsTheLargestThatWasMeasured) {
  Cloud cloud;
  cloud.positions = {{5.5f * kGridCell, 7 * kGridCell, 9 * kGridCell, 0}};
  cloud.before = cloud.positions;
  cloud.before[0].w = 0.25f;
  GridRun run(gpu(), cloud);
  run.splat(false);
  run.measure();
  // Half of it on two nodes each, seen with weight 1/2.
  const float all = 0.25f * run.constants.massScale;
  EXPECT_NEAR(run.rest()[0] / all, 0.5f, 1e-5f);
  for (const float shift : {0.5f, 0.25f}) {
    run.constants.gridOrigin.x = shift * kGridCell;
    run.splat(false);
    run.measure();
    EXPECT_NEAR(run.rest()[0] / all, 1.0f, 1e-5f);
  }
}

TEST_P(HairGrid, PressurePointsFromDenseToThinAndNeedsMoreThanRestDensity) {
  // A ball that gets denser towards its middle, at rest.
  Cloud cloud;
  Random random(3);
  const Vector3d middle(0.23, 0.23, 0.23);
  for (int i = 0; i < 4000; ++i) {
    const double r = 0.1 * random.unit();
    const Vector3d p = middle + r * random.vector(1).normalized();
    cloud.positions.push_back(toFloat4(p));
    cloud.before.push_back(toFloat4(p, 0.01));
  }
  GridRun run(gpu(), cloud, 1.0f);
  run.splat(false);
  run.apply(false, true);
  const std::vector<Float4> forces = run.forces();
  double outwards = 0, size = 0;
  for (size_t i = 0; i < forces.size(); ++i) {
    const Vector3d away = toVector(cloud.positions[i]) - middle;
    outwards += toVector(forces[i]).dot(away.normalized());
    size += toVector(forces[i]).norm();
    EXPECT_EQ(forces[i].w, 0);
    EXPECT_LE(toVector(forces[i]).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(),
              2.001 / static_cast<double>(kGridCell));
  }
  EXPECT_GT(outwards, 0.8 * size);
  EXPECT_GT(size / static_cast<double>(forces.size()), 1) << "[m/s2]";

  GridRun loose(gpu(), cloud, 4e9f);
  loose.splat(false);
  loose.apply(false, true);
  for (const Float4& force : loose.forces()) EXPECT_EQ(force, (Float4{0, 0, 0, 0}));
}

TEST_P(HairGrid, FrictionKeepsMomentumAndTakesEnergy) {
  Cloud cloud = randomCloud(900, 7);
  double first = 0, last = 0;
  for (int step = 0; step < 6; ++step) {
    GridRun run(gpu(), cloud);
    run.splat();
    run.apply(true, false);
    const std::vector<Float4> forces = run.forces();
    Vector3d push = {0, 0, 0}, mean = {0, 0, 0};
    double pushed = 0, energy = 0;
    for (size_t i = 0; i < forces.size(); ++i)
      mean += velocityOf(cloud, i) * static_cast<double>(cloud.before[i].w) / massOf(cloud);
    for (size_t i = 0; i < forces.size(); ++i) {
      const double mass = static_cast<double>(cloud.before[i].w);
      push += toVector(forces[i]) * mass;
      pushed += toVector(forces[i]).norm() * mass;
      energy += (velocityOf(cloud, i) - mean).squaredNorm() * mass;
    }
    EXPECT_LT(push.norm(), 1e-5 * pushed + 1e-7);
    if (step == 0) first = energy;
    if (step > 0) {
      EXPECT_LT(energy, last);
    }
    last = energy;
    // The same places with the new velocities.
    for (size_t i = 0; i < forces.size(); ++i) {
      const Vector3d v =
          velocityOf(cloud, i) + toVector(forces[i]) * static_cast<double>(kGridStep);
      const Vector3d before = toVector(cloud.positions[i]) - v * static_cast<double>(kGridStep);
      cloud.before[i] = toFloat4(before, static_cast<double>(cloud.before[i].w));
    }
  }
  EXPECT_LT(last, 0.1 * first) << "half of the velocity in a step, but for what is left in a cell";
}

TEST_P(HairGrid, HairThatMovesAsOneFeelsNoFriction) {
  Cloud cloud = randomCloud(500, 9);
  for (size_t i = 0; i < cloud.positions.size(); ++i) {
    const float mass = cloud.before[i].w;
    cloud.before[i] = cloud.positions[i];
    cloud.before[i].x -= 3 * kGridStep;
    cloud.before[i].w = mass;
  }
  GridRun run(gpu(), cloud);
  run.constants.gridVelocity.x = 2.5f;
  run.splat();
  run.apply(true, false);
  for (const Float4& force : run.forces())
    EXPECT_LT(toVector(force).norm(), 0.02) << "[m/s2]; of 0.5 m/s taken away in 1/30 s";
}

TEST_P(HairGrid, ForcesOfOthersAreAdded) {
  const Cloud cloud = randomCloud(100, 11);
  GridRun alone(gpu(), cloud), together(gpu(), cloud);
  alone.splat();
  alone.apply(true, true);
  together.splat();
  together.apply(true, true, true);
  const std::vector<Float4> a = alone.forces(), b = together.forces();
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(b[i].x, a[i].x + 10);
    EXPECT_EQ(b[i].z, a[i].z + 30);
    EXPECT_EQ(b[i].w, 40);
  }
}

TEST_P(HairGrid, RemembersThePositionsAndKeepsTheMasses) {
  const Cloud cloud = randomCloud(100, 13);
  GridRun run(gpu(), cloud);
  run.splat();
  run.apply(true, true);
  const std::vector<Float4> before = run.before();
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(toVector(before[i]), toVector(cloud.positions[i]));
    EXPECT_EQ(before[i].w, cloud.before[i].w);
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, HairGrid, testing::ValuesIn(kApis), apiTestName);

TEST(HairGridBits, AreTheSameOnEveryApiAndForEveryOrder) {
  const Cloud cloud = randomCloud(2000, 17);
  std::vector<size_t> order(cloud.positions.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<uint32_t> words;
  std::vector<Float4> forces;
  int runs = 0;
  for (Gpu* gpu : startedGpus()) {
    for (int rotation = 0; rotation < 2; ++rotation) {
      Cloud shuffled;
      for (const size_t i : order) {
        shuffled.positions.push_back(cloud.positions[i]);
        shuffled.before.push_back(cloud.before[i]);
      }
      GridRun run(*gpu, shuffled, 1.0f);
      run.splat();
      run.apply(true, true);
      std::vector<Float4> sorted(order.size());
      const std::vector<Float4> raw = run.forces();
      for (size_t i = 0; i < order.size(); ++i) sorted[order[i]] = raw[i];
      if (runs++ == 0) {
        words = run.words();
        forces = sorted;
      }
      EXPECT_TRUE(run.words() == words) << apiName(gpu->api()) << ", order " << rotation;
      EXPECT_TRUE(sorted == forces) << apiName(gpu->api()) << ", order " << rotation;
      Random random(5 + static_cast<uint64_t>(rotation));
      for (size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1], order[static_cast<size_t>(random.unit() * static_cast<double>(i))]);
    }
  }
  if (runs == 0) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

}  // namespace
}  // namespace pelage::test
