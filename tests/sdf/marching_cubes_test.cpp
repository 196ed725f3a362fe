// Marching cubes on fields that the tests make: closed, on the surface, and nothing but it.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "pelage/view.h"
#include "sdf/iso_surface.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/not_numbers.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kUnset = 0x7fffffffu, kInside = 0x80000000u, kFar = 0x40000000u;
constexpr uint32_t kTriangleBits = 12;
constexpr float kIsoBand = 2, kFarRange = 64;  // [cell]
constexpr float kIsoCell = 0.01f;              // [m]
constexpr uint32_t kKeysBefore = 96;           // of another field, in front of the one at hand

using IsoShape = std::function<double(const Vector3d&)>;  // distance [cell] at a node, < 0 inside

/// Nodes outside the band of the surface.
enum class Depths { kFilled, kLeftUnset };

uint32_t keyFor(double distance, Depths depths) {
  const double most = (1u << (30 - kTriangleBits)) - 1;
  const double size = std::abs(distance);
  const uint32_t side = distance < 0 ? kInside : 0;
  const auto code = [&](double share) {
    return static_cast<uint32_t>(std::min(std::floor(share * most + 0.5), most)) << kTriangleBits;
  };
  if (size <= double{kIsoBand}) return side | code(size / double{kIsoBand}) | 7;
  if (side == 0 || depths == Depths::kLeftUnset) return side | kUnset;
  return side | kFar | code((size - double{kIsoBand}) / double{kFarRange}) | 7;
}

struct IsoField {
  Sdf sdf = {};
  std::vector<uint32_t> keys;
  detail::GridSize nodes = {};
};

IsoField makeSdf(const detail::GridSize& nodes, const IsoShape& shape,
                 Depths depths = Depths::kFilled) {
  IsoField made;
  made.nodes = nodes;
  made.sdf.origin = {0.3f, -0.2f, 0.1f, kIsoCell};
  made.sdf.nodes = {nodes[0], nodes[1], nodes[2], kKeysBefore};
  made.sdf.triangleCount = 1000;
  made.sdf.triangleBits = kTriangleBits;
  made.sdf.band = kIsoBand;
  made.sdf.farRange = kFarRange;
  made.keys.assign(kKeysBefore, kInside);
  for (uint32_t z = 0; z < nodes[2]; ++z)
    for (uint32_t y = 0; y < nodes[1]; ++y)
      for (uint32_t x = 0; x < nodes[0]; ++x)
        made.keys.push_back(keyFor(shape(Vector3d(x, y, z)), depths));
  return made;
}

IsoShape ballShape(const Vector3d& center, double radius) {
  return [=](const Vector3d& p) { return (p - center).norm() - radius; };
}

const Vector3d kTorusCenter(20.3, 20.6, 10.2);
double torusShape(const Vector3d& p) {
  const Vector3d d = p - kTorusCenter;
  return std::hypot(std::hypot(d.x(), d.y()) - 12.2, d.z()) - 5.1;
}

/// A mesh in cells from node 0.
struct Mesh {
  std::vector<Vector3d> positions, normals;
  std::vector<uint32_t> indices;
  MarchingCounts counts;
};

class MarchingRun {
 public:
  MarchingRun(Gpu& gpu, const IsoField& sdf, uint32_t vertices = 20000, uint32_t triangles = 40000)
      : gpu_(gpu),
        nodes_(sdf.nodes),
        fields_(gpu, "fields", std::vector<Sdf>{Sdf{}, sdf.sdf}),
        keys_(gpu, "keys", sdf.keys),
        rows_(gpu, "isoRows",
              std::vector<Uint2>(size_t{sdf.nodes[1]} * sdf.nodes[2] + 1, {77, 88})),
        words_(gpu, "isoNodes",
               std::vector<uint32_t>(sdf.keys.size() - kKeysBefore + 1, 0xdeadbeefu)),
        counts_(gpu, "isoCounts", std::vector<MarchingCounts>(1, {9, 9, 9, 9})),
        vertices_(gpu, "isoVertices", std::vector<IsoVertex>(vertices)),
        indices_(gpu, "isoIndices", std::vector<uint32_t>(size_t{triangles} * 3, 12345)) {
    constants.marchingSdf = 1;
    constants.vertexCapacity = vertices;
    constants.triangleCapacity = triangles;
    constants.rowCapacity = sdf.nodes[1] * sdf.nodes[2];
    constants.nodeCapacity = static_cast<uint32_t>(sdf.keys.size()) - kKeysBefore;
    constants.sdfCapacity = 2;
    constants.keyCapacity = static_cast<uint32_t>(sdf.keys.size());
    origin_ = toVector(sdf.sdf.origin);
    expectOk(gpu.device()->update(gpu.resources));
  }

