// Private data of a hair object.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "assets/groom.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "base/rigid_move.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "scene/hair_rooms.h"
#include "skinning/hair_frame.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// A rigid motion that no list has yet moved an object's data on the GPU by.
struct PendingTeleport {
  RigidMove move;  ///< of coordinates relative to the object's origin: from the old to the new
  Vector3<double> from;  ///< the old origin, as LocalOrigin::metres
};

/// The part of an object that a frame changes: FrameJournal puts it back where the frame does not
/// run.
struct HairFrameState {
  HostArray<AffineTransform> bonesBefore;  ///< of the last frame; empty: to be uploaded
  /// State, roots and colliders are relative to it.
  LocalOrigin origin;
  bool originKnown = false;
  /// Shift of the world that no list has yet moved the outputs by [m].
  Vector3<double> pendingShift;
  std::optional<PendingTeleport> teleport;
  ShiftedFloats shiftedFloats;  ///< for members in world space

  bool resetPending = true;
  uint32_t stillFrames = 0;  ///< since the bones changed last
  bool skinned = false;      ///< the last frame did not simulate it
  /// Since it is simulated again [s]; infinite if it always was.
  float sinceSkinned = std::numeric_limits<float>::infinity();

  HairRooms rooms;
  template <class Room>
  Room& get() {
    return std::get<Room>(rooms);
  }
  template <class Room>
  const Room& get() const {
    return std::get<Room>(rooms);
  }
};

struct HairInternals : HairFrameState, HairInputs {
  explicit HairInternals(Groom hair) : groom(std::move(hair)) {}

  const Groom groom;
  SkinningMethod skinning = SkinningMethod::kMatrices;
  bool bonesChanged = true;
  SkeletonInternals* skeleton = nullptr;  ///< that it follows
  uint64_t skeletonVersion = 0;           ///< of `bones`, where it does
  ShiftedFloats shiftedInputs;            ///< of bones, capsules and the field
};

/// Sets the asset, lengths and volume.
void setRestData(RestPose& rest, std::shared_ptr<const HairAsset> asset);
/// Moves the origin after the root of the first strand.
/// \return what to add to positions relative to the old origin; 0 while it stays.
Float3 moveOrigin(HairInternals& hair);
/// Takes the world's origin to where it is after a shift: all that is known of the engine's
/// coordinates, and the hair's own origin.
void shiftWorld(HairInternals& hair, const Vector3<double>& shift, const Vector3<double>& shifted);
/// The same of a frame's state; also accepts a checkpoint.
void shiftWorld(HairFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted);
/// The pending teleport of positions in world space. Shifts of the world that are pending are part
/// of it.
RigidMove teleportInWorld(const HairFrameState& state);
/// The same. \param origin  that the object had before the frame moved it
RigidMove teleportInWorld(const HairFrameState& state, const LocalOrigin& origin);
/// Moves given positions.
void moveGiven(GivenShape& given, const RigidMove& move);
/// Around all strands in world space; a radius of infinity when a bone is not finite.
Ball ballOfStrands(const HairInternals& hair);

/// With follow hairs.
Ball ballOfHair(const HairInternals& hair, float tipSeparation);
/// Around all strands that collide.
Ball ballOfCollisions(const HairInternals& hair, float tipSeparation);

}  // namespace pelage::detail
