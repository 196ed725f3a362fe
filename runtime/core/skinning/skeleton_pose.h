// Private data of a skeleton in a scene.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/local_origin.h"
#include "passes/room_buffers.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/skeleton_pose.h"

namespace pelage::detail {

struct SkeletonInternals {
  std::string name;
  std::vector<AffineTransform> bones;  ///< finite
  uint64_t version = 1;                ///< of the bones
  LocalOrigin origin;                  ///< of all that follows
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

bool isFiniteBone(const AffineTransform& bone);
/// Moves the origin to follow the anchor; the first call sets the anchor.
void moveOrigin(SkeletonInternals& skeleton, const SkeletonInternals::Anchor& anchor);
void moveOrigin(SkeletonInternals& skeleton);
/// As for a hair object.
void shiftWorld(SkeletonInternals& skeleton, const Vector3<double>& shift,
                const Vector3<double>& shifted);

/// Number of Float4 per bone in the result of packBones().
inline uint64_t rowsOf(SkinningMethod method) {
  return method == SkinningMethod::kMatrices ? 3 : 2;
}
/// Bones relative to an origin, as the kernels read them.
std::vector<Float4> packBones(std::span<const AffineTransform> bones, const LocalOrigin& origin,
                              SkinningMethod method);

/// The buffer of a method's copy, which is made where there is none.
BufferId bonesFor(SkeletonInternals& skeleton, SkinningMethod method, const RoomBuffers& room);
/// The upload of a method's copy, if it is out of date.
void uploadBones(SkeletonInternals& skeleton, SkinningMethod method, PassList& list);

}  // namespace pelage::detail
