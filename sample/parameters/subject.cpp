#include "subject.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "demo_assets.h"
#include "float3_math.h"
#include "pelage/random.h"
#include "scene_setup.h"

namespace sample {

using pelage::BoneInfluences;
using pelage::CollisionMesh;
using pelage::Float3;
using pelage::HairAsset;
using pelage::Random;
using pelage::Result;

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kGoldenAngle = 2.39996323f;  // rad
constexpr uint32_t kBallRings = 33, kBallSectors = 64;

HairAsset emptyHair(uint32_t strands, uint32_t vertices) {
  HairAsset hair;
  hair.strandCount = strands;
  hair.verticesPerStrand = vertices;
  hair.positions.reserve(size_t{strands} * vertices);
  return hair;
}

void addVertex(HairAsset& hair, const Float3& p) {
  const size_t vertex = hair.positions.size() % hair.verticesPerStrand;
  hair.positions.push_back({p.x, p.y, p.z, vertex < 2 ? 0.0f : 1.0f});
}

// Roots in a sunflower's pattern on a cap of the ball.
HairAsset makeLock(const LockDef& def) {
  constexpr float kCap = 0.6f;      // rad
  constexpr float kCurlIn = 0.02f;  // m over which the curl begins
  const Float3 along = unit(def.direction);
  const Float3 across =
      unit(cross(along, std::abs(along.z) < 0.9f ? Float3{0, 0, 1} : Float3{0, 1, 0}));
  const Float3 other = cross(along, across);
  HairAsset hair = emptyHair(def.guides, def.vertices);
  Random random(7);
  for (uint32_t i = 0; i < def.guides; ++i) {
    const float share = (static_cast<float>(i) + 0.5f) / static_cast<float>(def.guides);
    const float polar = kCap * std::sqrt(share), turn = static_cast<float>(i) * kGoldenAngle;
    Float3 normal = add({}, along, std::cos(polar));
    normal = add(normal, across, std::sin(polar) * std::cos(turn));
    normal = add(normal, other, std::sin(polar) * std::sin(turn));
    const Float3 offset = unit(add(add({}, along, 1 - def.fan), normal, def.fan));
    const float length = def.length * (1 - def.variation * random.uniform());
    const float phase = 0.6f * random.uniform();
    for (uint32_t v = 0; v < def.vertices; ++v) {
      const float s = length * static_cast<float>(v) / static_cast<float>(def.vertices - 1);
      const float radius = def.curlRadius * std::min(s / kCurlIn, 1.0f);
      const float angle = 2 * kPi * def.curlFrequency * s + phase;
      Float3 p = add(add({}, normal, def.ballRadius), offset, s);
      p = add(p, across, radius * std::cos(angle));
      addVertex(hair, add(p, other, radius * std::sin(angle)));
    }
  }
  return hair;
}

constexpr float kRollRadius = 0.05f, kRollHalf = 0.062f;  // m

// From behind the roll over its top, then straight down in front.
HairAsset makeSwatch(uint32_t guides) {
  constexpr uint32_t kVertices = 32;
  constexpr float kLength = 0.17f, kBegin = -0.9f;  // m; rad from the top
  HairAsset hair = emptyHair(guides, kVertices);
  Random random(11);
  for (uint32_t i = 0; i < guides; ++i) {
    const float share = (static_cast<float>(i) + random.uniform()) / static_cast<float>(guides);
    const float radius = kRollRadius + 0.0005f + 0.003f * random.uniform();
    const float length = kLength * (1 - 0.12f * random.uniform());
    const float phase = 2 * kPi * random.uniform(), stray = 0.002f * random.uniform();
    hair.strandUv.push_back({share, random.uniform()});
    for (uint32_t v = 0; v < kVertices; ++v) {
      const float s = length * static_cast<float>(v) / (kVertices - 1);
      const float angle = std::min(kBegin + s / radius, kPi / 2);
      const float below = std::max(s - (kPi / 2 - kBegin) * radius, 0.0f);
      const float x = kRollHalf * (2 * share - 1) + stray * std::sin(phase + 60 * s);
      addVertex(hair, {x, radius * std::cos(angle) - below, radius * std::sin(angle)});
    }
  }
  return hair;
}

constexpr float kSleeveRadius = 0.022f, kSleeveHalf = 0.07f;  // m

HairAsset makeSleeve(std::vector<BoneInfluences>& influences) {
  constexpr uint32_t kGuides = 2600, kVertices = 6;
  constexpr float kLength = 0.012f, kBlend = 0.035f;  // m
  HairAsset hair = emptyHair(kGuides, kVertices);
  Random random(13);
  for (uint32_t i = 0; i < kGuides; ++i) {
    const float share = (static_cast<float>(i) + 0.5f) / kGuides;
    const float x = kSleeveHalf * (2 * share - 1), turn = static_cast<float>(i) * kGoldenAngle;
    const float length = kLength * (1 - 0.3f * random.uniform());
    for (uint32_t v = 0; v < kVertices; ++v) {
      const float s = length * static_cast<float>(v) / (kVertices - 1);
      addVertex(hair, {x + 0.5f * s, (kSleeveRadius + s) * std::cos(turn),
                       (kSleeveRadius + s) * std::sin(turn)});
    }
    const float t = std::clamp(0.5f + 0.5f * x / kBlend, 0.0f, 1.0f);
    BoneInfluences influence;
    influence.bones[1] = 1;
    influence.weights[0] = 1 - t;
    influence.weights[1] = t;
    influences.push_back(influence);
  }
  return hair;
}

void finishMesh(CollisionMesh& mesh) {
  BoneInfluences influence;
  influence.weights[0] = 1;
  mesh.bones = {{0, "bone"}};
  mesh.influences.assign(mesh.positions.size(), influence);
}

// The roll's surface without its ends.
CollisionMesh makeRoll() {
  CollisionMesh mesh;
  for (uint32_t i = 0; i <= kBallSectors; ++i) {
    const float angle = 2 * kPi * static_cast<float>(i) / kBallSectors;
    for (const float x : {-kRollHalf, kRollHalf}) {
      mesh.positions.push_back({x, kRollRadius * std::cos(angle), kRollRadius * std::sin(angle)});
      mesh.normals.push_back({0, std::cos(angle), std::sin(angle)});
    }
    if (i < kBallSectors)
      for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) mesh.indices.push_back(2 * i + corner);
  }
  finishMesh(mesh);
  return mesh;
}

}  // namespace