  MarchingCubesConstants constants = {};

  /// Threads along the axes of the passes that have one a node.
  void setThreads(const detail::GridSize& threads) { nodes_ = threads; }
  void setKeys(const std::vector<uint32_t>& keys) { keys_.upload(list_, keys); }

  Mesh run(float isoLevel = 0) {
    constants.isoLevel = isoLevel;
    pass(marchingCubesCountVariant({}), 64, nodes_[1], nodes_[2]);
    pass(marchingCubesOffsetsVariant({}), 1, 1, 1);
    pass(marchingCubesEmitVariant({}), nodes_[0], nodes_[1], nodes_[2]);
    pass(marchingCubesPadVariant({}), constants.triangleCapacity, 1, 1);
    gpu_.execute(list_);
    rows_.read();
    words_.read();
    Mesh mesh;
    mesh.counts = counts_.read()[0];
    mesh.indices = indices_.read();
    raw = vertices_.read();
    for (const IsoVertex& v : raw) {
      mesh.positions.push_back((toVector(v.position) - origin_) / double{kIsoCell});
      mesh.normals.push_back(toVector(v.normal));
    }
    const size_t vertices = std::min<size_t>(mesh.counts.vertices, mesh.positions.size());
    mesh.positions.resize(vertices);
    mesh.normals.resize(vertices);
    // Behind the last triangle there is nothing to draw.
    const size_t used = std::min<size_t>(size_t{mesh.counts.triangles} * 3, mesh.indices.size());
    EXPECT_TRUE(std::all_of(mesh.indices.begin() + static_cast<ptrdiff_t>(used), mesh.indices.end(),
                            [](uint32_t i) { return i == 0; }));
    mesh.indices.resize(used);
    return mesh;
  }

  std::vector<IsoVertex> raw;

 private:
  void pass(const KernelVariant& variant, uint32_t x, uint32_t y, uint32_t z) {
    PassBuilder builder(list_);
    builder.dispatch(variant, x, y, z);
    fields_.bindTo(builder, "g_marchingSdfs");
    keys_.bindTo(builder, "g_marchingKeys");
    rows_.bindTo(builder, "g_isoRows");
    words_.bindTo(builder, "g_isoNodes");
    counts_.bindTo(builder, "g_isoCounts");
    vertices_.bindTo(builder, "g_isoVertices");
    indices_.bindTo(builder, "g_isoIndices");
    builder.constants("MarchingCubesConstants", constants);
    expectOk(builder.finish());
  }

  Gpu& gpu_;
  detail::GridSize nodes_;
  Vector3d origin_;
  PassList list_;
  GuardedBuffer<Sdf> fields_;
  GuardedBuffer<uint32_t> keys_;
  GuardedBuffer<Uint2> rows_;
  GuardedBuffer<uint32_t> words_;
  GuardedBuffer<MarchingCounts> counts_;
  GuardedBuffer<IsoVertex> vertices_;
  GuardedBuffer<uint32_t> indices_;
};

/// Directed edges that do not have exactly one triangle, or whose opposite does not; without those
/// for which `open` is true of both ends.
int looseEdges(const Mesh& mesh, const std::function<bool(const Vector3d&)>& open = nullptr) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (size_t i = 0; i < mesh.indices.size(); i += 3)
    for (size_t k = 0; k < 3; ++k) ++edges[{mesh.indices[i + k], mesh.indices[i + (k + 1) % 3]}];
  int loose = 0;
  for (const auto& [edge, count] : edges) {
    const auto [a, b] = edge;
    const auto opposite = edges.find({b, a});
    if (count == 1 && a != b && opposite != edges.end() && opposite->second == 1) continue;
    if (open && count == 1 && opposite == edges.end() && open(mesh.positions[a]) &&
        open(mesh.positions[b]))
      continue;
    ++loose;
  }
  return loose;
}

