// The table of roots on a mesh: its file, and roots that follow deformed meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "pelage/authoring/skin_binding.h"
#include "pelage/demo/groom.h"
#include "pelage/random.h"
#include "pelage/skeleton.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;
using test::required;

// Distance between two points.
double apart(const Float3& a, const Float3& b) {
  return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

double difference(const AffineTransform& a, const AffineTransform& b) {
  double most = 0;
  for (size_t i = 0; i < 3; ++i)
    for (const double d : {double{a.rows[i].x} - b.rows[i].x, double{a.rows[i].y} - b.rows[i].y,
                           double{a.rows[i].z} - b.rows[i].z, double{a.rows[i].w} - b.rows[i].w})
      test::keepLargest(most, std::abs(d));
  return most;
}

// R^T R = 1 and det R = 1.
void expectRotation(const AffineTransform& t) {
  const Float4* r = t.rows;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(double{r[i].x} * r[j].x + double{r[i].y} * r[j].y + double{r[i].z} * r[j].z,
                  i == j ? 1 : 0, 1e-6);
  EXPECT_GT(r[0].x * (r[1].y * r[2].z - r[1].z * r[2].y) -
                r[0].y * (r[1].x * r[2].z - r[1].z * r[2].x) +
                r[0].z * (r[1].x * r[2].y - r[1].y * r[2].x),
            0);
}

// A groom on the generated head, in two parts: the head, and a far triangle.
struct Character {
  SkinnedMesh mesh;
  std::vector<Float3> roots;
  SkinTable table;
};

Character makeCharacter() {
  Character c;
  GroomDef def;
  def.strandCount = 300;
  def.verticesPerStrand = 4;
  auto groom = generateGroom(def);
  EXPECT_TRUE(groom);
  const auto count = static_cast<uint32_t>(groom->head.positions.size());
  const auto triangles = static_cast<uint32_t>(groom->head.indices.size() / 3);
  c.mesh.parts = {{"head", "headMesh", "skin", 0, count, 0, triangles},
                  {"tail", "", "", count, 3, triangles, 1}};
  c.mesh.bones = groom->head.bones;
  c.mesh.positions = groom->head.positions;
  c.mesh.normals = groom->head.normals;
  c.mesh.influences = groom->head.influences;
  c.mesh.indices = groom->head.indices;
  for (const Float3& p : {Float3{0, -1, 0}, Float3{0.1f, -1, 0}, Float3{0, -1, 0.1f}}) {
    c.mesh.indices.push_back(static_cast<uint32_t>(c.mesh.positions.size()));
    c.mesh.positions.push_back(p);
    c.mesh.normals.push_back({0, 1, 0});
    c.mesh.influences.push_back({{0, 0, 0, 0}, {1, 0, 0, 0}});
  }
  c.roots = rootsOf(groom->hair);
  c.roots.push_back({0.02f, -0.98f, 0.03f});  // strand 300, over the tail
  auto binding = bindRoots(c.roots, c.mesh);
  EXPECT_TRUE(binding);
  c.table = binding->table;
  return c;
}

const Character& character() {
  static const Character instance = makeCharacter();
  return instance;
}

std::vector<std::span<const Float3>> partsOf(const SkinnedMesh& mesh,
                                             const std::vector<Float3>& positions) {
  std::vector<std::span<const Float3>> parts;
  for (const SkinnedMeshPart& part : mesh.parts)
    parts.push_back(std::span(positions).subspan(part.firstVertex, part.vertexCount));
  return parts;
}

// Transforms for vertices moved by a function.
template <class Function>
std::vector<AffineTransform> follow(const Character& c, Function&& move) {
  std::vector<Float3> positions = c.mesh.positions;
  for (Float3& p : positions) p = move(p);
  std::vector<AffineTransform> transforms(c.table.roots.size());
  auto done = rootTransforms(c.table, partsOf(c.mesh, positions), transforms);
  EXPECT_TRUE(done);
  return transforms;
}

TEST(RootTransforms, BindPositionsAreTheRoots) {
  const Character& c = character();
  for (size_t i = 0; i < c.roots.size(); ++i)
    EXPECT_LT(apart(bindPosition(c.table.roots[i]), c.roots[i]), 1e-7);
}

TEST(RootTransforms, AMeshThatDoesNotMoveGivesTheIdentity) {
  for (const AffineTransform& t : follow(character(), [](const Float3& p) { return p; }))
    EXPECT_LT(difference(t, {}), 1e-7);
}

TEST(RootTransforms, AMeshThatMovesAsAWholeCarriesTheRootsAlong) {
  Random random(4);
  for (int i = 0; i < 5; ++i) {
    const auto number = [&] { return 2 * random.uniform() - 1; };
    const Quaternion q = {number(), number(), number(), number()};
    const AffineTransform motion = rigidTransform(q, {number(), number(), number()});
    for (const AffineTransform& t :
         follow(character(), [&](const Float3& p) { return transformPoint(motion, p); }))
      // Vertices are rounded to 1e-7 m, on triangles of some millimetres.
      EXPECT_LT(difference(t, motion), 5e-4);
  }
}

TEST(RootTransforms, ABlendShapeCarriesItsPatchAndNothingElse) {
  const Character& c = character();
  // The part above y = 0.25 m turns by a quarter and rises; exact in float on the far tail.
  const AffineTransform quarter = {{{0, 0, 1, 0.5f}, {0, 1, 0, 0.25f}, {-1, 0, 0, -0.125f}}};
  const auto moved = [](const Float3& p) { return p.y > 0.25f; };
  const auto transforms =
      follow(c, [&](const Float3& p) { return moved(p) ? transformPoint(quarter, p) : p; });
  int rotated = 0, still = 0;
  for (size_t i = 0; i < transforms.size(); ++i) {
    const Float3* bind = c.table.roots[i].bind;
    const int corners = moved(bind[0]) + moved(bind[1]) + moved(bind[2]);
    expectRotation(transforms[i]);
    const Float3 at = transformPoint(transforms[i], c.roots[i]);
    if (corners == 3) {
      EXPECT_LT(difference(transforms[i], quarter), 5e-5);
      EXPECT_LT(apart(at, transformPoint(quarter, c.roots[i])), 1e-6);
      ++rotated;
    } else if (corners == 0) {
      EXPECT_LT(difference(transforms[i], {}), 1e-7);
      ++still;
    }
  }
  EXPECT_GT(rotated, 50);
  EXPECT_GT(still, 50);
}

TEST(RootTransforms, StretchMovesTheRootsAndTurnsNone) {
  const Character& c = character();
  // Growing is no rotation.
  const auto grown = follow(c, [](const Float3& p) { return Float3{2 * p.x, 2 * p.y, 2 * p.z}; });
  for (size_t i = 0; i + 1 < grown.size(); ++i) {
    const Float3 at = transformPoint(grown[i], c.roots[i]);
    EXPECT_LT(apart(at, {2 * c.roots[i].x, 2 * c.roots[i].y, 2 * c.roots[i].z}), 1e-4);
    AffineTransform linear = grown[i];
    for (Float4& row : linear.rows) row.w = 0;
    EXPECT_LT(difference(linear, {}), 1e-5);
  }
  // Stretched along an axis of its plane, not along an edge, a flat patch does not turn; sheared,
  // it turns by half of its edges' difference: the polar factor of [1 s; 0 1] has the tangent
  // s / 2.
  const auto tail = [](const Float3& p) { return p.y < -0.9f; };
  const auto stretched = follow(c, [&](const Float3& p) {
    const float s = p.x + p.z;  // by 2 along the diagonal
    return tail(p) ? Float3{p.x + s / 2, p.y, p.z + s / 2} : p;
  });
  AffineTransform linear = stretched.back();
  for (Float4& row : linear.rows) row.w = 0;
  EXPECT_LT(difference(linear, {}), 1e-6);
  const auto sheared = follow(c, [&](const Float3& p) {
    return tail(p) ? Float3{p.x + 0.5f * p.z, p.y, p.z} : p;
  });
  const double angle = std::atan(0.25);
  EXPECT_NEAR(sheared.back().rows[0].x, std::cos(angle), 1e-6);
  EXPECT_NEAR(sheared.back().rows[0].z, std::sin(angle), 1e-6);
  EXPECT_NEAR(sheared.back().rows[2].x, -std::sin(angle), 1e-6);
}

TEST(RootTransforms, WhereTheTriangleIsGoneTheTransformStays) {
  const Character& c = character();
  std::vector<Float3> positions = c.mesh.positions;
  const uint32_t tail = c.mesh.parts[1].firstVertex;
  AffineTransform before;
  before.rows[0].w = 7;
  for (const Float3& broken : {positions[tail], Float3{kNan, 0, 0}, Float3{0, INFINITY, 0}}) {
    positions[tail + 1] = broken;
    std::vector<AffineTransform> transforms(c.table.roots.size(), before);
    ASSERT_TRUE(rootTransforms(c.table, partsOf(c.mesh, positions), transforms));
    EXPECT_EQ(transforms.back(), before);
    EXPECT_NE(transforms.front(), before);
  }
}

TEST(RootTransforms, WrongArraysAreErrors) {
  const Character& c = character();
  std::vector<AffineTransform> transforms(c.table.roots.size());
  auto parts = partsOf(c.mesh, c.mesh.positions);
  EXPECT_TRUE(rootTransforms(c.table, parts, transforms));
  EXPECT_FALSE(rootTransforms(c.table, std::span(parts).first(1), transforms));
  EXPECT_FALSE(rootTransforms(c.table, parts, std::span(transforms).first(3)));
  parts[1] = parts[1].first(2);
  expectError(rootTransforms(c.table, parts, transforms), "part 1 ('tail')");
}

TEST(RootTransforms, OneBoneAStrandIsOne) {
  const auto influences = oneBoneAStrand(3);
  ASSERT_EQ(influences.size(), 3u);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(influences[i].bones[0], i);
    EXPECT_EQ(influences[i].weights[0], 1);
  }
}

