// A procedural character, made by code alone: a body from the head to the hips with two arms, its
// skeleton, three grooms, three colliders, and motions. Samples, tests and benchmarks share it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "pelage/skeleton.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace pelage {

/// Size of one groom of a character.
struct CharacterHairDef {
  uint32_t strandCount = 1000;      ///< guides, 1..1,000,000
  uint32_t verticesPerStrand = 16;  ///< 2..256
  float length = 0.1f;              ///< of the longest hairs [m], 0.005..0.6
};

/// What a character is made with. Values outside of the ranges are errors that name the field.
struct CharacterDef {
  uint64_t seed = 1;        ///< another seed is other hair of the same kind on the same body
  float cellSize = 0.005f;  ///< of the drawn mesh's cells [m], 0.0025..0.006
  float colliderCellSize = 0.010f;  ///< of the colliders' [m], 0.005..0.012
  CharacterHairDef longHair = {900, 24, 0.34f};
  CharacterHairDef fur = {4000, 8, 0.030f};
  CharacterHairDef mohawk = {500, 16, 0.095f};
};

/// Triangles of the drawn mesh that are of one material.
struct CharacterPart {
  std::string name;  ///< "skin", "scalp" (under the hair of the head), "coat" (under the fur)
  Float3 color;      ///< linear RGB
  uint32_t firstIndex = 0, indexCount = 0;
};

/// One groom, and how it looks and moves at its best.
struct CharacterGroom {
  std::string name;
  HairAsset hair;     ///< process() has not been called; vertices 0 and 1 of a strand are kinematic
  BoneWeights bones;  ///< of the strands; bone indices are those of the skeleton
  float rootSpacing = 0;  ///< no two roots are closer than this [m]
  StrandMaterial material;
  SimulationSettings settings;
  FollowDef follow;  ///< for HairAsset::generateFollowHairs()
};

/// A closed mesh that hair collides with, for Scene::addCollider().
struct CharacterCollider {
  std::string name;
  CollisionMesh mesh;  ///< outward oriented, ears smoothed; bone indices are those of the skeleton
};

/// A character in bind pose: y is up, it looks along +z, +x is its left. Its head is where that of
/// generateGroom() is: chin at y = 0.10 m, top at 0.33 m; the body ends at the hips, at -0.47 m.
/// The arms hang at 50 degrees from the horizontal.
struct Character {
  CollisionMesh mesh;  ///< closed, outward oriented, unit normals; up to four bones a vertex
  std::vector<CharacterPart> parts;  ///< cover all of the mesh's indices, in their order
  /// Parents come first: hips, spine, chest, neck, head; clavicle, upperArm, forearm and hand with
  /// ".L" and ".R". Bind transforms only move.
  Skeleton skeleton;
  /// "long": on the sides and the back of the head; "fur": on shoulders, chest, back and upper
  /// arms; "mohawk": along the middle of the head.
  std::array<CharacterGroom, 3> grooms;
  /// "body" (head, neck and torso), "leftArm", "rightArm"; the arms begin inside the torso.
  std::array<CharacterCollider, 3> colliders;
};

/// Makes a character. Equal definitions give equal bits on every machine. No vertex of a strand but
/// the root, which is on the mesh, is inside the body.
/// Errors: a value out of range.
Result<Character> generateCharacter(const CharacterDef& def = {});

/// The skeleton of every character.
Skeleton characterSkeleton();

/// Distance [m] from the body's surface in bind pose, negative inside: the function that the mesh
/// is made of. It is exact at the surface and approximate elsewhere.
float characterDistance(const Float3& point);

/// What a character does. All begin at rest in the bind pose at 0 s.
enum class CharacterMotion : uint8_t {
  kBind,       ///< nothing
  kIdle,       ///< breathes and shifts its weight
  kWalk,       ///< walks on the spot
  kHeadShake,  ///< shakes its head
  kJump,       ///< crouches, jumps and lands
  kAll,        ///< walks, shakes its head and jumps
};

/// The part of a motion that repeats: its pose at `end` is that at `start` [s].
struct CharacterCycle {
  double start = 0, end = 0;
};
CharacterCycle characterCycle(CharacterMotion motion);

/// The pose of a motion: bone space to world [bone], for skinningTransforms(). Position and
/// velocity are continuous in time; in the air the body falls at 9.81 m/s2. The same bits on every
/// machine. \param seconds below 0 is the bind pose; so is a time that is not finite.
std::vector<AffineTransform> poseCharacter(CharacterMotion motion, double seconds);

}  // namespace pelage