/// Vertices - edges + triangles; every vertex has a triangle.
int eulerCharacteristic(const Mesh& mesh) {
  std::set<uint32_t> used(mesh.indices.begin(), mesh.indices.end());
  EXPECT_EQ(used.size(), mesh.positions.size()) << "vertices without a triangle";
  return static_cast<int>(mesh.positions.size()) - static_cast<int>(mesh.indices.size() / 2) +
         static_cast<int>(mesh.indices.size() / 3);
}

/// One surface without holes.
void expectClosed(const Mesh& mesh) {
  EXPECT_EQ(looseEdges(mesh), 0);
  EXPECT_EQ(eulerCharacteristic(mesh), 2);
}

void expectEmpty(const Mesh& mesh) {
  EXPECT_EQ(mesh.counts.vertices, 0u);
  EXPECT_EQ(mesh.counts.triangles, 0u);
}

/// Number of edges between neighbouring nodes on both sides of a level, from the keys.
uint32_t crossingsOf(const IsoField& sdf, double isoLevel) {
  const double most = (1u << (30 - kTriangleBits)) - 1;
  const auto& n = sdf.nodes;
  const auto below = [&](uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t key = sdf.keys[kKeysBefore + x + n[0] * (y + n[1] * z)];
    double d = double{kIsoBand};
    if ((key & kUnset) != kUnset) {
      const double share = ((key & (kFar - 1)) >> kTriangleBits) / most;
      d = (key & kFar) != 0 ? double{kIsoBand} + share * double{kFarRange}
                            : share * double{kIsoBand};
    }
    return ((key & kInside) != 0 ? -d : d) < isoLevel;
  };
  uint32_t count = 0;
  for (uint32_t z = 0; z < n[2]; ++z)
    for (uint32_t y = 0; y < n[1]; ++y)
      for (uint32_t x = 0; x < n[0]; ++x) {
        if (x + 1 < n[0] && below(x, y, z) != below(x + 1, y, z)) ++count;
        if (y + 1 < n[1] && below(x, y, z) != below(x, y + 1, z)) ++count;
        if (z + 1 < n[2] && below(x, y, z) != below(x, y, z + 1)) ++count;
      }
  return count;
}

double degrees(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// On the surface of a shape at a level, with its normals, and the right way around.
void expectOnSurface(const Mesh& mesh, const IsoShape& shape, double level, double cells,
                     double mostDegrees) {
  double worst = 0, worstNormal = 0;
  const auto slope = [&](const Vector3d& p) {
    Vector3d g;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = Vector3d::Unit(axis) * 1e-4;
      g[axis] = shape(p + step) - shape(p - step);
    }
    return Vector3d(g.normalized());
  };
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    keepLargest(worst, std::abs(shape(mesh.positions[i]) - level));
    keepLargest(worstNormal, degrees(slope(mesh.positions[i]).dot(mesh.normals[i])));
    EXPECT_NEAR(mesh.normals[i].norm(), 1, 1e-5);
  }
  EXPECT_LT(worst, cells);
  EXPECT_LT(worstNormal, mostDegrees);
  int wrong = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vector3d a = mesh.positions[mesh.indices[i]];
    const Vector3d b = mesh.positions[mesh.indices[i + 1]];
    const Vector3d c = mesh.positions[mesh.indices[i + 2]];
    const Vector3d area = (b - a).cross(c - a);
    if (area.norm() > 1e-4 && area.dot(slope((a + b + c) / 3)) <= 0) ++wrong;
  }
  EXPECT_EQ(wrong, 0) << "triangles that face inwards";
}

/// Level whose sign at the nodes is random, with nothing inside at the grid's border.
IsoField noiseSdf(uint64_t seed) {
  Random random(seed);
  return makeSdf({24, 22, 20}, [&](const Vector3d& p) {
    const bool border = p.minCoeff() < 1 || p.x() > 22 || p.y() > 20 || p.z() > 18;
    const double size = random.between(0.01, 1.5);
    return border || random.unit() < 0.5 ? size : -size;
  });
}

