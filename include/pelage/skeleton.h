// Bones and the transforms that the skinning kernel reads. The engine does the animation.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/export.h"
#include "pelage/types.h"

namespace pelage {

struct Bone {
  std::string name;
  int32_t parent = -1;   ///< index of the parent, below this bone's own; -1 = none
  AffineTransform bind;  ///< bone space to bind space: the joint when the hair was groomed
};

/// Bones with their bind transforms. Threads: as a standard container.
struct PELAGE_API Skeleton {
  std::vector<Bone> bones;
  /// Returns the index of the bone with this name, or nothing.
  std::optional<uint32_t> find(std::string_view name) const;
};

/// A rigid motion p -> rotate(real, p) + t with unit `real` (x, y, z, w) and
/// dual = (t, 0) * real / 2, as the skinning kernel reads it.
struct DualQuaternion {
  Float4 real = {0, 0, 0, 1};
  Float4 dual = {0, 0, 0, 0};
};

/// Returns the transform that applies first `inner`, then `outer`.
PELAGE_API AffineTransform multiply(const AffineTransform& outer, const AffineTransform& inner);
/// Returns the inverse; nothing if the linear part is singular or not finite.
PELAGE_API std::optional<AffineTransform> inverse(const AffineTransform& transform);
/// Returns a transform that rotates about the origin, then translates. The quaternion is
/// normalized; one of length 0 counts as the identity.
PELAGE_API AffineTransform rigidTransform(const Quaternion& rotation, const Float3& translation);
/// Returns transform * (point, 1).
PELAGE_API Float3 transformPoint(const AffineTransform& transform, const Float3& point);

/// Returns the rigid motion nearest to a transform. Its rotation is the orthogonal polar factor of
/// the linear part, which removes scale, shear and mirroring (of a mirrored bone the weakest axis
/// is flipped back); the translation is kept. A transform that is not finite gives the identity.
PELAGE_API DualQuaternion toDualQuaternion(const AffineTransform& transform);

/// Returns the skinning transforms (bind space to world) of a pose: world * inverse(bind) for each
/// bone. `world` [bone] is bone space to world. A bone whose bind transform is singular gets
/// `world`.
PELAGE_API std::vector<AffineTransform> skinningTransforms(const Skeleton& skeleton,
                                                           std::span<const AffineTransform> world);

}  // namespace pelage