// A table of two parts and two roots.
SkinTable smallTable() {
  SkinTable table;
  table.parts = {{"head", "mesh", "skin", 10, 4}, {"ear", "", "", 3, 1}};
  SurfaceRoot root = {0, 3, {9, 2, 5}, {0.25f, 0.5f, 0.25f}, {0, 0, 0.001f}, {}};
  root.bind[0] = {1, 0, 0};
  root.bind[1] = {0, 1, 0};
  root.bind[2] = {0, 0, 1};
  table.roots = {root, root};
  table.roots[1].part = 1;
  table.roots[1].triangle = 0;
  table.roots[1].corners[0] = 0;
  table.roots[1].corners[1] = 1;
  table.roots[1].corners[2] = 2;
  return table;
}

TEST(TfxSkin, GivesBackWhatWasSaved) {
  const SkinTable table = smallTable();
  auto bytes = required(saveTfxSkin(table));
  EXPECT_EQ(bytes->size(), 24u + (20 + 12) + (20 + 3) + 2 * 80);
  auto again = required(loadTfxSkin(*bytes, "memory", 2));
  EXPECT_EQ(*again, table);
  EXPECT_EQ(*saveTfxSkin(*again), *bytes);
  EXPECT_FALSE(loadTfxSkin(*bytes, "memory", 3));
}

