// The generated character: its meshes, its hair, its motions.
#include "pelage/demo/character.h"
#include "support/extremes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "support/errors.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;
using test::required;
using test::valueOf;

CharacterDef smallCharacter() {
  CharacterDef def;
  def.cellSize = 0.006f;
  def.colliderCellSize = 0.012f;
  def.longHair = {120, 16, 0.30f};
  def.fur = {400, 8, 0.030f};
  def.mohawk = {60, 10, 0.09f};
  return def;
}

const Character& shared() {
  static const Character made = valueOf(generateCharacter(smallCharacter()));
  return made;
}

const CharacterGroom& longHair() { return shared().grooms[0]; }
const CharacterGroom& fur() { return shared().grooms[1]; }
const CharacterGroom& mohawk() { return shared().grooms[2]; }

constexpr CharacterMotion kMotions[] = {CharacterMotion::kBind, CharacterMotion::kIdle,
                                        CharacterMotion::kWalk, CharacterMotion::kHeadShake,
                                        CharacterMotion::kJump, CharacterMotion::kAll};

Float3 pointOf(const Float4& p) { return {p.x, p.y, p.z}; }

double distance(const Float3& a, const Float3& b) {
  return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

// Unit vector away from the body.
Float3 normalAt(const Float3& p) {
  constexpr float h = 1e-3f;
  const float x = characterDistance({p.x + h, p.y, p.z}) - characterDistance({p.x - h, p.y, p.z});
  const float y = characterDistance({p.x, p.y + h, p.z}) - characterDistance({p.x, p.y - h, p.z});
  const float z = characterDistance({p.x, p.y, p.z + h}) - characterDistance({p.x, p.y, p.z - h});
  const float scale = 1 / std::sqrt(x * x + y * y + z * z);
  return {x * scale, y * scale, z * scale};
}

// Mean sine of the angle between the skin at the roots and the way to the tips.
double meanRise(const CharacterGroom& groom) {
  double sum = 0;
  const uint32_t count = groom.hair.verticesPerStrand;
  for (uint32_t s = 0; s < groom.hair.strandCount; ++s) {
    const Float3 root = pointOf(groom.hair.positions[size_t{s} * count]);
    const Float3 tip = pointOf(groom.hair.positions[size_t{s} * count + count - 1]);
    const Float3 n = normalAt(root);
    sum += (n.x * (tip.x - root.x) + n.y * (tip.y - root.y) + n.z * (tip.z - root.z)) /
           distance(root, tip);
  }
  return sum / groom.hair.strandCount;
}

// FNV-1a.
class Hash {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    std::vector<unsigned char> bytes(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 1099511628211u;
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 14695981039346656037u;
};

uint64_t hashOf(const Character& character) {
  Hash hash;
  const auto addMesh = [&](const CollisionMesh& mesh) {
    hash.add(mesh.positions);
    hash.add(mesh.normals);
    hash.add(mesh.influences);
    hash.add(mesh.indices);
  };
  addMesh(character.mesh);
  for (const CharacterCollider& collider : character.colliders) addMesh(collider.mesh);
  for (const CharacterGroom& groom : character.grooms) {
    hash.add(groom.hair.positions);
    hash.add(groom.hair.strandUv);
    hash.add(groom.hair.strandThickness);
    hash.add(groom.bones.strands);
  }
  for (const CharacterMotion motion : kMotions)
    for (const double seconds : {0.1, 0.55, 1.0, 1.7, 2.9, 11.3})
      hash.add(poseCharacter(motion, seconds));
  return hash.value();
}

void expectClosed(const CollisionMesh& mesh, const std::string& name) {
  const auto report = required(inspectMesh(mesh));
  EXPECT_TRUE(report->closed) << name;
  EXPECT_TRUE(report->consistentlyOriented) << name;
  EXPECT_EQ(report->nonManifoldEdges, 0u) << name;
  EXPECT_GT(report->volume, 0.0005) << name;  // cubic metres; negative would be inside out
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.influences.size(), mesh.positions.size());
}

TEST(CharacterMesh, IsClosedAndLooksOutward) {
  expectClosed(shared().mesh, "mesh");
  int wrong = 0;
  const CollisionMesh& mesh = shared().mesh;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    ASSERT_NEAR(characterDistance(mesh.positions[i]), 0, 5e-4);
    const Float3& n = mesh.normals[i];
    ASSERT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1, 1e-5);
    const Float3 m = normalAt(mesh.positions[i]);
    if (n.x * m.x + n.y * m.y + n.z * m.z < 0.5f) ++wrong;
  }
  EXPECT_LT(wrong, static_cast<int>(mesh.positions.size() / 100));  // creases of the face
}

