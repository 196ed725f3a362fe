// The character: its meshes, and the hair on it.
#include "pelage/demo/character.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/guard.h"
#include "base/portable_math.h"
#include "character_body.h"
#include "head.h"
#include "implicit_shapes.h"
#include "pelage/demo/groom.h"

namespace pelage {
namespace {

using detail::HairGround;
using detail::saturate;
using detail::smoothStep;
using detail::Solid;
using detail::SolidBox;
using detail::SurfaceMesh;
using detail::Vector;

class WholeBody : public Solid {
 public:
  double distance(const Vector& p) const override { return detail::characterSurface(p); }
  Vector normal(const Vector& p) const override { return detail::characterNormal(p); }
};

class Trunk : public Solid {
 public:
  double distance(const Vector& p) const override { return detail::trunkSurface(p); }
  Vector normal(const Vector& p) const override { return gradientOf(p, detail::trunkSurface); }
};

class LeftArm : public Solid {
 public:
  double distance(const Vector& p) const override { return detail::leftArmSurface(p); }
  Vector normal(const Vector& p) const override { return gradientOf(p, detail::leftArmSurface); }
};

constexpr SolidBox kWholeBox = {{-0.53, -0.53, -0.16}, {0.53, 0.35, 0.14}};
constexpr SolidBox kTrunkBox = {{-0.23, -0.50, -0.16}, {0.23, 0.35, 0.14}};
constexpr SolidBox kLeftArmBox = {{0.05, -0.53, -0.11}, {0.53, 0.02, 0.07}};

// A mesh and its normals and bones; `mirror` turns a left arm into a right one.
CollisionMesh skinned(const SurfaceMesh& from, const Solid& solid, bool mirror = false) {
  CollisionMesh mesh;
  const Skeleton skeleton = characterSkeleton();
  for (uint32_t i = 0; i < skeleton.bones.size(); ++i)
    mesh.bones.push_back({i, skeleton.bones[i].name});
  const double side = mirror ? -1 : 1;
  for (const Vector& p : from.vertices) {
    const Vector n = solid.normal(p), q = {side * p.x, p.y, p.z};
    mesh.positions.push_back(detail::toFloat3(q));
    mesh.normals.push_back(detail::toFloat3({side * n.x, n.y, n.z}));
    mesh.influences.push_back(detail::characterBones(q));
  }
  mesh.indices = from.indices;
  if (mirror)
    for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3)
      std::swap(mesh.indices[t + 1], mesh.indices[t + 2]);
  return mesh;
}

// The body as ground of all grooms; where they grow and how they are combed is their own.
class Skin : public HairGround {
 public:
  double surface(const Vector& p) const override { return detail::characterSurface(p); }
  Vector normal(const Vector& p) const override { return detail::characterNormal(p); }
  double combedSurface(const Vector& p) const override { return detail::combedCharacter(p); }
  Vector combedNormal(const Vector& p) const override { return detail::combedCharacterNormal(p); }
  Vector rootNormal(const Vector& p) const override { return detail::characterSkullNormal(p); }

