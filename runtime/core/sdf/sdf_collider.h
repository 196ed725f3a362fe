// Private data of a collider.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "assets/collider_topology.h"
#include "base/bone_moves.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "pelage/sdf_collider.h"
#include "sdf/iso_surface.h"
#include "sdf/sdf_build.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// Box around the bind positions of the vertices that a bone moves, and their number.
struct BoneBox {
  uint32_t bone = 0;
  uint32_t vertexCount = 0;
  Box box;
};

/// The state of a collider that a frame changes, as HairFrameState.
struct SdfFrameState {
  HostArray<AffineTransform> builtBones;   ///< of the field; empty before the first build
  HostArray<AffineTransform> bonesBefore;  ///< where the records' motion begins
  uint64_t builtVersion = 0;               ///< likewise, of a skeleton on the GPU or of `dense`
  bool verticesChanged = true;
  bool mirrored = false;     ///< the tables have flipped triangles
  bool resetPending = true;  ///< there is no motion from the last frame
  bool buildPending = true;  ///< needs a full build

  /// Origin of the plan, and of vertices of the collider's own.
  LocalOrigin origin;
  ShiftedFloats shiftedFloats;  ///< of `builtBones`
  Vector3<double> dataNode;     ///< node 0 of data, relative to the origin [m]
  SdfGridPlan plan;             ///< relative to `origin`; cellSize 0 before the first one
  SdfGrid grid;                 ///< of the plan, in world space
  SdfBuildState state;
  uint32_t keyOffset = 0;    ///< in the scene's keys
  uint32_t keyCapacity = 0;  ///< capacity for keys
  uint32_t surfaceOffset = 0;
  bool builtNow = false;   ///< in this frame
  bool moves = false;      ///< the records' motion is that of this frame
  bool active = false;     ///< some hair is in range in this frame
  bool wasActive = false;  ///< in the last frame
};

struct SdfColliderInternals : SdfFrameState {
  SdfColliderDef def;
  ColliderTopology topology;
  CollisionMesh mesh;                       ///< positions and influences, to make buffers from
  std::optional<SdfData> data;              ///< instead of a mesh: a field that is never built
  std::optional<DenseSdf> dense;            ///< instead of a mesh: a field of the engine
  std::array<uint32_t, 3> denseNodes = {};  ///< that `dense` has to have
  uint64_t denseVersion = 1;
  bool hasMesh() const { return !data && !dense; }
  uint32_t vertexCount = 0;
  HostArray<BoneBox> boneBoxes;

  HostArray<AffineTransform> bones;
  SkeletonInternals* skeleton = nullptr;  ///< that it follows
  Box vertexBounds;                       ///< of the engine's vertex buffer, in world space

  ShiftedFloats shiftedInputs;  ///< of bones and bounds

  std::optional<IsoSurface> isoSurface;  ///< once it was drawn
};
/// Errors: members of a def that are out of range.
Result<void> checkSdfColliderDef(const SdfColliderDef& def);

/// The boxes of all bones that move a vertex.
HostArray<BoneBox> boneBoxesOf(const CollisionMesh& mesh);
/// The box of all vertices as that of bone 0, for bones that the host does not know.
HostArray<BoneBox> boxOfAll(const CollisionMesh& mesh);
/// Number of bones that move the vertices.
uint32_t boneCountOf(const SdfColliderInternals& collider);
/// Box around all vertices in world space, from the bones alone. Blends of matrices stay in the
/// hull of the single bones' results. Empty if no bone is finite.
Box boundsOf(const SdfColliderInternals& collider);
/// Returns true if the bones turn the mesh inside out: all bones that move a vertex mirror. Dual
/// quaternions do not.
bool isMirrored(const SdfColliderInternals& collider);
/// Position of the next grid's origin.
LocalOrigin originFor(const SdfColliderInternals& collider);
/// Returns the grid for the current vertices; nothing if the existing one fits. Errors: those of
/// planSdfGrid(), with the collider's name.
Result<std::optional<SdfGridPlan>> planGrid(const SdfColliderInternals& collider);
/// The definition of the build.
SdfBuildDef buildDefOf(const SdfColliderInternals& collider);
/// The SDF relative to an origin.
Sdf sdfOf(const SdfColliderInternals& collider, const LocalOrigin& origin);
/// The grid in the current world.
SdfGrid gridOf(const SdfColliderInternals& collider);
/// As for a hair object. An engine moves its own vertices.
void shiftWorld(SdfColliderInternals& collider, const Vector3<double>& shift,
                const Vector3<double>& shifted);
/// The same for a frame's state, which may be an earlier one.
void shiftWorld(SdfFrameState& state, const Vector3<double>& shift, const Vector3<double>& shifted);
/// Upper bound of a vertex's displacement since the SDF was built [m]; infinity if it is not known.
float motionSinceBuild(const SdfColliderInternals& collider);
/// The way of the vertices in this frame, over the size of a cell; at most that of the box that is
/// fastest. \param enough  the same: ways up to this one need not be the least of the hair's moves
double wayInCells(const SdfColliderInternals& collider, const BoneMoves& moves, double enough);
/// Upper bound of the fraction of vertices that a bone moves by more than a distance [m], 0..1.
float movedShare(const SdfColliderInternals& collider, float distance);

}  // namespace pelage::detail
