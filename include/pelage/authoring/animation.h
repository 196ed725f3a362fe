// Clips of glTF files: the motion of a character's bones, to see hair on it. An engine has an
// animation system of its own and needs none of this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "pelage/skeleton.h"
#include "pelage/types.h"

namespace pelage {

/// How values between two keys follow from them: glTF 2.0, appendix C.
enum class KeyInterpolation : uint8_t {
  kStep,
  kLinear,  ///< rotations on the shortest arc
  kCubic,   ///< Hermite splines; each key has an incoming tangent, a value and an outgoing tangent
};

/// Keys of one property of a node; without times the property does not move.
struct AnimationKeys {
  std::vector<float> times;  ///< [s] ascending, >= 0
  /// [key] (kCubic: [key][3]) numbers of the property one after another: 3, or 4 of a rotation
  std::vector<float> values;
  KeyInterpolation interpolation = KeyInterpolation::kLinear;
};

/// A node of the file with its keys. Its transform relative to its parent is `matrix`, then
/// scale, rotation and translation; a file has the one or the other.
struct AnimatedNode {
  std::string name;     ///< "node 3" where the file has none
  int32_t parent = -1;  ///< index of the parent, below this node's own; -1 = none
  AffineTransform matrix;
  Float3 translation;
  Quaternion rotation;
  Float3 scale = {1, 1, 1};
  AnimationKeys translations, rotations, scales;
};

struct SkeletonAnimation {
  std::string name;
  double seconds = 0;               ///< time of the last key [s]
  std::vector<AnimatedNode> nodes;  ///< all nodes of the file, parents first
};

/// Loads a clip of a .gltf or .glb file. \param clip its name; empty takes the first one. Errors
/// name the file and the place in it: everything that does not fit together or leaves the file, a
/// clip that does not exist (the message lists those that do) or moves nothing, times that do not
/// ascend, a number that is not finite, nodes that are no trees.
Result<SkeletonAnimation> loadAnimation(const std::filesystem::path& path,
                                        std::string_view clip = {});
/// The same from memory; `name` names it in errors. A file with buffers of its own needs the path.
Result<SkeletonAnimation> loadAnimation(std::span<const std::byte> bytes, std::string_view name,
                                        std::string_view clip = {});

/// Returns the skeleton of all nodes, in their order. Their bind transforms are those of the file
/// without the animation, which is where loadMesh() and loadSkinnedMesh() put the vertices.
Skeleton skeletonOf(const SkeletonAnimation& animation);

/// Returns the transforms of all nodes (node space to the scene of the file) for
/// skinningTransforms(). \param seconds any finite time; before the first and after the last key
/// nodes stay where these put them.
std::vector<AffineTransform> poseAt(const SkeletonAnimation& animation, double seconds);

}  // namespace pelage
