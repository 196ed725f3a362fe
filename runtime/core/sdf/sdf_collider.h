// What a collider holds beside its public data.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "assets/collider_topology.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "pelage/sdf_collider.h"
#include "pelage/sdf_data.h"
#include "sdf/iso_surface.h"
#include "sdf/sdf_build.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// Box around the bind positions of the vertices that a bone moves, and how many these are.
struct BoneBox {
  uint32_t bone = 0;
  uint32_t vertexCount = 0;
  Box box;
};

/// What a frame changes of a collider, as HairFrameState.
struct SdfFrameState {
  std::vector<AffineTransform> builtBones;  ///< of the field; empty before the first build
  bool verticesChanged = true;
  bool mirrored = false;     ///< the tables have the triangles turned round
  bool resetPending = true;  ///< there is no motion from the last frame
  bool buildPending = true;  ///< the field has to be built as a whole

  /// Of the plan, and of vertices of its own.
  LocalOrigin origin;
  ShiftedFloats shiftedFloats;  ///< of `builtBones`
  Vector3<double> dataNode;     ///< node 0 of data, relative to the origin [m]
  SdfGridPlan plan;             ///< relative to `origin`; cellSize 0 before the first one
  SdfGrid grid;                 ///< of the plan, in world space
  SdfBuildState state;
  uint32_t keyOffset = 0;    ///< in the scene's keys
  uint32_t keyCapacity = 0;  ///< keys that there is room for
  uint32_t surfaceOffset = 0;
  bool builtNow = false;   ///< in this frame
  bool moves = false;      ///< the records' motion is that of this frame
  bool active = false;     ///< some hair reaches it in this frame
  bool wasActive = false;  ///< in the last frame
};

struct SdfColliderInternals : SdfFrameState {
  SdfColliderDef def;
  ColliderTopology topology;
  CollisionMesh mesh;           ///< positions and influences, to make buffers from
  std::optional<SdfData> data;  ///< instead of a mesh: a field that is never built
  uint32_t vertexCount = 0;
  std::vector<BoneBox> boneBoxes;

  std::vector<AffineTransform> bones;
  SkeletonInternals* skeleton = nullptr;  ///< that it follows
  Box vertexBounds;                       ///< of the engine's vertex buffer, in world space

  ShiftedFloats shiftedInputs;  ///< of bones and bounds

  std::optional<IsoSurface> isoSurface;  ///< once it was drawn
};
/// Errors: what of a def is out of range.
Result<void> checkSdfColliderDef(const SdfColliderDef& def);

/// The boxes of all bones that move a vertex.
std::vector<BoneBox> boneBoxesOf(const CollisionMesh& mesh);
/// Around all vertices in world space, from the bones alone. Blends of matrices stay in the hull of
/// what each bone does. Empty when no bone is finite.
Box boundsOf(const SdfColliderInternals& collider);
/// Whether the bones turn the mesh inside out: all of them that move a vertex mirror. Dual
/// quaternions do not.
bool isMirrored(const SdfColliderInternals& collider);
/// Where the origin of the next grid is.
LocalOrigin originFor(const SdfColliderInternals& collider);
/// The grid for the vertices where they are now; nothing while the one that there is does. Errors:
/// those of planSdfGrid(), with the collider's name.
Result<std::optional<SdfGridPlan>> planGrid(const SdfColliderInternals& collider);
/// What the build takes.
SdfBuildDef buildDefOf(const SdfColliderInternals& collider);
/// The field relative to an origin.
SdfField fieldOf(const SdfColliderInternals& collider, const LocalOrigin& origin);
/// Where the grid is in the world as it is.
SdfGrid gridOf(const SdfColliderInternals& collider);
/// As that of a hair object. An engine's vertices are the engine's to move.
void shiftWorld(SdfColliderInternals& collider, const Vector3<double>& shift,
                const Vector3<double>& shifted);
/// The same of a frame's state, which may be one of before.
void shiftWorld(SdfFrameState& state, const Vector3<double>& shift, const Vector3<double>& shifted);
/// How far a vertex went since the field was built [m], at most; infinity when it is not known.
float motionSinceBuild(const SdfColliderInternals& collider);
/// Share of the vertices that a bone moves by more than a distance [m], 0..1, at most 1.
float movedShare(const SdfColliderInternals& collider, float distance);

}  // namespace pelage::detail