 protected:
  static Vector tangent(const Vector& flow, const Vector& normal) {
    return normalizeOr(flow - normal * dot(flow, normal), Vector{0, 0, -1});
  }
};

class LongHair : public Skin {
 public:
  bool grows(const Vector& p) const override {
    return p.y > 0.1 && detail::isScalp(p, 0) && !detail::isMohawkStrip(p);
  }
  Vector combDirection(const Vector& p, const Vector& normal) const override {
    // On the head away from the mohawk, off the face, and down; on the shoulders to the front or to
    // the back.
    const double side = p.x < 0 ? -1 : 1;
    const double top = smoothStep(0.20, 0.31, p.y);
    const double beside = std::min(std::abs(p.x) / 0.03, 1.0);
    const double back = 1 - smoothStep(-0.10, -0.03, p.z);
    Vector flow = {side * beside * (0.15 + 0.85 * top) * (1 - 0.8 * back), 0, 0};
    // Below the mohawk both sides meet.
    const double nape = back * (1 - smoothStep(0.19, 0.26, p.y));
    flow.x += (std::min(std::max(-18 * p.x, -0.8), 0.8) - flow.x) * nape;
    flow.z = -1.1 * smoothStep(-0.05, 0.06, p.z) - 0.5 * back * top;
    flow.y = -0.35 - 0.65 * (1 - top);
    const double shoulder = 1 - smoothStep(0.000, 0.070, p.y);
    const double forwards = 2 * smoothStep(-0.075, -0.015, p.z) - 1;
    const Vector down = {0.25 * side, -0.8, forwards};
    return tangent(lerp(flow, down, shoulder), normal);
  }
  double height(const Vector& root) const override { return smoothStep(0.15, 0.31, root.y); }
  double insideEdge(const Vector& root) const override { return detail::insideHairline(root, 0); }
  double lengthShare(const Vector& root) const override {
    // Hair from below ends where that from above does.
    return 0.72 + 0.28 * smoothStep(0.15, 0.31, root.y);
  }
};

class Mohawk : public Skin {
 public:
  bool grows(const Vector& p) const override {
    return p.y > 0.17 && detail::isScalp(p, 0) && detail::isMohawkStrip(p);
  }
  Vector combDirection(const Vector& p, const Vector& normal) const override {
    const double back = 1 - smoothStep(-0.09, 0.0, p.z);
    return tangent({-2.0 * p.x, -0.25 - back, back - 1}, normal);
  }
  double height(const Vector& /*root*/) const override { return 1; }
  double lengthShare(const Vector& root) const override {
    // Highest over the crown.
    return 0.55 +
           0.45 * smoothStep(0.19, 0.30, root.y) * (1 - 0.35 * smoothStep(0.0, 0.09, root.z));
  }
};

class Fur : public Skin {
 public:
  bool grows(const Vector& p) const override { return detail::furShare(p) > 0.15; }
  Vector combDirection(const Vector& p, const Vector& normal) const override {
    // Down, and on the arms along them; from the shoulders outwards.
    const detail::ArmJoints joints = detail::leftArmJoints();
    const double side = p.x < 0 ? -1 : 1;
    Vector along = normalizeOr(joints.elbow - joints.shoulder, Vector{0, -1, 0});
    along.x *= side;
    const double out = smoothStep(0.03, 0.13, std::abs(p.x)) * smoothStep(-0.13, -0.03, p.y);
    const Vector down = {0.12 * side, -1, 0};
    const double arm = smoothStep(0.13, 0.19, std::abs(p.x) - 0.3 * std::min(p.y + 0.06, 0.0));
    return tangent(lerp(down, along, std::max(out, arm)), normal);
  }
  double height(const Vector& /*root*/) const override { return 1; }
  double lengthShare(const Vector& root) const override {
    return 0.30 + 0.70 * smoothStep(0.10, 0.75, detail::furShare(root));
  }
};

GroomDef groomDef(const CharacterHairDef& size, uint64_t seed) {
  GroomDef def;
  def.seed = seed;
  def.strandCount = size.strandCount;
  def.verticesPerStrand = size.verticesPerStrand;
  def.length = size.length;
  return def;
}

GroomDef longHairDef(const CharacterDef& character) {
  GroomDef def = groomDef(character.longHair, character.seed);
  def.lengthVariation = 0.04f;
  def.lift = 0.35f;
  def.volume = 0.010f;
  def.comb = 30;
  def.droop = 20;
  def.curlRadius = 0.004f;
  def.curlFrequency = 9;
  def.clumpCount = std::min(160u, character.longHair.strandCount / 4);
  def.clumpStrength = 0.45f;
  def.clumpLengthVariation = 0.05f;
  def.clumpTaper = 0.08f;
  def.hairlineFade = 0.014f;
  def.noise = 0.004f;
  return def;
}

GroomDef furDef(const CharacterDef& character) {
  GroomDef def = groomDef(character.fur, character.seed + 1);
  def.lengthVariation = 0.35f;
  def.lift = 0.38f;
  def.volume = 0.004f;
  def.comb = 40;
  def.droop = 0;
  def.curlRadius = 0.0006f;
  def.curlFrequency = 40;
  def.clumpCount = std::min(900u, character.fur.strandCount / 4);
  def.clumpStrength = 0.35f;
  def.noise = 0.003f;
  return def;
}

GroomDef mohawkDef(const CharacterDef& character) {
  GroomDef def = groomDef(character.mohawk, character.seed + 2);
  def.lengthVariation = 0.12f;
  def.lift = 1.45f;
  def.comb = 3;
  def.droop = 0.5f;
  def.curlRadius = 0.001f;
  def.clumpCount = std::min(60u, character.mohawk.strandCount / 4);
  def.clumpStrength = 0.5f;
  def.noise = 0.003f;
  return def;
}

void setLongHairLook(CharacterGroom& groom) {
  groom.material.rootColor = {0.018f, 0.009f, 0.006f};
  groom.material.tipColor = {0.110f, 0.052f, 0.026f};
  groom.material.colorVariation = 0.25f;
  groom.material.fiberRadius = 150e-6f;
  groom.material.tipRadiusRatio = 0.15f;
  groom.settings.damping = 0.09f;
  groom.settings.bendLength = 0.09f;
  groom.settings.globalStiffness = 0.03f;
  groom.settings.globalRange = 0.3f;
  groom.settings.vspCoefficient = 0.4f;
  groom.follow = {
      .countPerGuide = 12, .maxRadius = 0.006f, .tipSeparation = 0.6f, .flyaways = 0.03f};
}

void setFurLook(CharacterGroom& groom) {
  groom.material.rootColor = {0.050f, 0.032f, 0.020f};
  groom.material.tipColor = {0.400f, 0.290f, 0.180f};
  groom.material.colorVariation = 0.3f;
  groom.material.fiberRadius = 130e-6f;
  groom.material.longitudinalRoughness = 0.45f;
  groom.settings.damping = 0.10f;
  groom.settings.bendLength = 0.12f;
  groom.settings.globalStiffness = 0.35f;
  groom.settings.globalRange = 1;
  groom.settings.vspCoefficient = 0.5f;
  groom.follow = {.countPerGuide = 6, .maxRadius = 0.006f};
}

void setMohawkLook(CharacterGroom& groom) {
  groom.material.rootColor = {0.070f, 0.009f, 0.003f};
  groom.material.tipColor = {0.340f, 0.050f, 0.008f};
  groom.material.colorVariation = 0.25f;
  groom.material.fiberRadius = 130e-6f;
  groom.material.tipRadiusRatio = 0.15f;
  groom.settings.damping = 0.06f;
  groom.settings.bendLength = 0.30f;
  groom.settings.globalStiffness = 0.22f;
  groom.settings.globalRange = 0.6f;
  groom.settings.vspCoefficient = 0.3f;
  groom.follow = {.countPerGuide = 10, .maxRadius = 0.004f, .flyaways = 0.03f};
}

CharacterGroom growGroom(std::string name, const GroomDef& def, const HairGround& ground,
                         const CollisionMesh& mesh) {
  CharacterGroom groom;
  groom.name = std::move(name);
  Random random(def.seed);
  const detail::HairRoots sample = detail::sampleRoots(mesh, ground, def.strandCount, random);
  // Roots are rounded to float: keep the promise all the same.
  groom.rootSpacing = static_cast<float>(sample.spacing - 1e-7);
  const detail::HairGrower grower(def, ground, sample.roots);
  HairAsset& hair = groom.hair;
  hair.strandCount = def.strandCount;
  hair.verticesPerStrand = def.verticesPerStrand;
  hair.positions.reserve(size_t{def.strandCount} * def.verticesPerStrand);
  groom.bones.bones = mesh.bones;
  for (uint32_t i = 0; i < def.strandCount; ++i) {
    const detail::Path vertices = grower.strand(i);
    for (uint32_t k = 0; k < def.verticesPerStrand; ++k) {
      const Float3 p = detail::toFloat3(vertices[k]);
      hair.positions.push_back({p.x, p.y, p.z, k < 2 ? 0.0f : 1.0f});
    }
    // From the front.
    const Vector& root = sample.roots[i].position;
    hair.strandUv.push_back({static_cast<float>(saturate(0.5 + root.x / 0.7)),
                             static_cast<float>(saturate((root.y + 0.47) / 0.81))});
    hair.strandThickness.push_back(grower.thickness(i));
    groom.bones.strands.push_back(detail::characterBones(root));
  }
  return groom;
}

// Sorts the triangles by what is on them.
std::vector<CharacterPart> sortParts(CollisionMesh& mesh) {
  std::vector<CharacterPart> parts = {{"skin", {0.50f, 0.355f, 0.285f}},
                                      {"scalp", {0.060f, 0.034f, 0.024f}},
                                      {"coat", {0.110f, 0.075f, 0.048f}}};
  std::vector<std::vector<uint32_t>> sorted(parts.size());
  for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    Vector middle;
    for (size_t k = 0; k < 3; ++k) {
      const Float3& p = mesh.positions[mesh.indices[t + k]];
      middle += Vector{p.x, p.y, p.z} * (1.0 / 3);
    }
    const bool scalp = middle.y > 0.1 && detail::isScalp(middle, 0);
    const size_t part = scalp ? 1 : middle.y < 0.1 && detail::furShare(middle) > 0.3 ? 2 : 0;
    sorted[part].insert(sorted[part].end(),
                        {mesh.indices[t], mesh.indices[t + 1], mesh.indices[t + 2]});
  }
  mesh.indices.clear();
  for (size_t i = 0; i < parts.size(); ++i) {
    parts[i].firstIndex = static_cast<uint32_t>(mesh.indices.size());
    parts[i].indexCount = static_cast<uint32_t>(sorted[i].size());
    mesh.indices.insert(mesh.indices.end(), sorted[i].begin(), sorted[i].end());
  }
  return parts;
}

