// Judges what Blender exported of the scene of make_scene.py, in the folder PELAGE_EXPORT_DIR.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/random.h"
#include "support/extremes.h"

namespace {

using pelage::BoneInfluences;
using pelage::BoneWeights;
using pelage::CollisionMesh;
using pelage::Float3;
using pelage::Float4;
using pelage::HairAsset;

// As make_scene.py: counts, and where the bust stands after the turn to y up [m].
constexpr uint32_t kParticles = 300, kCurves = 240;
constexpr double kCenterX = 0.2, kCenterZ = -0.1;
constexpr double kOnMesh = 2e-6;  // Blender's floats, and ours

using Vector = std::array<double, 3>;

Vector operator-(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double distance(const Vector& a, const Vector& b) { return std::sqrt(dot(a - b, a - b)); }
Vector toVector(const Float3& p) { return {p.x, p.y, p.z}; }
Vector toVector(const Float4& p) { return {p.x, p.y, p.z}; }

Vector mix(const Vector& a, const Vector& b, const Vector& c, const Vector& weights) {
  Vector result;
  for (size_t k = 0; k < 3; ++k)
    result[k] = a[k] * weights[0] + b[k] * weights[1] + c[k] * weights[2];
  return result;
}

// Barycentric coordinates of the closest point of a triangle, by ternary search along one edge of
// the closest point on the lines to the opposite corner: slow, but not how the exporter does it.
Vector closestOn(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
  const auto onLine = [&](double s) {
    const Vector foot = mix(a, b, c, {1 - s, s, 0});
    const Vector line = c - foot;
    const double length2 = dot(line, line);
    const double t = length2 > 0 ? std::clamp(dot(p - foot, line) / length2, 0.0, 1.0) : 0.0;
    return Vector{(1 - s) * (1 - t), s * (1 - t), t};
  };
  const auto distanceAt = [&](double s) { return distance(p, mix(a, b, c, onLine(s))); };
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double left = low + (high - low) / 3, right = high - (high - low) / 3;
    (distanceAt(left) < distanceAt(right) ? high : low) =
        distanceAt(left) < distanceAt(right) ? right : left;
  }
  return onLine((low + high) / 2);
}

struct MeshPoint {
  double distance = 1e9;
  size_t triangle = 0;
  Vector barycentric{};
};

MeshPoint closestOn(const Vector& p, const CollisionMesh& mesh) {
  MeshPoint best;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vector a = toVector(mesh.positions[mesh.indices[i]]);
    const Vector b = toVector(mesh.positions[mesh.indices[i + 1]]);
    const Vector c = toVector(mesh.positions[mesh.indices[i + 2]]);
    // No point of the triangle is nearer than its first corner by more than its longest edge.
    if (distance(p, a) - std::max(distance(a, b), distance(a, c)) >= best.distance) continue;
    const Vector weights = closestOn(p, a, b, c);
    const double found = distance(p, mix(a, b, c, weights));
    if (found < best.distance) best = {found, i, weights};
  }
  return best;
}

using Shares = std::map<uint32_t, double>;

Shares sharesOf(const BoneInfluences& influences, double factor = 1) {
  Shares shares;
  for (size_t k = 0; k < 4; ++k)
    if (influences.weights[k] > 0)
      shares[influences.bones[k]] += factor * static_cast<double>(influences.weights[k]);
  return shares;
}

double sumOf(const BoneInfluences& influences) {
  return std::accumulate(std::begin(influences.weights), std::end(influences.weights), 0.0);
}

template <class T>
T valueOf(pelage::Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

class BlenderExport : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("PELAGE_EXPORT_DIR");
    if (folder == nullptr) GTEST_SKIP() << "skipped: run tests/blender/blender_export.sh";
    folder_ = folder;
  }

  // Errors end the test: gtest reports exceptions.
  HairAsset hair(const std::string& name) const {
    HairAsset asset = valueOf(pelage::loadTfx(folder_ / (name + ".tfx")));
    if (const auto done = asset.process(); !done) throw std::runtime_error(done.error().message);
    return asset;
  }
  BoneWeights bones(const std::string& name, uint32_t strandCount) const {
    return valueOf(pelage::loadTfxBone(folder_ / (name + ".tfxbone"), strandCount));
  }
  CollisionMesh mesh(const std::string& name) const {
    return valueOf(pelage::loadTfxMesh(folder_ / (name + ".tfxmesh")));
  }
  bool exists(const std::string& file) const { return std::filesystem::exists(folder_ / file); }

  std::filesystem::path folder_;
};

Vector vertexOf(const HairAsset& asset, size_t strand, size_t vertex) {
  return toVector(asset.positions[strand * asset.verticesPerStrand + vertex]);
}