IsoField ballField() { return makeSdf({28, 26, 25}, ballShape({13.3, 12.6, 12.1}, 9.4)); }

class MarchingCubes : public GpuTest {};

TEST_P(MarchingCubes, AreASphereThatIsClosedAndOnTheSurface) {
  const IsoShape shape = ballShape({13.3, 12.6, 12.1}, 9.4);
  const IsoField sdf = makeSdf({28, 26, 25}, shape);
  const Mesh mesh = MarchingRun(gpu(), sdf).run();
  EXPECT_EQ(mesh.counts.overflow, 0u);
  EXPECT_EQ(mesh.counts.vertices, crossingsOf(sdf, 0)) << "one vertex on each crossed edge";
  expectClosed(mesh);
  expectOnSurface(mesh, shape, 0, 0.05, 0.5);
}

TEST_P(MarchingCubes, FollowTheLevelOnBothSides) {
  const IsoShape shape = ballShape({13.3, 12.6, 12.1}, 8.4);
  const IsoField sdf = makeSdf({28, 26, 25}, shape);
  MarchingRun run(gpu(), sdf);
  for (const float level : {-0.5f, 0.5f, -1.0f, 1.0f, -1.5f}) {
    const Mesh mesh = run.run(level);
    EXPECT_EQ(mesh.counts.vertices, crossingsOf(sdf, double{level}));
    expectClosed(mesh);
    expectOnSurface(mesh, shape, double{level}, 0.05, 1);
  }
  // Here some edges end where the build did not reach.
  expectOnSurface(run.run(1.5f), shape, 1.5, 0.1, 4);
}

TEST_P(MarchingCubes, HaveNoShellAtTheEdgeOfTheBand) {  // K33
  const IsoShape shape = ballShape({13.3, 12.6, 12.1}, 9.4);
  MarchingRun filled(gpu(), makeSdf({28, 26, 25}, shape));
  MarchingRun unset(gpu(), makeSdf({28, 26, 25}, shape, Depths::kLeftUnset));
  for (const float level : {0.0f, -0.75f, 0.75f}) {
    const Mesh a = filled.run(level), b = unset.run(level);
    EXPECT_EQ(a.positions, b.positions) << level;
    EXPECT_EQ(a.indices, b.indices) << level;
  }
  // Levels that touch what is unset stay one closed surface, within a cell.
  for (const float level : {-1.9f, 1.9f}) {
    const Mesh mesh = unset.run(level);
    expectClosed(mesh);
    for (const Vector3d& p : mesh.positions) EXPECT_NEAR(shape(p), double{level}, 1);
  }
  for (const float level : {-2.0f, 2.0f, 5.0f, kNan}) {
    const Mesh mesh = unset.run(level);
    expectEmpty(mesh);
  }
}

TEST_P(MarchingCubes, AreClosedInEveryOneOfThe256Cases) {
  for (const uint64_t seed : {1u, 2u}) {
    const IsoField sdf = noiseSdf(seed);
    std::set<uint32_t> cases;
    const auto& n = sdf.nodes;
    for (uint32_t z = 0; z + 1 < n[2]; ++z)
      for (uint32_t y = 0; y + 1 < n[1]; ++y)
        for (uint32_t x = 0; x + 1 < n[0]; ++x) {
          uint32_t bits = 0;
          for (uint32_t c = 0; c < 8; ++c) {
            const size_t node = x + (c & 1) + n[0] * (y + (c >> 1 & 1) + n[1] * (z + (c >> 2)));
            bits |= (sdf.keys[kKeysBefore + node] >> 31) << c;
          }
          cases.insert(bits);
        }
    ASSERT_EQ(cases.size(), 256u);
    const Mesh mesh = MarchingRun(gpu(), sdf).run();
    EXPECT_EQ(mesh.counts.overflow, 0u);
    EXPECT_EQ(mesh.counts.vertices, crossingsOf(sdf, 0));
    EXPECT_EQ(looseEdges(mesh), 0);
    eulerCharacteristic(mesh);
  }
}