TEST(TfxSkin, ATruncatedFileIsAnErrorWithTheOffset) {
  auto bytes = required(saveTfxSkin(smallTable()));
  for (size_t size = 0; size < bytes->size(); ++size) {
    auto table = loadTfxSkin(std::span(*bytes).first(size), "cut.tfxskin");
    ASSERT_FALSE(table) << size;
    EXPECT_EQ(table.error().message.find("cut.tfxskin: byte "), 0u) << table.error().message;
  }
  bytes->push_back(std::byte{0});
  EXPECT_FALSE(loadTfxSkin(*bytes, "long"));
}

TEST(TfxSkin, EveryChangedByteIsAnErrorOrAValidTable) {
  auto bytes = required(saveTfxSkin(smallTable()));
  for (size_t i = 0; i < bytes->size(); ++i)
    for (const unsigned change : {0x01u, 0x80u, 0xffu}) {
      std::vector<std::byte> changed = *bytes;
      changed[i] ^= static_cast<std::byte>(change);
      auto table = loadTfxSkin(changed, "changed");
      EXPECT_TRUE(!table || validate(*table).ok()) << i;
      // Magic, version, counts and the reserved word.
      EXPECT_TRUE(!table || i >= 24) << i;
    }
}

TEST(TfxSkin, ValuesOutOfRangeAreErrors) {
  const auto fails = [](auto&& change) {
    SkinTable table = smallTable();
    change(table);
    return !validate(table).ok() && !saveTfxSkin(table).ok();
  };
  EXPECT_FALSE(fails([](SkinTable&) {}));
  EXPECT_TRUE(fails([](SkinTable& t) { t.parts.clear(); }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots.clear(); }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.parts[1].name.resize(4096, 'x'); }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.parts[1].material = std::string(1, '\0'); }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[1].part = 2; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[1].triangle = 1; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[1].corners[2] = 3; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].barycentric.x = kNan; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].barycentric.x = 0.26f; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].barycentric = {1.5f, -0.5f, 0}; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].offset.y = kNan; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].bind[1].z = 2e6f; }));
  EXPECT_TRUE(fails([](SkinTable& t) { t.roots[0].bind[1] = t.roots[0].bind[0]; }));
}

}  // namespace
}  // namespace pelage
