// Strands as triangles and as swept spheres: the bits of a CPU, the layouts that Vulkan takes, and
// the pixels that rays hit against those that are drawn.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "pelage/ray_tracing.h"
#include "ray_tracing/ray_scene.h"
#include "support/errors.h"
#include "support/lists.h"
#include "support/plain_asset.h"
#include "support/scene_run.h"

namespace pelage::test {
namespace {

using namespace rayScene;

// ---- The kernels' operations, in their order

float inverseRoot(float x) {
  float y = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<uint32_t>(x) >> 1));
  for (int i = 0; i < 4; ++i) {
    const float missing = 1.0f - (x * y) * y;
    y = y + (y * 0.5f) * missing;
  }
  return y;
}

Vector directionOr(const Vector& v, const Vector& fallback) {
  const float squared = dot(v, v);
  return squared > 1e-24f && squared < 1e38f ? scaled(v, inverseRoot(squared)) : fallback;
}

Vector perpendicular(const Vector& v) {
  const float flat = std::abs(v[0]) + std::abs(v[1]);
  return flat < 0.1f ? directionOr({0, -v[2], v[1]}, {1, 0, 0})
                     : directionOr({-v[1], v[0], 0}, {1, 0, 0});
}

struct Expected {
  std::vector<float> positions, radii;
};

Expected expectedOf(const std::vector<Float4>& strands, const std::vector<float>& thickness,
                    const StrandMaterial& material, float radiusScale, uint32_t vertices,
                    uint32_t segments, uint32_t count, bool triangles) {
  Expected result;
  const auto add = [&](const Vector& v) {
    result.positions.insert(result.positions.end(), v.begin(), v.end());
  };
  for (uint32_t s = 0; s < count; ++s) {
    const auto source = [&](uint32_t i) { return (i * (vertices - 1) + segments / 2) / segments; };
    const auto at = [&](uint32_t v) {
      const Float4& p = strands[size_t{s} * vertices + v];
      return Vector{p.x, p.y, p.z};
    };
    const auto radius = [&](uint32_t v) {
      const float along = static_cast<float>(v) * (1 / static_cast<float>(vertices - 1));
      const float r =
          material.fiberRadius * radiusScale * (1 + (material.tipRadiusRatio - 1) * along);
      return thickness.empty() ? r : r * thickness[s];
    };
    for (uint32_t i = 0; i <= segments && !triangles; ++i) {
      add(at(source(i)));
      result.radii.push_back(radius(source(i)));
    }
    for (uint32_t i = 0; i < segments && triangles; ++i) {
      const uint32_t root = source(i), tip = source(i + 1);
      const Vector a = at(root), b = at(tip);
      const Vector axis = directionOr(difference(b, a), {0, 1, 0});
      Vector side = perpendicular(axis);
      for (int quad = 0; quad < 2; ++quad) {
        const Vector rootSide = scaled(side, radius(root)), tipSide = scaled(side, radius(tip));
        for (const Vector& v :
             {difference(a, rootSide), sum(a, rootSide), difference(b, tipSide), sum(b, tipSide)})
          add(v);
        side = cross(axis, side);
      }
    }
  }
  return result;
}

HairAsset tangled(uint32_t strands, uint32_t vertices, bool thick) {
  HairAsset asset = strandsAt(strands, vertices, [&](uint32_t s, uint32_t v) {
    const auto t = static_cast<float>(v), k = static_cast<float>(s);
    return Float3{0.01f * k + 0.003f * std::sin(t * 0.9f + k), 0.01f * t,
                  0.004f * std::cos(1.7f * t * k)};
  });
  // A strand that stands along z, and one that ends early.
  for (uint32_t v = 0; v < vertices; ++v)
    asset.positions[v] = {0, 0, 0.01f * static_cast<float>(v), asset.positions[v].w};
  for (uint32_t v = vertices / 2; v < vertices; ++v)
    asset.positions[vertices + v] = asset.positions[vertices + vertices / 2];
  if (thick)
    for (uint32_t s = 0; s < strands; ++s)
      asset.strandThickness.push_back(0.3f + 0.1f * static_cast<float>(s));
  expectOk(asset.process());
  return asset;
}

class RayGeometryTest : public SceneRunTest<Api> {
 protected:
  RayGeometry make(const HairObject& hair, const RayGeometryDef& def) {
    return valueOf(RayGeometry::create(run_.scene.resources(), hair, def));
  }
  void write(const RayGeometry& geometry, HairObject& hair) {
    PassList list;
    expectOk(run_.scene.simulate(1.0f / 60, list));
    expectOk(geometry.addPass(hair, list));
    run_.execute(list);
  }
};

