// What a hair object holds beside its public data.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/local_origin.h"
#include "contact/follow_contacts.h"
#include "contact/hair_contacts.h"
#include "pelage/collider.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "simulation/exact_solver.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// Ball around the bind positions of the roots that a bone moves.
struct BoneBounds {
  uint32_t bone = 0;
  Float3 center = {};
  float radius = 0;
};

/// The grid through which hair touches hair.
struct HairGrid {
  uint32_t size = 0;  ///< nodes an axis; 0: there is none
  float cell = 0;     ///< [m]
  // What it was made for.
  float cellSetting = 0;
  bool friction = false, pressure = false;

  float massScale = 0, momentumScale = 0;   ///< as in kernels/layouts/hair_grid.hlsli
  BufferId bindPoses = BufferId::kInvalid;  ///< until the rest density has been measured
  bool measured = false;
  uint32_t history = 0;  ///< steps since the last reset, at most 2
  double step = 0;       ///< the last one [s]
  Float3 middle = {};    ///< of the object in the last frame [m]
  Float3 velocity = {};  ///< of that in the last frame [m/s]
};

/// What a frame changes of an object: Scene puts it back where the frame does not run. What the
/// application sets is not part of it.
struct HairFrameState {
  std::vector<AffineTransform> bonesBefore;      ///< of the last frame; empty: to be uploaded
  std::vector<CapsuleCollider> collidersBefore;  ///< likewise
  std::vector<std::byte> fieldsBefore;           ///< contents of the buffer of fields
  uint32_t colliderCapacity = 0;                 ///< elements of the buffer
  uint32_t fieldCapacity = 0;                    ///< likewise, of that of fields

  /// Of state, roots and colliders.
  LocalOrigin origin;
  bool originKnown = false;
  /// Shift of the world that no list has yet moved the outputs by [m].
  Vector3<double> pendingShift;
  /// Largest coordinate of the shift since the last simulation [m]: for what engines round anew.
  double roundedShift = 0;
  bool followsShifted = false;  ///< not placed anew since a shift
  ShiftedFloats shiftedFloats;  ///< of what of this is in world space

  bool resetPending = true;
  /// What the solver's buffers were made for.
  std::optional<Solver> solver;
  detail::RestSets restSets;
  /// Of the last frame; a change wakes all strands.
  SimulationSettings settingsBefore;
  bool sleptBefore = false;      ///< tiles could sleep in the last frame
  bool followsCollided = false;  ///< in the last frame: followBefore is of its end
  uint32_t simulatedBefore = 0;
  uint32_t simulatedCount = 0;  ///< exact: in the last frame; 0 before the first one
  uint32_t stillFrames = 0;     ///< since the bones changed last

  HairContacts contacts;
  FollowContacts followContacts;
  HairGrid grid;

  float lastStep = 0;   ///< length of the last sub-step [s]; 0 before the first one
  float lastFrame = 0;  ///< of the last frame [s]
  detail::ExactHistory history;
  uint32_t slot = 0;  ///< exact: of the state now
  uint32_t stateStride = 0;
};

struct HairInternals : HairFrameState {
  /// Positions and rest data, to fill buffers again when the solver changes.
  HairAsset asset;
  SkinningMethod skinning = SkinningMethod::kMatrices;

  std::vector<AffineTransform> bones;
  bool bonesChanged = true;
  SkeletonInternals* skeleton = nullptr;  ///< that it follows
  uint64_t skeletonVersion = 0;           ///< of `bones`, where it does
  std::vector<BoneBounds> bounds;
  float longestStrand = 0;   ///< [m]
  float meanStrand = 0;      ///< mean length [m]
  float volume = 0;          ///< that the bind shape fills [m3]
  float followReach = 0;     ///< largest offset of a follow hair at its root, and at its tip
  float followTipReach = 0;  ///< before the setting's tipSeparation [m]
  float meanThickness = 1, largestThickness = 1;  ///< of the factors of all strands
  uint32_t textureWidth = 0, textureHeight = 0;   ///< texels of the base colour's texture

  /// Mesh colliders that it meets, ascending; nothing: all.
  std::optional<std::vector<ColliderId>> meshColliders;
  std::vector<CapsuleCollider> colliders;
  ShiftedFloats shiftedInputs;  ///< of bones and capsules

  std::vector<StrandFactors> strandFactors;
  bool levelOfDetail = false;
  bool storesFollowHairs = false;
  bool collidesFollowHairs = false;  ///< they are stored, too
  bool heldVertices = false;         ///< beyond the two at the root

  std::vector<uint32_t> hairsOfGuides;  ///< that a guide stands for, with itself
};

/// Balls around the roots of every bone; without influences all roots belong to bone 0.
std::vector<BoneBounds> boundsOfRoots(const HairAsset& asset,
                                      std::span<const BoneInfluences> influences);
/// Length of the longest strand [m].
float longestStrand(const HairAsset& asset);

/// Moves the origin after the root of the first strand.
/// \return what to add to positions relative to the old origin; 0 while it stays.
Float3 moveOrigin(HairInternals& hair);
/// Takes the world's origin to where it is after a shift: all that is known of the engine's
/// coordinates, and the hair's own origin.
void shiftWorld(HairInternals& hair, const Vector3<double>& shift, const Vector3<double>& shifted);
/// The same of a frame's state, which may be one of before.
void shiftWorld(HairFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted);
/// After a shift: capsules that moved by no more than an engine's rounding have not moved.
void forgetRounding(HairInternals& hair);
/// Around all strands in world space; a radius of infinity when a bone is not finite.
Ball ballOfStrands(const HairInternals& hair);

/// With follow hairs.
Ball ballOfHair(const HairInternals& hair, float tipSeparation);
/// Around all strands that collide.
Ball ballOfCollisions(const HairInternals& hair, float tipSeparation);
bool meets(const HairInternals& hair, ColliderId collider);

/// True for other colliders than before; those that only move are not.
bool areReplaced(std::span<const CapsuleCollider> before, std::span<const CapsuleCollider> now);
/// Colliders of this frame, of so many seconds, that reach a ball, relative to the origin.
std::vector<Collider> packColliders(const HairInternals& hair, const Ball& ball, float seconds);

}  // namespace pelage::detail