TEST(CharacterMesh, IsMadeOfPartsThatCoverIt) {
  ASSERT_EQ(shared().parts.size(), 3u);
  uint32_t next = 0;
  for (const CharacterPart& part : shared().parts) {
    EXPECT_EQ(part.firstIndex, next);
    EXPECT_GT(part.indexCount, 0u);
    EXPECT_EQ(part.indexCount % 3, 0u);
    next += part.indexCount;
  }
  EXPECT_EQ(next, shared().mesh.indices.size());
}

TEST(CharacterMesh, HasCollidersThatAreClosedAndWithinIt) {
  for (const CharacterCollider& collider : shared().colliders) {
    expectClosed(collider.mesh, collider.name);
    const bool body = collider.name == "body";
    for (const Float3& p : collider.mesh.positions) {
      // The ears of the body are smoothed over.
      ASSERT_LT(characterDistance(p), body ? 0.012f : 5e-4f) << collider.name;
      if (!body) {
        ASSERT_EQ(p.x > 0, collider.name == "leftArm");
      }
    }
  }
}

TEST(CharacterMesh, HasWeightsThatSumTo1AndAreSmooth) {
  const CollisionMesh& mesh = shared().mesh;
  const size_t bones = shared().skeleton.bones.size();
  ASSERT_EQ(bones, 13u);
  std::vector<std::vector<float>> dense(mesh.positions.size(), std::vector<float>(bones));
  for (size_t v = 0; v < dense.size(); ++v) {
    float sum = 0;
    for (int i = 0; i < 4; ++i) {
      const BoneInfluences& from = mesh.influences[v];
      ASSERT_GE(from.weights[i], 0);
      ASSERT_LT(from.bones[i], bones);
      dense[v][from.bones[i]] += from.weights[i];
      sum += from.weights[i];
    }
    ASSERT_NEAR(sum, 1, 1e-6);
  }
  std::vector<float> most(bones);
  for (size_t t = 0; t < mesh.indices.size(); ++t) {
    const uint32_t a = mesh.indices[t], b = mesh.indices[t % 3 == 2 ? t - 2 : t + 1];
    const double length = std::max(distance(mesh.positions[a], mesh.positions[b]), 0.003);
    for (size_t bone = 0; bone < bones; ++bone) {
      test::keepLargest(most[bone], dense[a][bone]);
      ASSERT_LT(std::abs(dense[a][bone] - dense[b][bone]) / length, 60) << "bone " << bone;
    }
  }
  // Every bone has skin of its own, but the collar bones share theirs.
  for (size_t bone = 0; bone < bones; ++bone)
    EXPECT_GT(most[bone], bone == 5 || bone == 9 ? 0.5f : 0.99f) << bone;
}

TEST(CharacterSkeleton, HasParentsBeforeChildrenAndMirroredArms) {
  const Skeleton skeleton = characterSkeleton();
  for (size_t i = 0; i < skeleton.bones.size(); ++i) {
    ASSERT_LT(skeleton.bones[i].parent, static_cast<int32_t>(i));
    EXPECT_EQ(shared().skeleton.bones[i].bind, skeleton.bones[i].bind);
    const std::string& name = skeleton.bones[i].name;
    if (name.find(".L") == std::string::npos) continue;
    const auto other = skeleton.find(name.substr(0, name.size() - 1) + "R");
    ASSERT_TRUE(other);
    const auto& left = skeleton.bones[i].bind.rows;
    const auto& right = skeleton.bones[*other].bind.rows;
    EXPECT_EQ(left[0].w, -right[0].w);
    EXPECT_EQ(left[1].w, right[1].w);
  }
}

