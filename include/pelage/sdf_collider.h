// A triangle mesh that hair collides with, through a signed distance field (SDF) on the GPU, and
// SDFs that were built in advance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/export.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
class HairStore;
class SdfRoom;
struct SdfColliderInternals;
}  // namespace detail

struct SdfColliderDef {
  std::string name = "collider";
  /// Cell size of the SDF: distance between its nodes [m], > 0; 0 means a 50th of the mesh's
  /// longest side. Parts thinner than about a cell let fast hair through.
  float cellSize = 0;
  /// Nodes within this distance of the surface have exact distances [cells], 1..8.
  float band = 2;
  /// Maximum memory of the SDF [bytes]. A larger grid is an error that names the cell size that
  /// would fit.
  uint64_t memoryCap = uint64_t{256} << 20;
  /// Vertices that moved by less than this since the last build keep their position in the SDF
  /// [cells], 0..1.
  float motionTolerance = 0.01f;
  SkinningMethod skinning = SkinningMethod::kMatrices;
  /// Number of transforms that setBones() takes, > 0; the mesh's influences refer to them.
  uint32_t boneCount = 1;
  /// A skeleton to follow instead of setBones(); several objects can share it. boneCount is then
  /// that of the skeleton, or left at 1.
  SkeletonId skeleton = SkeletonId::kInvalid;
  /// A vertex buffer of your engine, in world space, filled before each simulation. Bones are then
  /// not used. The mesh's positions determine which vertices are merged, what cellSize 0 means, and
  /// where the SDF is until the first setVertexBounds(); if the buffer's vertices are elsewhere,
  /// call that before the first simulation. After Scene::shiftOrigin(), move the vertices yourself.
  BufferId vertices = BufferId::kInvalid;
  uint32_t vertexStride = 3;  ///< floats from vertex to vertex, >= 3
  uint32_t vertexOffset = 0;  ///< floats before the first x
};

/// Position and size of an SDF.
struct SdfGrid {
  Float3 origin = {};                  ///< node 0 in world space [m]
  float cellSize = 0;                  ///< [m]
  std::array<uint32_t, 3> nodes = {};  ///< along x, y, z; x fastest
  bool operator==(const SdfGrid&) const = default;
};

/// An SDF of your engine's own, in a buffer on the GPU: a global distance field, one of a tool, or
/// one that a pass computes in each frame.
struct DenseSdf {
  /// One of Scene::resources(): [z][y][x] float, the distance of a node from the surface [m],
  /// negative inside. It must not be larger than the true distance. A distance that is not finite
  /// counts as far outside.
  BufferId distances = BufferId::kInvalid;
  uint32_t first = 0;  ///< floats before node 0
  /// Where the nodes are, each axis with 2 or more. Hair does not collide beyond the grid: let it
  /// reach beyond the surface by some cells and the margin.
  SdfGrid grid = {};
  bool operator==(const DenseSdf&) const = default;
};

/// Counters of the last build of an SDF.
struct SdfCounters {
  uint32_t bigTriangles = 0;    ///< that were distributed over thread groups
  uint32_t interiorNodes = 0;   ///< nodes of the coarse grid: inside, beyond the band
  uint32_t movedVertices = 0;   ///< partial build: moved by more than the tolerance
  uint32_t movedTriangles = 0;  ///< partial build: removed and inserted again
  uint32_t clearedBricks = 0;   ///< partial build: bricks of 4^3 nodes
};

/// Reads the counters from the first 160 bytes of SdfColliderBuffers::work. They belong to the last
/// build that the GPU has finished.
PELAGE_API SdfCounters readSdfCounters(std::span<const std::byte> work);

/// Buffers of a collider; kInvalid marks one that this collider does not need. Keys and records are
/// in two buffers that all colliders share, Scene::sdfKeys() and Scene::sdfSurface().
struct SdfOutputs {
  BufferId bindVertices = BufferId::kInvalid;    ///< [vertex][3] float
  BufferId bindings = BufferId::kInvalid;        ///< [vertex] VertexBinding
  BufferId bones = BufferId::kInvalid;           ///< 3 (matrices) or 2 (dual quaternions) Float4
                                                 ///< each; the skeleton's if it follows one
  BufferId vertices = BufferId::kInvalid;        ///< [vertex][3] float, skinned
  BufferId verticesBefore = BufferId::kInvalid;  ///< those of the last build
  BufferId pointVertices = BufferId::kInvalid, indices = BufferId::kInvalid;
  BufferId neighbors = BufferId::kInvalid, fanStarts = BufferId::kInvalid;
  BufferId fans = BufferId::kInvalid;
  BufferId counts = BufferId::kInvalid;  ///< crossings of the nodes
  BufferId points = BufferId::kInvalid, work = BufferId::kInvalid, marks = BufferId::kInvalid;
  BufferId votes = BufferId::kInvalid;
};

