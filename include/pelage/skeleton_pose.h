// The bones of a character in a scene, which several hair objects and colliders can follow. Made by
// Scene::addSkeleton().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "pelage/export.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
class SceneImpl;
struct SkeletonInternals;
}  // namespace detail

struct SkeletonDef {
  std::string name = "skeleton";
  uint32_t boneCount = 1;  ///< transforms that setBones() takes, >= 1
};

/// A skeleton uploads its transforms once for everything that follows it, in frames in which they
/// changed and something reads them. Its followers share an origin, too: the precision of their
/// positions is that of floats at their distance from the follower that was added first.
///
/// Threads: the one that uses its scene.
class PELAGE_API SkeletonPose {
 public:
  ~SkeletonPose();
  const std::string& name() const { return name_; }
  uint32_t boneCount() const;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that there are boneCount() of them. A bone with a non-finite transform stays where it was.
  void setBones(std::span<const AffineTransform> bones);
  /// The current transforms.
  std::span<const AffineTransform> bones() const;

 private:
  friend class detail::SceneImpl;
  SkeletonPose();

  std::string name_;
  std::unique_ptr<detail::SkeletonInternals> internals_;
};

}  // namespace pelage