TEST_F(BlenderExport, EverySourceBecomesStrands) {
  EXPECT_EQ(hair("default").strandCount, kParticles + kCurves + 1);
  EXPECT_EQ(hair("default").verticesPerStrand, 16u);
  EXPECT_EQ(hair("particles").strandCount, kParticles);
  EXPECT_EQ(hair("particles").verticesPerStrand, 8u);
  EXPECT_EQ(hair("children").strandCount, 3 * kParticles);
  EXPECT_EQ(hair("curves").strandCount, kCurves);
  EXPECT_EQ(hair("long_only").strandCount, kCurves);
  EXPECT_EQ(hair("braid").strandCount, 1u);
  EXPECT_FALSE(exists("up_y.tfxmesh"));
}

// The bust is posed, and not at the origin: its vertices are on the profile only in rest pose and
// with its transform.
TEST_F(BlenderExport, MeshIsInRestPoseWithYUp) {
  const CollisionMesh bust = mesh("default");
  ASSERT_EQ(bust.positions.size(), 17u * 48 + 2);
  const Float3& top = bust.positions.back();
  EXPECT_NEAR(top.x, kCenterX, kOnMesh);
  EXPECT_NEAR(top.y, 0.443, kOnMesh);
  EXPECT_NEAR(top.z, kCenterZ, kOnMesh);
  std::map<int, int> ringSizes;  // by height in 0.1 mm
  for (const Float3& p : bust.positions) ++ringSizes[static_cast<int>(std::lround(p.y * 1e4f))];
  EXPECT_EQ(ringSizes[3300], 48);
  for (const Float3& p : bust.positions)
    if (std::abs(p.y - 0.33f) < 1e-5f) {
      EXPECT_NEAR(std::hypot(p.x - kCenterX, p.z - kCenterZ), 0.095, kOnMesh);
    }
  const auto report = pelage::inspectMesh(bust);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->closed && report->consistentlyOriented && !report->inverted)
      << pelage::describe(*report);
  for (const Float3& n : bust.normals) EXPECT_NEAR(distance(toVector(n), {0, 0, 0}), 1, 1e-5);
}

TEST_F(BlenderExport, VerticesHaveTheWeightsOfTheirGroups) {
  const CollisionMesh bust = mesh("default");
  ASSERT_EQ(bust.bones.size(), 3u);  // the bone that does not deform is not there
  EXPECT_EQ(bust.bones[0].name, "spine");
  EXPECT_EQ(bust.bones[1].name, "neck");
  EXPECT_EQ(bust.bones[2].name, "head");
  for (const std::string name : {"default", "curves", "materials_felt"}) {
    const CollisionMesh part = mesh(name);
    for (size_t i = 0; i < part.positions.size(); ++i) {
      const double height = static_cast<double>(part.positions[i].y);
      const double neck = std::clamp((height - 0.125) / 0.03, 0.0, 1.0);
      const double head = std::clamp((height - 0.205) / 0.03, 0.0, 1.0);
      Shares shares = sharesOf(part.influences[i]);
      EXPECT_NEAR(shares[0], 1 - neck, 1e-4) << name << " " << i;
      EXPECT_NEAR(shares[1], neck - head, 1e-4) << name << " " << i;
      EXPECT_NEAR(shares[2], head, 1e-4) << name << " " << i;
    }
  }
  EXPECT_EQ(bust.repairedVertexCount, 0u);
}

TEST_F(BlenderExport, RootsAreOnTheMeshAndMoveWithIt) {
  const CollisionMesh bust = mesh("default");
  for (const std::string name : {"particles", "children", "curves"}) {
    const HairAsset asset = hair(name);
    const BoneWeights weights = bones(name, asset.strandCount);
    ASSERT_EQ(weights.bones, bust.bones);
    double worstDistance = 0, worstWeight = 0, worstSum = 0;
    int blended = 0;
    for (size_t strand = 0; strand < asset.strandCount; strand += 3) {
      const MeshPoint at = closestOn(vertexOf(asset, strand, 0), bust);
      pelage::test::keepLargest(worstDistance, at.distance);
      Shares expected;
      for (size_t corner = 0; corner < 3; ++corner)
        for (const auto& [bone, share] :
             sharesOf(bust.influences[bust.indices[at.triangle + corner]], at.barycentric[corner]))
          expected[bone] += share;
      Shares found = sharesOf(weights.strands[strand]);
      for (uint32_t bone = 0; bone < 3; ++bone)
        pelage::test::keepLargest(worstWeight, std::abs(found[bone] - expected[bone]));
      pelage::test::keepLargest(worstSum, std::abs(sumOf(weights.strands[strand]) - 1));
      if (found.size() > 1) ++blended;
    }
    // Children begin between their parents, where Blender interpolates them to.
    EXPECT_LT(worstDistance, name == "children" ? 1e-3 : kOnMesh) << name;
    EXPECT_LT(worstWeight, 1e-4) << name;
    EXPECT_LT(worstSum, 1e-6) << name;
    EXPECT_GT(blended, 5) << name;
    EXPECT_EQ(weights.repairedStrandCount, 0u);
  }
}

