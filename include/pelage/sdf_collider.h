// A triangle mesh that hair collides with, through a signed distance field on the GPU.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "pelage/collision_mesh.h"
#include "pelage/hair_object.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
struct SdfColliderInternals;
}

struct SdfColliderDef {
  std::string name = "collider";
  /// Distance of the field's nodes [m], > 0; 0 takes a 50th of the mesh's longest side. Parts
  /// thinner than about a cell let hair through when it is fast.
  float cellSize = 0;
  /// Nodes up to here from the surface have exact distances [cells], 1..8.
  float band = 2;
  /// Memory of the field at most [bytes]; a larger grid is an error that says which cell size would
  /// fit.
  uint64_t memoryCap = uint64_t{256} << 20;
  /// Vertices that moved less since they were built stay where they are in the field [cells], 0..1.
  float motionTolerance = 0.01f;
  SkinningMethod skinning = SkinningMethod::kMatrices;
  /// Bones of setBones(), > 0; the mesh's influences refer to them.
  uint32_t boneCount = 1;
  /// Bones that other objects follow, too, in place of setBones(). boneCount is that of the
  /// skeleton then, or left at 1.
  SkeletonId skeleton = SkeletonId::kInvalid;
  /// A vertex buffer of the engine's, in world space, that is there before each simulation. The
  /// mesh's positions then tell which vertices are one, what cellSize 0 means, and where the field
  /// is until the first setVertexBounds(); call that before the first simulation where they are
  /// elsewhere. Bones are not used.
  BufferId vertices = BufferId::kInvalid;
  uint32_t vertexStride = 3;  ///< floats from vertex to vertex, >= 3
  uint32_t vertexOffset = 0;  ///< floats before the first x
};

/// Where a field is, and how large.
struct SdfGrid {
  Float3 origin = {};                  ///< node 0 in world space [m]
  float cellSize = 0;                  ///< [m]
  std::array<uint32_t, 3> nodes = {};  ///< along x, y, z; x fastest
  bool operator==(const SdfGrid&) const = default;
};

/// What the last build of a field did.
struct SdfCounters {
  uint32_t bigTriangles = 0;    ///< that were shared out over thread groups
  uint32_t interiorNodes = 0;   ///< of the coarse grid: inside beyond the band
  uint32_t movedVertices = 0;   ///< a build of what moved: by more than the tolerance
  uint32_t movedTriangles = 0;  ///< likewise: that were taken out and put in again
  uint32_t clearedBricks = 0;   ///< likewise: of 4^3 nodes
};

/// Reads the counters from SdfColliderBuffers::work, of which it takes the first 160 bytes. They
/// are those of the last build that the GPU has finished.
SdfCounters readSdfCounters(std::span<const std::byte> work);

/// Buffers of a collider; kInvalid marks one that it does not need. Keys and records are in two
/// buffers that all colliders share, Scene::sdfKeys() and Scene::sdfSurface().
struct SdfColliderBuffers {
  BufferId bindVertices = BufferId::kInvalid;    ///< [vertex][3] float
  BufferId bindings = BufferId::kInvalid;        ///< [vertex] VertexBinding
  BufferId bones = BufferId::kInvalid;           ///< 3 (matrices) or 2 (dual quaternions) Float4
                                                 ///< each; the skeleton's, where it follows one
  BufferId vertices = BufferId::kInvalid;        ///< [vertex][3] float, skinned
  BufferId verticesBefore = BufferId::kInvalid;  ///< the same of the last build
  BufferId placeVertices = BufferId::kInvalid, indices = BufferId::kInvalid;
  BufferId neighbors = BufferId::kInvalid, fanStarts = BufferId::kInvalid;
  BufferId fans = BufferId::kInvalid;
  BufferId counts = BufferId::kInvalid;  ///< crossings of the nodes
  BufferId places = BufferId::kInvalid, work = BufferId::kInvalid, marks = BufferId::kInvalid;
  BufferId votes = BufferId::kInvalid;
  BufferId isoCounts = BufferId::kInvalid;  ///< for Scene::checkColliderDraw()
};

/// How Scene::drawCollider() shows a field.
struct ColliderLook {
  float isoLevel = 0;  ///< distance of what is drawn from the surface [cells], between +-band
  Float3 color = {0.10f, 0.20f, 0.32f};  ///< linear RGB
  float opacity = 1;                     ///< 0..1; below 1 hair behind it is seen
};

class SdfCollider {
 public:
  ~SdfCollider();
  const std::string& name() const { return name_; }
  /// What the mesh is like; open meshes and those with overlaps are taken, too.
  const MeshReport& report() const;
  /// Of the last simulation.
  const SdfGrid& grid() const;
  /// Of keys and crossings [bytes]; what SdfColliderDef::memoryCap limits.
  uint64_t memoryBytes() const;
  const SdfColliderBuffers& buffers() const { return buffers_; }

  /// Hair is kept this far outside [m], >= 0; at most about a band, beyond which there is no
  /// distance to go by.
  float margin = 0.001f;
  /// Coulomb's coefficient, >= 0.
  float friction = 0.3f;
  /// A disabled collider is neither built nor applied.
  bool enabled = true;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that there are boneCount of them, and that it follows no skeleton. Vertices of non-finite ones
  /// stay where they were.
  void setBones(std::span<const AffineTransform> bones);
  /// Says that the engine's vertex buffer has changed, and that all of it is in a box in world
  /// space [m]. What leaves the box is no longer seen by hair there.
  void setVertexBounds(const Float3& low, const Float3& high);
  /// Forgets where the surface was: for teleports, with HairObject::reset(). The field is built as
  /// a whole in the next frame in which hair reaches it.
  void reset();

 private:
  friend class Scene;
  SdfCollider();

  std::string name_;
  SdfColliderBuffers buffers_;
  std::unique_ptr<detail::SdfColliderInternals> internals_;
};

}  // namespace pelage
