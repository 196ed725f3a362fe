// The animation of the sample: a head that looks to both sides and nods, and starts over.
#pragma once

#include <vector>

#include "pelage/skeleton.h"
#include "pelage/types.h"

namespace sample {

/// How far the head is turned from its bind pose [radians].
struct HeadPose {
  double yaw = 0;    ///< about +Y: positive to the head's left
  double pitch = 0;  ///< about +X: positive bows the head
  double roll = 0;   ///< about +Z: positive tilts it to its right
};

/// Duration of the motion; it begins and ends at rest in the bind pose, so it can be repeated [s].
inline constexpr double kHeadMotionSeconds = 4.0;

/// The pose at a time; periodic. Velocity and acceleration are continuous: between its key poses
/// each angle follows a quintic with no velocity and no acceleration at the ends.
/// \param seconds any finite time.
HeadPose headPose(double seconds);

/// The rotation of a share of a pose: roll first, then pitch, then yaw.
/// \param share 0..1, factor on the three angles.
pelage::Quaternion poseRotation(const HeadPose& pose, double share = 1.0);

/// Rotation about a fixed point.
pelage::AffineTransform rotationAbout(const pelage::Quaternion& rotation,
                                      const pelage::Float3& pivot);

/// Skinning transforms of a skeleton for a pose: the bone called "neck" turns by two fifths of it
/// and "head" by the rest, each about its own joint; other bones follow their parents.
std::vector<pelage::AffineTransform> poseSkeleton(const pelage::Skeleton& skeleton,
                                                  const HeadPose& pose);

}  // namespace sample