TEST_P(MarchingCubes, NumberRowsOfAnyLength) {
  // A row of more than two groups, which the last group does not fill.
  const IsoShape shape = [](const Vector3d& p) {
    const double along = std::clamp(p.x(), 6.2, 131.4);
    return (p - Vector3d(along, 6.3, 6.7)).norm() - 3.4;
  };
  const IsoField sdf = makeSdf({140, 13, 14}, shape);
  const Mesh mesh = MarchingRun(gpu(), sdf).run();
  EXPECT_EQ(mesh.counts.vertices, crossingsOf(sdf, 0));
  expectClosed(mesh);
  expectOnSurface(mesh, shape, 0, 0.06, 12);
}

TEST_P(MarchingCubes, StayOpenWhereTheShapeLeavesTheGrid) {
  const IsoShape shape = ballShape({2, 11, 12}, 8.3);
  const Mesh mesh = MarchingRun(gpu(), makeSdf({16, 26, 25}, shape)).run();
  EXPECT_EQ(looseEdges(mesh, [](const Vector3d& p) { return std::abs(p.x()) < 1e-4; }), 0);
  EXPECT_GT(looseEdges(mesh), 0);
  expectOnSurface(mesh, shape, 0, 0.05, 4);
}

TEST_P(MarchingCubes, TakeNodesThatLieOnTheLevel) {
  // Distances of exactly 0 at many nodes: triangles without area, but no holes and no NaN.
  const IsoShape shape = [](const Vector3d& p) {
    return (p - Vector3d(8, 8, 8)).cwiseAbs().maxCoeff() - 5;
  };
  const Mesh mesh = MarchingRun(gpu(), makeSdf({20, 17, 17}, shape)).run();
  expectClosed(mesh);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_LT(std::abs(shape(mesh.positions[i])), 1e-3);
    EXPECT_NEAR(mesh.normals[i].norm(), 1, 1e-5);
  }
}

TEST_P(MarchingCubes, ReportAnOverflowAndWriteNothingPastTheEnd) {  // K33
  const IsoField sdf = ballField();
  const Mesh whole = MarchingRun(gpu(), sdf).run();
  const uint32_t vertices = whole.counts.vertices, triangles = whole.counts.triangles;
  struct Room {
    uint32_t vertices, triangles, overflow;
  };
  for (const Room& room : {Room{vertices, triangles, 0}, Room{vertices - 1, triangles, 1},
                           Room{vertices, triangles - 1, 2}, Room{100, 90, 3}, Room{1, 1, 3}}) {
    const Mesh mesh = MarchingRun(gpu(), sdf, room.vertices, room.triangles).run();
    EXPECT_EQ(mesh.counts.vertices, vertices);
    EXPECT_EQ(mesh.counts.triangles, triangles);
    EXPECT_EQ(mesh.counts.overflow, room.overflow);
    ASSERT_EQ(mesh.positions.size(), room.vertices);
    ASSERT_EQ(mesh.indices.size(), size_t{room.triangles} * 3);
    EXPECT_TRUE(std::equal(mesh.positions.begin(), mesh.positions.end(), whole.positions.begin()));
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto first = whole.indices.begin() + static_cast<ptrdiff_t>(i);
      const bool fits =
          std::all_of(first, first + 3, [&](uint32_t v) { return v < room.vertices; });
      for (size_t k = 0; k < 3; ++k)
        EXPECT_EQ(mesh.indices[i + k], fits ? whole.indices[i + k] : 0);
    }
  }
}

TEST_P(MarchingCubes, AreNothingForAFieldThatIsNotInsideItsBuffers) {
  const IsoField sdf = ballField();
  const auto refuse = [&](const std::function<void(MarchingCubesConstants&)>& change) {
    MarchingRun run(gpu(), sdf);
    change(run.constants);
    const Mesh mesh = run.run();
    expectEmpty(mesh);
    return mesh.counts.overflow;
  };
  EXPECT_EQ(refuse([](auto& c) { c.nodeCapacity -= 1; }), 4u);
  EXPECT_EQ(refuse([](auto& c) { c.rowCapacity -= 1; }), 4u);
  EXPECT_EQ(refuse([](auto& c) { c.keyCapacity -= 1; }), 4u);
  EXPECT_EQ(refuse([](auto& c) { c.marchingSdf = 2; }), 0u) << "a field that is not there";
  EXPECT_EQ(refuse([](auto& c) { c.marchingSdf = 0; }), 0u) << "a field without nodes";
}