/// All buffers of a collider.
struct SdfColliderBuffers : SdfOutputs {
  BufferId isoCounts = BufferId::kInvalid;  ///< for Scene::checkColliderDraw()
};

/// The look of an SDF in Scene::drawCollider().
struct ColliderLook {
  float isoLevel = 0;  ///< distance of the drawn surface from the mesh [cells], within +-band
  Float3 color = {0.10f, 0.20f, 0.32f};  ///< linear RGB
  float opacity = 1;                     ///< 0..1; below 1 hair behind it is visible
};

/// A mesh of a scene that hair collides with. Threads: the one that uses its scene.
class PELAGE_API SdfCollider {
 public:
  ~SdfCollider();
  const std::string& name() const { return name_; }
  /// Describes the mesh. Open meshes and meshes with overlaps are accepted, too.
  const MeshReport& report() const;
  /// The grid of the last simulation, relative to the current world origin.
  const SdfGrid& grid() const;
  /// Memory of keys and crossings [bytes], which SdfColliderDef::memoryCap limits.
  uint64_t memoryBytes() const;
  const SdfColliderBuffers& buffers() const { return buffers_; }

  /// Distance that hair keeps from the surface [m], >= 0; at most about the band, because the SDF
  /// has no distances beyond it.
  float margin = 0.001f;
  /// Coulomb coefficient, >= 0.
  float friction = 0.3f;
  /// A disabled collider is neither built nor applied.
  bool enabled = true;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that the span has boneCount elements, and that the collider follows no skeleton. Vertices of a
  /// non-finite transform stay where they were.
  void setBones(std::span<const AffineTransform> bones);
  /// Call this when the engine's vertex buffer has changed. All vertices are within the box [m], in
  /// world space; hair does not collide with those outside of it.
  void setVertexBounds(const Float3& low, const Float3& high);
  /// Says that the buffer of an SDF of your engine has new distances, or that its grid has moved;
  /// without this call both stay as they were. The number of nodes along each axis must stay, which
  /// Scene::simulate() checks. Asserts that the collider has such an SDF.
  void setDistances(const DenseSdf& sdf);
  /// Clears the history of the surface: for teleports, with HairObject::reset(). A full build
  /// follows in the next frame in which hair is in range.
  void reset();

 private:
  friend class detail::HairStore;
  friend class detail::SdfRoom;
  SdfCollider();

  std::string name_;
  SdfColliderBuffers buffers_;
  std::unique_ptr<detail::SdfColliderInternals> internals_;
};

/// An SDF as the kernels store it. kernels/sdf/layouts/sdf.hlsli and kernels/sdf/sdf_key.hlsli
/// describe the layout.
struct SdfData {
  SdfGrid grid;
  float band = 2;      ///< [cells]
  float farRange = 0;  ///< [cells]
  uint32_t triangleBits = 0;
  uint32_t triangleCount = 0;
  std::vector<uint32_t> keys;     ///< [node], x fastest
  std::vector<uint32_t> surface;  ///< [triangle][16], records without motion
  bool operator==(const SdfData&) const = default;
};

/// Saves an SDF (.psdf, little endian): "PSDF", version, header, keys, records.
PELAGE_API Result<void> saveSdf(const SdfData& data, const std::filesystem::path& path);
/// Loads an SDF. Errors name the file and the byte: another kind of file or version, sizes that do
/// not match the file, a grid or numbers out of range, a key or a record that refers to a triangle
/// that does not exist.
PELAGE_API Result<SdfData> loadSdf(const std::filesystem::path& path);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<SdfData> loadSdf(std::span<const std::byte> bytes, std::string_view name);
PELAGE_API Result<SdfData> loadSdf(ByteSource& source, std::string_view name);

}  // namespace pelage