Result<void> check(const CharacterDef& def) {
  const auto outside = [](const std::string& field, auto value, auto low, auto high) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("CharacterDef::{} is {}; it must be {} to {}", field, value, low, high)};
  };
  const auto bad = [](float value, float low, float high) {
    return !(value >= low && value <= high);  // true for NaN
  };
  if (bad(def.cellSize, 0.0025f, 0.006f)) return outside("cellSize", def.cellSize, 0.0025f, 0.006f);
  if (bad(def.colliderCellSize, 0.005f, 0.012f))
    return outside("colliderCellSize", def.colliderCellSize, 0.005f, 0.012f);
  const std::pair<const char*, const CharacterHairDef&> grooms[] = {
      {"longHair", def.longHair}, {"fur", def.fur}, {"mohawk", def.mohawk}};
  for (const auto& [name, groom] : grooms) {
    const auto field = [&, prefix = std::string(name)](const char* what) {
      return prefix + "." + what;
    };
    if (groom.strandCount < 1 || groom.strandCount > 1'000'000)
      return outside(field("strandCount"), groom.strandCount, 1, 1'000'000);
    if (groom.verticesPerStrand < kMinVerticesPerStrand ||
        groom.verticesPerStrand > kMaxVerticesPerStrand)
      return outside(field("verticesPerStrand"), groom.verticesPerStrand, 2, 256);
    if (bad(groom.length, 0.005f, 0.6f))
      return outside(field("length"), groom.length, 0.005f, 0.6f);
  }
  return {};
}