TEST_P(MarchingCubes, AreNothingWhereThereIsNothing) {
  const Mesh none =
      MarchingRun(gpu(), makeSdf({12, 9, 10}, [](const Vector3d&) { return 10.0; })).run();
  expectEmpty(none);
  EXPECT_EQ(none.counts.overflow, 0u);
  const Mesh full =
      MarchingRun(gpu(), makeSdf({12, 9, 10}, [](const Vector3d&) { return -10.0; })).run();
  EXPECT_EQ(full.counts.vertices, 0u) << "the grid's border is no surface";
  // A grid of one layer has edges but no cells.
  const Mesh flat = MarchingRun(gpu(), makeSdf({12, 9, 1}, ballShape({5, 4, 0}, 3))).run();
  expectEmpty(flat);
}

TEST_P(MarchingCubes, TakeMoreThreadsThanThereAreNodes) {
  const IsoField sdf = ballField();
  const Mesh exact = MarchingRun(gpu(), sdf).run();
  MarchingRun run(gpu(), sdf);
  run.setThreads({130, 31, 27});
  const Mesh more = run.run();
  EXPECT_EQ(more.counts.vertices, exact.counts.vertices);
  EXPECT_EQ(more.positions, exact.positions);
  EXPECT_EQ(more.indices, exact.indices);
}

TEST_P(MarchingCubes, LeaveNothingOfTheFrameBefore) {
  const IsoField large = ballField();
  const IsoField small = makeSdf({28, 26, 25}, ballShape({9.3, 9.6, 9.1}, 4.2));
  MarchingRun run(gpu(), large);
  const Mesh first = run.run();
  run.setKeys(small.keys);
  const Mesh second = run.run();
  EXPECT_LT(second.counts.triangles, first.counts.triangles / 2);
  expectClosed(second);
}

INSTANTIATE_TEST_SUITE_P(Apis, MarchingCubes, testing::ValuesIn(kApis), apiTestName);

