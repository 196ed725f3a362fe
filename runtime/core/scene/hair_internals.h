// What a hair object holds beside its public data.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "assets/groom.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "base/rigid_move.h"
#include "contact/follow_contacts.h"
#include "contact/hair_contacts.h"
#include "contact/hair_grid.h"
#include "pelage/collider.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "shading/strand_interpolation.h"
#include "shading/strand_motion.h"
#include "simulation/field_forces.h"
#include "simulation/given_positions.h"
#include "simulation/strand_solver.h"
#include "skinning/bone_bounds.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// A rigid motion that no list has yet moved an object's data on the GPU by.
struct PendingTeleport {
  RigidMove move;  ///< of coordinates relative to the object's origin: from the old to the new
  Vector3<double> from;  ///< the old origin, as LocalOrigin::metres
};

/// What a frame changes of an object: Scene puts it back where the frame does not run. What the
/// application sets is not part of it.
struct HairFrameState {
  HostArray<AffineTransform> bonesBefore;      ///< of the last frame; empty: to be uploaded
  HostArray<CapsuleCollider> collidersBefore;  ///< likewise
  HostArray<std::byte> sdfsBefore;             ///< contents of the buffer of fields
  uint32_t colliderCapacity = 0;               ///< elements of the buffer
  uint32_t sdfCapacity = 0;                    ///< likewise, of that of fields

  /// Of state, roots and colliders.
  LocalOrigin origin;
  bool originKnown = false;
  /// Shift of the world that no list has yet moved the outputs by [m].
  Vector3<double> pendingShift;
  std::optional<PendingTeleport> teleport;
  /// Largest coordinate of the shift since the last simulation [m]: for what engines round anew.
  double roundedShift = 0;
  ShiftedFloats shiftedFloats;  ///< of what of this is in world space

  bool resetPending = true;
  uint32_t stillFrames = 0;  ///< since the bones changed last
  bool skinned = false;      ///< the last frame did not simulate it
  /// Since it is simulated again [s]; infinite if it always was.
  float sinceSkinned = std::numeric_limits<float>::infinity();

  // Of the rooms.
  HairContacts contacts;
  FollowContacts followContacts;
  FieldForces fieldForces;
  HairGrid grid;
  StrandSolver solver;
  GivenPositions givenPositions;
  StrandMotion motion;
  StrandInterpolation interpolation;
};

struct HairInternals : HairFrameState, Groom {
  SkinningMethod skinning = SkinningMethod::kMatrices;

  HostArray<AffineTransform> bones;
  bool bonesChanged = true;
  SkeletonInternals* skeleton = nullptr;  ///< that it follows
  uint64_t skeletonVersion = 0;           ///< of `bones`, where it does
  HostArray<BoneBounds> bounds;
  float deviation = 0;  ///< of roots from where `bones` put `bounds` [m]

  /// Mesh colliders that it meets, ascending; nothing: all.
  std::optional<HostArray<ColliderId>> meshColliders;
  HostArray<CapsuleCollider> colliders;
  ForceField field;
  GivenShape given;             ///< in place of the solver's
  ShiftedFloats shiftedInputs;  ///< of bones, capsules and the field
};

/// Sets what goes with the rest pose: the asset, lengths and volume.
void setRestData(Groom& groom, std::shared_ptr<const HairAsset> asset);
/// Moves the origin after the root of the first strand.
/// \return what to add to positions relative to the old origin; 0 while it stays.
Float3 moveOrigin(HairInternals& hair);
/// Takes the world's origin to where it is after a shift: all that is known of the engine's
/// coordinates, and the hair's own origin.
void shiftWorld(HairInternals& hair, const Vector3<double>& shift, const Vector3<double>& shifted);
/// The same of a frame's state, which may be one of before.
void shiftWorld(HairFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted);
/// The pending teleport of positions in world space. Shifts of the world that are pending are part
/// of it.
RigidMove teleportInWorld(const HairFrameState& state);
/// The same. \param origin  that the object had before the frame moved it
RigidMove teleportInWorld(const HairFrameState& state, const LocalOrigin& origin);
/// Moves what is given in place of a solver's shape.
void moveGiven(GivenShape& given, const RigidMove& move);
/// After a shift: capsules that moved by no more than an engine's rounding have not moved.
void forgetRounding(HairInternals& hair);
/// Around all strands in world space; a radius of infinity when a bone is not finite.
Ball ballOfStrands(const HairInternals& hair);

/// With follow hairs.
Ball ballOfHair(const HairInternals& hair, float tipSeparation);
/// Around all strands that collide.
Ball ballOfCollisions(const HairInternals& hair, float tipSeparation);
bool collidesWith(const HairInternals& hair, ColliderId collider);

}  // namespace pelage::detail