TEST_P(RayGeometryTest, BitsAreThoseOfACpu) {
  for (const bool thick : {false, true}) {
    HairDef def;
    def.material.fiberRadius = 7e-5f;
    def.material.tipRadiusRatio = 0.37f;
    HairObject& hair = run_.add(tangled(7, 12, thick), def);
    for (const auto kind : {RayGeometryKind::kTriangles, RayGeometryKind::kSpheres}) {
      for (const auto& [share, segments] :
           {std::pair(1.0f, 0u), {1.0f, 11u}, {0.5f, 4u}, {1e-6f, 1u}}) {
        SCOPED_TRACE(testing::Message()
                     << thick << " " << static_cast<int>(kind) << " " << segments);
        RayGeometry geometry = make(
            hair, {.kind = kind, .strandShare = share, .segments = segments, .radiusScale = 1.5f});
        write(geometry, hair);
        const std::vector<float> thickness =
            thick ? run_.read<float>(hair.buffers().strandThickness) : std::vector<float>();
        const bool triangles = kind == RayGeometryKind::kTriangles;
        EXPECT_EQ(geometry.strandCount(), share == 1 ? 7u : share == 0.5f ? 4u : 1u);
        const Expected expected =
            expectedOf(run_.positions(hair), thickness, hair.material, 1.5f, 12,
                       geometry.segmentsPerStrand(), geometry.strandCount(), triangles);
        const std::vector<float> positions = run_.read<float>(geometry.positions());
        ASSERT_EQ(positions.size(), expected.positions.size());
        ASSERT_EQ(positions.size(), geometry.vertexCount() * size_t{3});
        EXPECT_EQ(std::memcmp(positions.data(), expected.positions.data(), positions.size() * 4),
                  0);
        if (!triangles) {
          const std::vector<float> radii = run_.read<float>(geometry.radii());
          ASSERT_EQ(radii.size(), expected.radii.size());
          EXPECT_EQ(std::memcmp(radii.data(), expected.radii.data(), radii.size() * 4), 0);
        }
        geometry.remove(run_.scene.resources());
      }
    }
  }
}

TEST_P(RayGeometryTest, IndicesAreThoseOfDisjointQuadsAndOfSegments) {
  HairObject& hair = run_.add(tangled(3, 5, false));
  RayGeometry triangles = make(hair, {.kind = RayGeometryKind::kTriangles, .segments = 2}),
              spheres = make(hair, {.segments = 2});
  EXPECT_EQ(triangles.primitiveCount(), 3u * 2 * 4);
  EXPECT_EQ(spheres.primitiveCount(), 3u * 2);
  EXPECT_EQ(triangles.vertexCount(), 3u * 2 * 8);
  EXPECT_EQ(spheres.vertexCount(), 3u * 3);
  write(triangles, hair);
  const std::vector<uint32_t> quads = run_.read<uint32_t>(triangles.indices());
  ASSERT_EQ(quads.size(), triangles.indexCount());
  std::vector<int> uses(triangles.vertexCount());
  for (size_t i = 0; i < quads.size(); ++i) {
    ASSERT_LT(quads[i], triangles.vertexCount());
    EXPECT_EQ(quads[i] / 4, i / 6) << "a quad has vertices of its own";
    ++uses[quads[i]];
  }
  for (size_t v = 0; v < uses.size(); ++v) EXPECT_EQ(uses[v], v % 4 == 0 || v % 4 == 3 ? 1 : 2);
  EXPECT_EQ(run_.read<uint32_t>(spheres.indices()),
            (std::vector<uint32_t>{0, 1, 1, 2, 3, 4, 4, 5, 6, 7, 7, 8}));
  triangles.remove(run_.scene.resources());
  spheres.remove(run_.scene.resources());
}

// ---- Rays

TEST_P(RayGeometryTest, RaysHitThePixelsThatAreDrawn) {
  HairObject& hair = run_.add(strands(), def());
  hair.simulated = false;
  RayGeometry geometry = make(hair, {.kind = RayGeometryKind::kTriangles});
  write(geometry, hair);
  const Triangles triangles = {run_.read<float>(geometry.positions()),
                               run_.read<uint32_t>(geometry.indices())};
  expectDrawn(trace(triangles), run_.render({0, 0, kDistance}, kPixels));
  geometry.remove(run_.scene.resources());
}

TEST_P(RayGeometryTest, WrongDefinitionsAndObjectsAreRefused) {
  HairObject& hair = run_.add(tangled(3, 5, false));
  HairObject& other = run_.add(tangled(3, 5, false));
  ResourceTable& resources = run_.scene.resources();
  const uint32_t before = resources.count();
  for (const RayGeometryDef& def :
       {RayGeometryDef{.strandShare = 0}, RayGeometryDef{.strandShare = 1.01f},
        RayGeometryDef{.strandShare = std::nanf("")}, RayGeometryDef{.segments = 5},
        RayGeometryDef{.radiusScale = 0}, RayGeometryDef{.radiusScale = std::nanf("")}})
    expectError(RayGeometry::create(resources, hair, def), "RayGeometry: ");
  ResourceTable foreign;
  expectError(RayGeometry::create(foreign, hair, {}), "not that of the object's scene");
  EXPECT_EQ(resources.count(), before);
  RayGeometry geometry = make(hair, {});
  PassList list;
  expectOk(run_.scene.simulate(0, list));
  const size_t passes = list.passes.size();
  expectError(geometry.addPass(other, list), "not that of create()");
  expectError(RayGeometry().addPass(hair, list), "not that of create()");
  EXPECT_EQ(list.passes.size(), passes);
  geometry.remove(resources);
  EXPECT_EQ(resources.count(), before);
  run_.execute(list);
}

INSTANTIATE_TEST_SUITE_P(Apis, RayGeometryTest, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