TEST(MarchingCubesBits, AreTheSameOnEveryApi) {
  const IsoField sdf = makeSdf({44, 42, 21}, torusShape);
  std::vector<IsoVertex> vertices;
  std::vector<uint32_t> indices;
  int runs = 0;
  for (Gpu* gpu : startedGpus()) {
    for (int turn = 0; turn < 2; ++turn) {
      MarchingRun run(*gpu, sdf);
      const Mesh mesh = run.run(0.25f);
      EXPECT_GT(mesh.indices.size(), 3000u);
      if (runs++ == 0) {
        vertices = run.raw;
        indices = mesh.indices;
      }
      EXPECT_EQ(std::memcmp(run.raw.data(), vertices.data(), vertices.size() * sizeof(IsoVertex)),
                0)
          << apiName(gpu->api());
      EXPECT_TRUE(mesh.indices == indices) << apiName(gpu->api());
    }
  }
  if (runs == 0) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

/// The class that a scene uses, and the draw.
class IsoSurfaceDraw : public GpuTest {
 protected:
  static constexpr uint32_t kPixels = 128;

  void SetUp() override {
    GpuTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    field_.sdf.nodes.w = 0;
    field_.keys.erase(field_.keys.begin(), field_.keys.begin() + kKeysBefore);
    keys_.emplace(gpu(), "keys", field_.keys);
  }
  void TearDown() override {
    keys_.reset();
    GpuTest::TearDown();
  }
  void remove(const detail::IsoSurface& surface) {
    for (const BufferId id : surface.buffers()) {
      gpu().hazards.forget(id);
      gpu().resources.remove(id);
    }
  }

  Result<RenderedImage> render(const detail::IsoSurface& surface, const View& view,
                               const Light& light, const detail::IsoSurface::Look& look) {
    expectOk(gpu().device()->update(gpu().resources));
    PassList list;
    expectOk(surface.addPasses(field_.sdf, keys_->id(), static_cast<uint32_t>(field_.keys.size()),
                               0, list));
    expectOk(surface.addDraw(view, light, look, list));
    gpu().hazards.resolve(list);
    RenderTargetDef target;
    target.width = target.height = kPixels;
    return gpu().device()->render(list, target);
  }

  IsoField field_ = makeSdf({28, 26, 25}, ballShape({13, 12, 12}, 9));
  std::optional<GuardedBuffer<uint32_t>> keys_;
};

TEST_P(IsoSurfaceDraw, ShowsTheSurfaceWhereItIsAndSaysWhatItDidNotDraw) {
  auto surface = required(detail::IsoSurface::create(
      gpu().resources, "sphere", field_.nodes, detail::defaultIsoSurfaceCapacity(field_.nodes)));
  View view;
  view.width = view.height = kPixels;
  detail::IsoSurface::Look look;
  look.color = {0, 1, 0};
  // The field's middle is at (0.43, -0.08, 0.22); the map takes it to the origin, turned.
  look.sdfToWorld.rows[0] = {0, -1, 0, -0.08f};
  look.sdfToWorld.rows[1] = {1, 0, 0, -0.43f};
  look.sdfToWorld.rows[2] = {0, 0, 1, -0.22f};
  Light light;
  light.direction = {1, 0, 0};
  for (const float side : {1.0f, -1.0f}) {
    view.eye = {0, 0, side};
    view.worldToClip = lookAt(view.eye, {0, 0, 0}, {0, 1, 0}, 0.3f, 1, 0.1f, 10.0f);
    const auto image = required(render(*surface, view, light, look));
    double area = 0, inside = 0, left = 0, right = 0;
    for (uint32_t i = 0; i < image->pixels.size(); ++i) {
      const Float4& p = image->pixels[i];
      area += double{p.w};
      inside += double{p.x};
      (i % kPixels < kPixels / 2 ? left : right) += double{p.y};
    }
    // A ball of 9 cells from 1 m, in a picture of 2 tan(0.15) m.
    const double radius = 0.09 / std::sqrt(1 - 0.09 * 0.09) / (2 * std::tan(0.15)) * kPixels;
    EXPECT_NEAR(area, std::numbers::pi * radius * radius, 0.02 * area);
    EXPECT_EQ(inside, 0) << "the inside of the surface is seen";
    EXPECT_GT(side * (right - left), 0.3 * (left + right)) << "the light comes from +x";
  }
  const auto raw = required(gpu().device()->read(surface->counts()));
  const auto size = required(surface->checkCounts(*raw));
  EXPECT_EQ(size->triangles, 2 * size->vertices - 4) << "a closed surface without holes";

  auto small =
      required(detail::IsoSurface::create(gpu().resources, "small", field_.nodes, {100, 5000}));
  ASSERT_TRUE(render(*small, view, light, look).ok());
  const auto smallCounts = required(gpu().device()->read(small->counts()));
  expectError(small->checkCounts(*smallCounts), {"'small'", std::to_string(size->vertices)});

  // A field that has grown since.
  auto tight =
      required(detail::IsoSurface::create(gpu().resources, "tight", {28, 26, 24}, {9000, 18000}));
  EXPECT_FALSE(tight->hasRoomFor(field_.nodes));
  ASSERT_TRUE(render(*tight, view, light, look).ok());
  const auto tightCounts = required(gpu().device()->read(tight->counts()));
  EXPECT_FALSE(tight->checkCounts(*tightCounts).ok());

  remove(*surface);
  remove(*small);
  remove(*tight);
}

INSTANTIATE_TEST_SUITE_P(Apis, IsoSurfaceDraw, testing::ValuesIn(kApis), apiTestName);

TEST(IsoSurface, RefusesAGridThatCannotBeNumbered) {
  ResourceTable resources;
  const auto refuses = [&](const detail::GridSize& nodes, const detail::IsoSurfaceCapacity& room) {
    return !detail::IsoSurface::create(resources, "a", nodes, room).ok();
  };
  EXPECT_TRUE(refuses({5464, 4, 4}, {9, 9}));
  EXPECT_TRUE(refuses({4096, 4096, 64}, {9, 9}));
  EXPECT_TRUE(refuses({4, 4, 0}, {9, 9}));
  EXPECT_TRUE(refuses({4, 4, 4}, {0, 9}));
}

}  // namespace
}  // namespace pelage::test
