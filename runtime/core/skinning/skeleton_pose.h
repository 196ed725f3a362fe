// Private data of a skeleton in a scene.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/local_origin.h"
#include "passes/buffer_factory.h"
#include "pelage/bone_weights.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/skeleton_pose.h"

namespace pelage::detail {

/// The roots on a part of SkeletonDef::surface.
struct SurfacePart {
  uint32_t first = 0, count = 0;  ///< of its roots in SkeletonInternals::surfaceBones
  uint32_t vertexCount = 0;       ///< that the roots need
};

struct SkeletonInternals {
  std::string name;
  uint32_t boneCount = 1;
  BoneSource source = BoneSource::kHost;
  /// Finite. Of bones on the GPU one, the placement.
  HostArray<AffineTransform> bones;
  float deviation = 0;   ///< of what follows from where `bones` put it [m]
  uint64_t version = 1;  ///< of the bones
  // Bones on the GPU.
  BoneBuffer boneBuffer;
  BufferId surfaceBones = BufferId::kInvalid;  ///< SurfaceBone, by parts
  HostArray<SurfacePart> parts;
  HostArray<VertexBuffer> vertices;  ///< [part]
  bool isOnGpu() const { return source != BoneSource::kHost; }
  LocalOrigin origin;  ///< of all that follows
  bool originKnown = false;
  ShiftedFloats shiftedFloats;

  /// A point in bind space that the origin follows.
  struct Anchor {
    uint32_t bone = 0;
    Float3 point = {};
  };
  std::optional<Anchor> anchor;

  /// The transforms on the GPU.
  struct Copy {
    BufferId buffer = BufferId::kInvalid;
    uint64_t version = 0;  ///< of what it holds; 0: nothing
    LocalOrigin origin;
  };
  std::array<Copy, 2> copies;  ///< [SkinningMethod]
  Copy& copyFor(SkinningMethod method) { return copies[static_cast<size_t>(method)]; }
};

/// Returns false for coordinates that are not finite or so large that they are broken.
bool isUsable(const Float3& position);
/// Describes the error in a definition; empty if there is none.
std::string faultOf(const SkeletonDef& def);
/// Makes the table of a skeleton that follows a surface.
void addSurface(SkeletonInternals& skeleton, const SkinTable& table, const BufferFactory& factory);
/// Describes the error in the buffers that the bones come from; empty if there is none.
std::string faultOfSource(const SkeletonInternals& skeleton, const ResourceTable& resources);
/// Moves the origin to follow the anchor; the first call sets the anchor.
void moveOrigin(SkeletonInternals& skeleton, const SkeletonInternals::Anchor& anchor);
void moveOrigin(SkeletonInternals& skeleton);
/// As for a hair object.
void shiftWorld(SkeletonInternals& skeleton, const Vector3<double>& shift,
                const Vector3<double>& shifted);

/// Number of Float4 per bone on the GPU.
inline uint64_t rowsOf(SkinningMethod method) {
  return method == SkinningMethod::kMatrices ? 3 : 2;
}
/// Uploads bones relative to an origin, as the kernels read them.
void sendBones(std::span<const AffineTransform> bones, const LocalOrigin& origin,
               SkinningMethod method, BufferId buffer, PassList& list);

/// The buffer of a method's copy, which is made where there is none.
BufferId bonesFor(SkeletonInternals& skeleton, SkinningMethod method, const BufferFactory& factory);
/// Adds the upload of a method's copy, or the passes that write it, if it is out of date.
Result<void> sendBones(SkeletonInternals& skeleton, SkinningMethod method,
                       const ResourceTable& resources, PassList& list);

}  // namespace pelage::detail
