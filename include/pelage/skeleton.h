// Bones and the transforms that the skinning kernel reads. The animation itself is the engine's.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/types.h"

namespace pelage {

struct Bone {
  std::string name;
  int32_t parent = -1;   ///< index of the parent, below this bone's own; -1 = none
  AffineTransform bind;  ///< bone space to bind space: where the joint was when hair was groomed
};

struct Skeleton {
  std::vector<Bone> bones;
  /// Index of the bone of this name.
  std::optional<uint32_t> find(std::string_view name) const;
};

/// A rigid motion p -> rotate(real, p) + t with unit `real` (x, y, z, w) and
/// dual = (t, 0) * real / 2, as the skinning kernel reads it.
struct DualQuaternion {
  Float4 real = {0, 0, 0, 1};
  Float4 dual = {0, 0, 0, 0};
};

/// First `inner`, then `outer`.
AffineTransform multiply(const AffineTransform& outer, const AffineTransform& inner);
/// Nothing when the linear part is singular or not finite.
std::optional<AffineTransform> inverse(const AffineTransform& transform);
/// Rotates about the origin, then moves. The quaternion is normalised; one of length 0 is taken as
/// the identity.
AffineTransform rigidTransform(const Quaternion& rotation, const Float3& translation);
/// transform * (point, 1).
Float3 transformPoint(const AffineTransform& transform, const Float3& point);

/// The rigid motion nearest to a transform: its rotation is the orthogonal polar factor of the
/// linear part, so that scale, shear and mirroring are taken out (of a mirrored bone the weakest
/// axis is turned back); its translation is kept. A transform that is not finite gives the
/// identity.
DualQuaternion toDualQuaternion(const AffineTransform& transform);

/// The skinning transforms (bind space to world) of a pose: world * inverse(bind) for each bone.
/// `world` [bone] is bone space to world. A bone whose bind transform is singular gets `world`.
std::vector<AffineTransform> skinningTransforms(const Skeleton& skeleton,
                                                std::span<const AffineTransform> world);

}  // namespace pelage
