// The bones of a character in a scene, which hair objects and colliders follow together. Made by
// Scene::addSkeleton().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "pelage/types.h"

namespace pelage {

namespace detail {
struct SkeletonInternals;
}

struct SkeletonDef {
  std::string name = "skeleton";
  uint32_t boneCount = 1;  ///< transforms that setBones() takes, >= 1
};

/// Its transforms are uploaded once for all that follows it, in frames in which they changed and
/// something reads them. What follows it shares an origin, too: positions are as exact as floats
/// are at the distance from what was added first.
class SkeletonPose {
 public:
  ~SkeletonPose();
  const std::string& name() const { return name_; }
  uint32_t boneCount() const;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that there are boneCount() of them. Non-finite ones leave their bone where it was.
  void setBones(std::span<const AffineTransform> bones);
  /// As they are now.
  std::span<const AffineTransform> bones() const;

 private:
  friend class Scene;
  SkeletonPose();

  std::string name_;
  std::unique_ptr<detail::SkeletonInternals> internals_;
};

}  // namespace pelage