TEST(CharacterHair, HasRootsOnTheMeshAndNothingElseInsideTheBody) {
  for (const CharacterGroom& groom : shared().grooms) {
    const uint32_t count = groom.hair.verticesPerStrand;
    ASSERT_EQ(groom.hair.positions.size(), size_t{groom.hair.strandCount} * count);
    for (size_t i = 0; i < groom.hair.positions.size(); ++i) {
      const float d = characterDistance(pointOf(groom.hair.positions[i]));
      if (i % count == 0)
        ASSERT_NEAR(d, 0, 6e-4) << groom.name;  // a chord's height, at a radius of a centimetre
      else
        ASSERT_GT(d, 5e-4f) << groom.name << ", vertex " << i % count;
    }
  }
}

TEST(CharacterHair, GrowsWhereItBelongs) {
  const auto root = [](const CharacterGroom& groom, uint32_t s) {
    return groom.hair.positions[size_t{s} * groom.hair.verticesPerStrand];
  };
  for (uint32_t s = 0; s < longHair().hair.strandCount; ++s) {
    const Float4 p = root(longHair(), s);
    EXPECT_GT(p.y, 0.14f);
    EXPECT_FALSE(std::abs(p.x) < 0.015f && p.z > -0.03f) << "in the strip of the mohawk";
    EXPECT_FALSE(p.z > 0.05f && p.y < 0.25f) << "in the face";
  }
  for (uint32_t s = 0; s < mohawk().hair.strandCount; ++s)
    EXPECT_LT(std::abs(root(mohawk(), s).x), 0.0195f);
  uint32_t front = 0, back = 0, left = 0, right = 0;
  for (uint32_t s = 0; s < fur().hair.strandCount; ++s) {
    const Float4 p = root(fur(), s);
    EXPECT_LT(p.y, 0.06f);
    front += p.z > 0.02f;
    back += p.z < -0.09f;
    left += p.x > 0.20f;
    right += p.x < -0.20f;
  }
  for (const uint32_t part : {front, back, left, right})
    EXPECT_GT(part, fur().hair.strandCount / 40);
}

TEST(CharacterHair, LiesAlongTheSkinAsFurAndStandsUpAsMohawk) {
  EXPECT_LT(meanRise(fur()), 0.35);
  EXPECT_GT(meanRise(mohawk()), 0.8);
}

TEST(CharacterHair, LongHairReachesTheShoulders) {
  const HairAsset& hair = longHair().hair;
  uint32_t low = 0;
  for (uint32_t s = 0; s < hair.strandCount; ++s)
    low += hair.positions[size_t{s + 1} * hair.verticesPerStrand - 1].y < 0.04f;
  EXPECT_GT(low, hair.strandCount / 2);
}

TEST(CharacterHair, HasBonesThatMoveTheSkinUnderIt) {
  // A pose far from the bind pose: roots stay on the skin's moved vertices.
  const Skeleton& skeleton = shared().skeleton;
  const auto pose = skinningTransforms(skeleton, poseCharacter(CharacterMotion::kAll, 0.75));
  const auto moved = [&](const BoneInfluences& from, const Float3& p) {
    Float3 sum;
    for (int i = 0; i < 4; ++i) {
      const Float3 q = transformPoint(pose[from.bones[i]], p);
      sum = {sum.x + from.weights[i] * q.x, sum.y + from.weights[i] * q.y,
             sum.z + from.weights[i] * q.z};
    }
    return sum;
  };
  const CollisionMesh& mesh = shared().mesh;
  for (const CharacterGroom& groom : shared().grooms)
    for (uint32_t s = 0; s < groom.hair.strandCount; s += 7) {
      const Float3 root = pointOf(groom.hair.positions[size_t{s} * groom.hair.verticesPerStrand]);
      size_t nearest = 0;
      for (size_t v = 0; v < mesh.positions.size(); ++v)
        if (distance(mesh.positions[v], root) < distance(mesh.positions[nearest], root))
          nearest = v;
      const double before = distance(mesh.positions[nearest], root);
      const double after = distance(moved(mesh.influences[nearest], mesh.positions[nearest]),
                                    moved(groom.bones.strands[s], root));
      ASSERT_LT(after, 1.6 * before + 5e-4) << groom.name << " " << s;
    }
}

