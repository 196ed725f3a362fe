// The bones of a character in a scene, which several hair objects and colliders can follow. Made by
// Scene::addSkeleton().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "pelage/binding.h"
#include "pelage/export.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
class HairStore;
struct SkeletonInternals;
}  // namespace detail

struct SkinTable;

/// Where the transforms of a skeleton come from.
enum class BoneSource : uint8_t {
  kHost,     ///< from memory: SkeletonPose::setBones()
  kBuffer,   ///< from a buffer that your engine's skinning writes on the GPU
  kSurface,  ///< from the vertices of a mesh that your engine deforms on the GPU, as
             ///< rootTransforms() computes them on the host: one bone for each root of a skin table
};

/// How a buffer holds bones. Transforms go from bind space to world space.
enum class BoneLayout : uint8_t {
  kRows,             ///< 12 floats: three rows of [M | t], as AffineTransform. With a stride of 16
                     ///< floats also row-major 4 x 4 matrices of column vectors
  kColumns,          ///< 16 floats: the four columns of a 4 x 4 matrix of column vectors (as in
                     ///< GLSL), which are the rows of one of row vectors. The last row is 0 0 0 1
  kDualQuaternions,  ///< 8 floats: as DualQuaternion; either sign, of any length
};

/// Bones in a buffer of your engine. The buffer is one of Scene::resources(): register yours there.
struct BoneBuffer {
  BufferId buffer = BufferId::kInvalid;
  BoneLayout layout = BoneLayout::kRows;
  uint32_t stride = 0;  ///< floats from bone to bone; 0: as many as a bone has
  uint32_t offset = 0;  ///< floats before the first bone
};

/// Positions in a buffer of your engine: three floats each, in world space [m].
struct VertexBuffer {
  BufferId buffer = BufferId::kInvalid;  ///< of Scene::resources()
  uint32_t stride = 3;                   ///< floats from vertex to vertex, >= 3
  uint32_t offset = 0;                   ///< floats before the first x
};

struct SkeletonDef {
  std::string name = "skeleton";
  /// Transforms that setBones() takes, >= 1; BoneSource::kSurface: the roots of `surface`, or left
  /// at 1.
  uint32_t boneCount = 1;
  BoneSource source = BoneSource::kHost;
  /// BoneSource::kSurface: the roots, which Scene::addSkeleton() reads. Else nullptr.
  const SkinTable* surface = nullptr;
  /// Bones on the GPU: how far these put a root or a vertex from where SkeletonPose's `placement`
  /// puts it, at most [m], finite, >= 0. The scene looks for colliders, fits shadow maps and leaves
  /// out what no view sees by it.
  float deviation = 1;
};

/// A skeleton uploads its transforms once for everything that follows it, in frames in which they
/// changed and something reads them. Its followers share an origin, too: the precision of their
/// positions is that of floats at their distance from the follower that was added first.
///
/// Transforms on the GPU (BoneSource) never come to the host. Instead it knows a placement: a
/// transform from bind space to world space that is near all of them, such as that of the character
/// or, for hair, of its head. A buffer is read by the next list of Scene::simulate(): write it
/// before, and keep what is in it until that list has run.
///
/// Threads: the one that uses its scene.
class PELAGE_API SkeletonPose {
 public:
  ~SkeletonPose();
  const std::string& name() const { return name_; }
  uint32_t boneCount() const;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that the span has boneCount() elements, and BoneSource::kHost. A bone with a non-finite
  /// transform stays where it was.
  void setBones(std::span<const AffineTransform> bones);
  /// Says that a buffer has new transforms, and about where they are; without it the bones stand
  /// still. A placement that is not finite leaves the last one. Hair and vertices of a bone with a
  /// non-finite transform stay where they were. Asserts BoneSource::kBuffer. Cost: a pass of one
  /// thread a bone, for each SkinningMethod of the skeleton's followers.
  void setBones(const BoneBuffer& bones, const AffineTransform& placement);
  /// Says that buffers have new vertices of the parts of SkeletonDef::surface, one for each, and
  /// about where they are; without it the mesh stands still. Parts without roots need no buffer. A
  /// root whose triangle has no area (twice it is below 1e-6 of its longest edge's square) or is
  /// not finite stays where it was. Asserts BoneSource::kSurface and the number of parts. Cost: a
  /// pass of one thread a root for each part, and for each SkinningMethod of the skeleton's
  /// followers.
  void setVertices(std::span<const VertexBuffer> parts, const AffineTransform& placement);
  /// The current transforms; empty where they are on the GPU.
  std::span<const AffineTransform> bones() const;

 private:
  friend class detail::HairStore;
  SkeletonPose();

  std::string name_;
  std::unique_ptr<detail::SkeletonInternals> internals_;
};

}  // namespace pelage
