#include "head_motion.h"

#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>

#include "names.h"

namespace sample {

using pelage::Quaternion;

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kNeckShare = 0.4;

struct Key {
  double time;              // s
  double yaw, pitch, roll;  // degrees
};

// Looks left, swings over to the right, comes back, nods twice.
constexpr Key kKeys[] = {
    {0.00, 0, 0, 0},    {0.20, 0, 0, 0},   {0.80, 58, 4, -6}, {1.00, 60, 4, -6},
    {1.85, -58, 2, 7},  {2.05, -60, 2, 7}, {2.70, 0, 0, 0},   {3.00, 0, 24, 0},
    {3.30, 2, -10, -1}, {3.60, 0, 17, 1},  {3.95, 0, 0, 0},   {kHeadMotionSeconds, 0, 0, 0},
};

double smootherStep(double x) { return x * x * x * (x * (6 * x - 15) + 10); }

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
      a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace

HeadPose headPose(double seconds) {
  double time = std::fmod(seconds, kHeadMotionSeconds);
  if (time < 0) time += kHeadMotionSeconds;
  const Key* to = kKeys + 1;
  while (to->time < time && to + 1 != std::end(kKeys)) ++to;
  const Key* from = to - 1;
  const double s = smootherStep((time - from->time) / (to->time - from->time));
  const auto blend = [s](double a, double b) { return (a + (b - a) * s) * kDegree; };
  return {blend(from->yaw, to->yaw), blend(from->pitch, to->pitch), blend(from->roll, to->roll)};
}

Quaternion poseRotation(const HeadPose& pose, double share) {
  const auto half = [share](double angle) { return share * angle / 2; };
  const auto sine = [&](double angle) { return static_cast<float>(std::sin(half(angle))); };
  const auto cosine = [&](double angle) { return static_cast<float>(std::cos(half(angle))); };
  const Quaternion yaw = {0, sine(pose.yaw), 0, cosine(pose.yaw)};
  const Quaternion pitch = {sine(pose.pitch), 0, 0, cosine(pose.pitch)};
  const Quaternion roll = {0, 0, sine(pose.roll), cosine(pose.roll)};
  return product(product(yaw, pitch), roll);
}

AffineTransform rotationAbout(const Quaternion& rotation, const Float3& pivot) {
  const AffineTransform relativeRotation = pelage::rigidTransform(rotation, {});
  const Float3 moved = pelage::transformPoint(relativeRotation, pivot);
  return pelage::rigidTransform(rotation,
                                {pivot.x - moved.x, pivot.y - moved.y, pivot.z - moved.z});
}

std::vector<AffineTransform> poseSkeleton(const pelage::Skeleton& skeleton, const HeadPose& pose) {
  std::vector<AffineTransform> skinning(skeleton.bones.size());
  for (size_t i = 0; i < skinning.size(); ++i) {
    const pelage::Bone& bone = skeleton.bones[i];
    const double share = bone.name == "head"   ? 1 - kNeckShare
                         : bone.name == "neck" ? kNeckShare
                                               : 0;
    const Float3 joint = {bone.bind.rows[0].w, bone.bind.rows[1].w, bone.bind.rows[2].w};
    // The joint turns in bind space, then the parent carries it along.
    const AffineTransform own = rotationAbout(poseRotation(pose, share), joint);
    skinning[i] =
        bone.parent < 0 ? own : pelage::multiply(skinning[static_cast<size_t>(bone.parent)], own);
  }
  return skinning;
}

}  // namespace sample