double maxStep(const std::vector<AffineTransform>& a, const std::vector<AffineTransform>& b) {
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i)
    // A point a hand's length from the joint, along each axis.
    for (const Float3& p : {Float3{0.1f, 0, 0}, Float3{0, 0.1f, 0}, Float3{0, 0, 0.1f}})
      test::keepLargest(largest, distance(transformPoint(a[i], p), transformPoint(b[i], p)));
  return largest;
}

TEST(CharacterMotions, StartAtRestInTheBindPose) {
  const Skeleton skeleton = characterSkeleton();
  for (const CharacterMotion motion : kMotions) {
    for (const double seconds : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      const auto pose = poseCharacter(motion, seconds);
      ASSERT_EQ(pose.size(), skeleton.bones.size());
      for (size_t i = 0; i < pose.size(); ++i)
        for (int row = 0; row < 3; ++row) {
          EXPECT_NEAR(pose[i].rows[row].w, skeleton.bones[i].bind.rows[row].w, 1e-6);
          EXPECT_NEAR((&pose[i].rows[row].x)[row], 1, 1e-6);
        }
    }
    // At rest: after a hundredth of a second it has hardly moved.
    EXPECT_LT(maxStep(poseCharacter(motion, 0), poseCharacter(motion, 0.01)), 5e-4);
  }
}

TEST(CharacterMotions, AreContinuousInPlaceAndVelocity) {
  constexpr double h = 1.0 / 480;
  for (const CharacterMotion motion : kMotions) {
    std::vector<AffineTransform> before = poseCharacter(motion, 0), here = poseCharacter(motion, h);
    for (int i = 2; i * h < 9; ++i) {
      const auto next = poseCharacter(motion, i * h);
      double rotation = 0;  // change of velocity [m/s] of points near the joints
      for (size_t b = 0; b < next.size(); ++b)
        for (const Float3& p : {Float3{0, 0, 0}, Float3{0, 0.1f, 0}, Float3{0, 0, 0.1f}}) {
          const Float3 x = transformPoint(before[b], p), y = transformPoint(here[b], p),
                       z = transformPoint(next[b], p);
          test::keepLargest(
              rotation,
              distance({z.x - y.x, z.y - y.y, z.z - y.z}, {y.x - x.x, y.y - x.y, y.z - x.z}) / h);
        }
      ASSERT_LT(maxStep(here, next), 6 * h) << static_cast<int>(motion) << " at " << i * h;
      ASSERT_LT(rotation, 90 * h) << static_cast<int>(motion) << " at " << i * h;  // 9 g
      before = here;
      here = next;
    }
  }
}

TEST(CharacterMotions, RepeatTheirCycle) {
  for (const CharacterMotion motion : kMotions) {
    const CharacterCycle cycle = characterCycle(motion);
    const auto start = poseCharacter(motion, cycle.start);
    EXPECT_LT(maxStep(start, poseCharacter(motion, cycle.end)), 1e-6);
    const double length = cycle.end - cycle.start;
    EXPECT_LT(maxStep(poseCharacter(motion, cycle.start + 0.3 * length),
                      poseCharacter(motion, cycle.start + 7.3 * length)),
              1e-5);
    if (motion == CharacterMotion::kBind) continue;
    EXPECT_GT(maxStep(start, poseCharacter(motion, cycle.start + 0.3 * length)), 0.004);
  }
}