CollisionMesh makeCapsule(const Float3& head, float headRadius, const Float3& tail,
                          float tailRadius) {
  const Float3 along = add(tail, head, -1);
  const bool isBall = along == Float3{};
  const Float3 axis = isBall ? Float3{0, 1, 0} : unit(add({}, along, -1));
  const Float3 across =
      unit(cross(axis, std::abs(axis.x) < 0.9f ? Float3{1, 0, 0} : Float3{0, 0, 1}));
  const Float3 other = cross(across, axis);
  CollisionMesh mesh;
  const auto addPoint = [&](float height, float ring, float angle) {
    Float3 normal = add({}, axis, height);
    normal = add(normal, across, ring * std::cos(angle));
    normal = add(normal, other, ring * std::sin(angle));
    mesh.normals.push_back(normal);
    mesh.positions.push_back(height > 0 ? add(head, normal, headRadius)
                                        : add(tail, normal, tailRadius));
  };
  addPoint(1, 0, 0);
  for (uint32_t ring = 1; ring < kBallRings; ++ring) {
    const float polar = kPi * static_cast<float>(ring) / kBallRings;
    for (uint32_t i = 0; i < kBallSectors; ++i)
      addPoint(std::cos(polar), std::sin(polar), 2 * kPi * static_cast<float>(i) / kBallSectors);
  }
  addPoint(-1, 0, 0);
  const auto slot = [](uint32_t ring, uint32_t i) {
    return 1 + (ring - 1) * kBallSectors + i % kBallSectors;
  };
  const uint32_t last = 1 + (kBallRings - 1) * kBallSectors;
  for (uint32_t i = 0; i < kBallSectors; ++i) {
    mesh.indices.insert(mesh.indices.end(), {0, slot(1, i + 1), slot(1, i)});
    for (uint32_t ring = 1; ring + 1 < kBallRings; ++ring)
      mesh.indices.insert(mesh.indices.end(),
                          {slot(ring, i), slot(ring, i + 1), slot(ring + 1, i), slot(ring + 1, i),
                           slot(ring, i + 1), slot(ring + 1, i + 1)});
    mesh.indices.insert(mesh.indices.end(),
                        {slot(kBallRings - 1, i), slot(kBallRings - 1, i + 1), last});
  }
  finishMesh(mesh);
  return mesh;
}

Result<SubjectAssets> makeSubject(const Setup& setup) {
  SubjectAssets assets;
  switch (setup.subject) {
    case Subject::kLock:
      assets.hair = makeLock(setup.lock);
      assets.body = makeCapsule({}, setup.lock.ballRadius, {}, setup.lock.ballRadius);
      break;
    case Subject::kSwatch:
      assets.hair = makeSwatch(setup.swatchGuides);
      if (setup.hasRoll) {
        assets.body = makeRoll();
        assets.scalp.assign(assets.body->positions.size(), 1.0f);
      }
      break;
    case Subject::kSleeve:
      assets.hair = makeSleeve(assets.influences);
      assets.boneCount = 2;
      break;
    case Subject::kHead: {
      auto groom = pelage::generateGroom(setup.groom);
      if (!groom) return groom.error();
      assets.hair = std::move(groom->hair);
      assets.influences = std::move(groom->bones.strands);
      assets.boneCount = 2;
      assets.body = std::move(groom->head);
      assets.scalp = coveredShares(*assets.body, assets.hair, kScalpRange * groom->rootSpacing);
      break;
    }
  }
  if (Result<void> done = assets.hair.process(setup.process); !done) return done.error();
  return assets;
}

}  // namespace sample