TEST_F(BlenderExport, StrandsHaveTheLengthOfTheHairAndEvenSegments) {
  const HairAsset asset = hair("particles");
  for (size_t strand = 0; strand < asset.strandCount; ++strand) {
    const float* rest = &asset.restLengths[strand * asset.verticesPerStrand];
    const float length = std::accumulate(rest, rest + 7, 0.0f);
    EXPECT_GT(length, 0.015f);
    EXPECT_LT(length, 0.045f);
    // Vertices at equal distances along the curve: chords differ only where it bends.
    for (int i = 0; i < 7; ++i) EXPECT_NEAR(rest[i], length / 7, 0.05f * length);
  }
}

TEST_F(BlenderExport, StrandUvIsThatOfTheRoot) {
  const HairAsset asset = hair("curves");
  ASSERT_EQ(asset.strandUv.size(), kCurves);
  std::vector<std::pair<double, float>> byHeight;
  for (size_t strand = 0; strand < kCurves; ++strand) {
    const Vector root = vertexOf(asset, strand, 0);
    byHeight.push_back({root[1], asset.strandUv[strand].y});
    // u goes around once, from the front (-y of Blender, +z here) to +x.
    double u = std::atan2(root[0] - kCenterX, root[2] - kCenterZ) / (2 * std::numbers::pi);
    if (u < 0) u += 1;
    if (root[1] < 0.43) {
      EXPECT_NEAR(static_cast<double>(asset.strandUv[strand].x), u, 1e-3) << strand;
    }
  }
  std::sort(byHeight.begin(), byHeight.end());
  for (size_t i = 1; i < byHeight.size(); ++i)
    EXPECT_GE(byHeight[i].second, byHeight[i - 1].second - 1e-5f);
  EXPECT_GT(byHeight.back().second, byHeight.front().second + 0.4f);
}

TEST_F(BlenderExport, ScaleAndInvertZMirrorHairAndMeshAlike) {
  const HairAsset plain = hair("curves"), changed = hair("options");
  ASSERT_EQ(plain.positions.size(), changed.positions.size());
  for (size_t i = 0; i < plain.positions.size(); ++i) {
    EXPECT_NEAR(changed.positions[i].x, 2 * plain.positions[i].x, 1e-6f);
    EXPECT_NEAR(changed.positions[i].y, 2 * plain.positions[i].y, 1e-6f);
    EXPECT_NEAR(changed.positions[i].z, -2 * plain.positions[i].z, 1e-6f);
  }
  const CollisionMesh collar = mesh("options_collar"), bust = mesh("options_bust");
  const auto report = pelage::inspectMesh(collar);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->closed && report->consistentlyOriented && !report->inverted)
      << pelage::describe(*report);
  EXPECT_NEAR(closestOn(vertexOf(changed, 0, 0), bust).distance, 0, 2 * kOnMesh);
  EXPECT_EQ(collar.bones, bust.bones);
  EXPECT_FALSE(exists("options.tfxmesh"));
  // Normals point outwards, away from the ring's core.
  for (size_t i = 0; i < collar.positions.size(); ++i) {
    const Vector p = toVector(collar.positions[i]);
    const double x = p[0] - 2 * kCenterX, z = p[2] + 2 * kCenterZ;
    const double core = 2 * 0.085 / std::hypot(x, z);
    const Vector outwards =
        p - Vector{2 * kCenterX + x * core, 2 * 0.155, -2 * kCenterZ + z * core};
    EXPECT_GT(dot(toVector(collar.normals[i]), outwards), 0);
  }
}

TEST_F(BlenderExport, InvertVTurnsTheTextureAround) {
  const HairAsset plain = hair("curves"), changed = hair("options");
  ASSERT_EQ(changed.strandUv.size(), plain.strandUv.size());
  for (size_t i = 0; i < plain.strandUv.size(); ++i) {
    EXPECT_EQ(changed.strandUv[i].x, plain.strandUv[i].x);
    EXPECT_NEAR(changed.strandUv[i].y, 1 - plain.strandUv[i].y, 1e-6f);
  }
}

TEST_F(BlenderExport, TheFirstTwoVerticesAreKinematicAndTheLastTwoWhenAskedFor) {
  for (const bool bothEnds : {false, true}) {
    const HairAsset asset = hair(bothEnds ? "options" : "curves");
    const size_t count = asset.verticesPerStrand;
    for (size_t i = 0; i < asset.positions.size(); ++i) {
      const size_t vertex = i % count;
      const bool fixed = vertex < 2 || (bothEnds && vertex >= count - 2);
      ASSERT_EQ(asset.positions[i].w, fixed ? 0.0f : 1.0f) << i;
    }
  }
}