TEST(CharacterMotions, FallFreelyInTheAir) {
  double highest = 0;
  for (double t = 0.50; t < 0.74; t += 0.02) {
    constexpr double h = 0.01;
    const auto height = [](double s) {
      return double{poseCharacter(CharacterMotion::kJump, s)[0].rows[1].w};
    };
    EXPECT_NEAR((height(t + h) - 2 * height(t) + height(t - h)) / (h * h), -9.81, 0.01);
    test::keepLargest(highest, height(t) - height(0));
  }
  EXPECT_GT(highest, 0.1);
}

TEST(Character, IsTheSameForEqualDefinitionsOnEveryMachine) {  // K24
  const auto again = required(generateCharacter(smallCharacter()));
  EXPECT_EQ(hashOf(*again), hashOf(shared()));
  // Computed once; another compiler, option or machine must not change it. A change of the
  // character does.
  EXPECT_EQ(hashOf(shared()), 13187475383170598508u);
  CharacterDef other = smallCharacter();
  other.seed = 2;
  const auto different = required(generateCharacter(other));
  EXPECT_NE(hashOf(*different), hashOf(shared()));
  EXPECT_EQ(different->mesh.positions, shared().mesh.positions);
}

TEST(Character, HasAsMuchHairAsWasAskedForAndTakesTheEdgesOfItsRanges) {
  for (const auto& change : std::vector<void (*)(CharacterDef&)>{
           [](CharacterDef&) {},
           [](CharacterDef& d) {
             d.longHair = {1, 2, 0.6f}, d.fur = {1, 2, 0.005f};
           },
           [](CharacterDef& d) {
             d.longHair = {8, 256, 0.005f}, d.mohawk = {3, 256, 0.6f};
           },
           [](CharacterDef& d) {
             d.fur = {9, 64, 0.6f}, d.mohawk = {1, 2, 0.005f};
           }}) {
    CharacterDef def = smallCharacter();
    def.fur.strandCount = 20;
    change(def);
    auto character = required(generateCharacter(def));
    const CharacterHairDef sizes[] = {def.longHair, def.fur, def.mohawk};
    for (size_t i = 0; i < 3; ++i) {
      HairAsset& hair = character->grooms[i].hair;
      EXPECT_EQ(hair.strandCount, sizes[i].strandCount);
      EXPECT_EQ(hair.verticesPerStrand, sizes[i].verticesPerStrand);
      EXPECT_EQ(character->grooms[i].bones.strands.size(), sizes[i].strandCount);
      EXPECT_TRUE(hair.process());
      EXPECT_TRUE(validate(character->grooms[i].settings));
      EXPECT_TRUE(hair.generateFollowHairs(character->grooms[i].follow));
    }
  }
}

TEST(Character, RefusesValuesOutOfRangeByName) {
  const auto refused = [](auto change, const char* field) {
    CharacterDef def = smallCharacter();
    change(def);
    expectError(generateCharacter(def), {field});
  };
  refused([](CharacterDef& d) { d.cellSize = 0.001f; }, "cellSize");
  refused([](CharacterDef& d) { d.cellSize = kNan; }, "cellSize");
  refused([](CharacterDef& d) { d.colliderCellSize = 0.02f; }, "colliderCellSize");
  refused([](CharacterDef& d) { d.longHair.strandCount = 0; }, "longHair.strandCount");
  refused([](CharacterDef& d) { d.fur.verticesPerStrand = 1; }, "fur.verticesPerStrand");
  refused([](CharacterDef& d) { d.fur.strandCount = 1'000'001; }, "fur.strandCount");
  refused([](CharacterDef& d) { d.mohawk.length = 0; }, "mohawk.length");
  refused([](CharacterDef& d) { d.mohawk.verticesPerStrand = 257; }, "mohawk.verticesPerStrand");
}

}  // namespace
}  // namespace pelage