Result<Character> generate(const CharacterDef& def) {
  if (Result<void> valid = check(def); !valid) return valid.error();
  Character character;
  character.skeleton = characterSkeleton();
  character.mesh = skinned(meshSolid(WholeBody(), kWholeBox, def.cellSize), WholeBody());
  character.parts = sortParts(character.mesh);

  const double cell = def.colliderCellSize;
  const SurfaceMesh arm = meshSolid(LeftArm(), kLeftArmBox, cell);
  character.colliders = {{{"body", skinned(meshSolid(Trunk(), kTrunkBox, cell), Trunk())},
                          {"leftArm", skinned(arm, LeftArm())},
                          {"rightArm", skinned(arm, LeftArm(), true)}}};

  character.grooms = {{growGroom("long", longHairDef(def), LongHair(), character.mesh),
                       growGroom("fur", furDef(def), Fur(), character.mesh),
                       growGroom("mohawk", mohawkDef(def), Mohawk(), character.mesh)}};
  setLongHairLook(character.grooms[0]);
  setFurLook(character.grooms[1]);
  setMohawkLook(character.grooms[2]);
  for (CharacterGroom& groom : character.grooms) groom.follow.seed = def.seed;
  return character;
}

}  // namespace

Result<Character> generateCharacter(const CharacterDef& def) {
  return detail::guarded([&] { return generate(def); });
}

}  // namespace pelage