TEST_F(BlenderExport, UpAxisYLeavesCoordinatesAsTheyAre) {
  const HairAsset turned = hair("particles"), plain = hair("up_y");
  ASSERT_EQ(turned.positions.size(), plain.positions.size());
  for (size_t i = 0; i < plain.positions.size(); ++i) {
    EXPECT_EQ(turned.positions[i].x, plain.positions[i].x);
    EXPECT_EQ(turned.positions[i].y, plain.positions[i].z);
    EXPECT_EQ(turned.positions[i].z, -plain.positions[i].y);
  }
}

TEST_F(BlenderExport, TheSceneUnitCounts) {
  const HairAsset metres = hair("braid"), centimetres = hair("centimetres");
  ASSERT_EQ(metres.positions.size(), centimetres.positions.size());
  for (size_t i = 0; i < metres.positions.size(); ++i)
    EXPECT_NEAR(centimetres.positions[i].x, 0.01f * metres.positions[i].x, 1e-8f);
}

// The order is that of pelage::Random, which pelage-convert shuffles with, too.
TEST_F(BlenderExport, ASeedShufflesStrandsTheSameWayEverywhere) {
  const HairAsset plain = hair("particles");
  for (const auto& [name, seed] :
       {std::pair("shuffled", 7u), std::pair("again", 7u), std::pair("other", 8u)}) {
    std::vector<uint32_t> order(kParticles);
    std::iota(order.begin(), order.end(), 0u);
    pelage::Random random(seed);
    for (uint32_t last = kParticles - 1; last > 0; --last)
      std::swap(order[last], order[random.below(last + 1)]);
    const HairAsset asset = hair(name);
    const BoneWeights weights = bones(name, kParticles);
    const BoneWeights plainWeights = bones("particles", kParticles);
    for (size_t strand = 0; strand < kParticles; ++strand) {
      EXPECT_EQ(vertexOf(asset, strand, 7), vertexOf(plain, order[strand], 7));
      EXPECT_EQ(asset.strandUv[strand].x, plain.strandUv[order[strand]].x);
      EXPECT_EQ(weights.strands[strand], plainWeights.strands[order[strand]]);
    }
  }
}

TEST_F(BlenderExport, RadiiBecomeThicknessAndAttributesColours) {
  const HairAsset asset = hair("options");
  ASSERT_EQ(asset.strandThickness.size(), kCurves);
  // Radii of a curve are in proportion to 1 + 0.3 sin(curve); all are about equally long.
  for (size_t strand = 0; strand < kCurves; ++strand) {
    const double expected = 1 + 0.3 * std::sin(static_cast<double>(strand));
    const double first = static_cast<double>(asset.strandThickness[0]);
    EXPECT_NEAR(static_cast<double>(asset.strandThickness[strand]) / first, expected, 1e-3);
  }
  ASSERT_EQ(asset.vertexColor.size(), kCurves * 24u);
  for (size_t i = 0; i < asset.vertexColor.size(); ++i) {
    const float curve = static_cast<float>(i / 24);
    EXPECT_NEAR(asset.vertexColor[i].x, 0.2f + 0.6f * curve / kCurves, 1e-5f);
    EXPECT_NEAR(asset.vertexColor[i].w, 1, 1e-6f);
  }
  EXPECT_TRUE(hair("curves").vertexColor.empty());
}

TEST_F(BlenderExport, ACollectionIsOneMeshOrOneAnObjectOrMaterial) {
  const size_t whole = mesh("curves").indices.size() / 3;
  const size_t collar = mesh("options_collar").indices.size() / 3;
  EXPECT_EQ(collar, 32u * 12 * 2);
  EXPECT_EQ(mesh("options_bust").indices.size() / 3 + collar, whole);
  EXPECT_EQ(mesh("materials_felt").indices.size() / 3, collar / 2);
  EXPECT_EQ(mesh("materials_trim").indices.size() / 3, collar / 2);
  EXPECT_EQ(mesh("materials_skin").indices.size() / 3 + collar, whole);
  EXPECT_FALSE(exists("materials_hair.tfxmesh"));  // a material that no face has
  // Only the vertices that the faces use.
  EXPECT_EQ(mesh("materials_trim").positions.size(), 32u * 7);
}

TEST_F(BlenderExport, AMeshWithoutArmatureIsABoneOfItsOwn) {
  const BoneWeights weights = bones("plain", 10);
  ASSERT_EQ(weights.bones.size(), 1u);
  EXPECT_EQ(weights.bones[0].name, "plain");
  const auto report = pelage::inspectMesh(mesh("plain"));
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->inverted) << pelage::describe(*report);
  EXPECT_GT(report->volume, 0);
}

}  // namespace
