// Motions of the character, as functions of time.
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "base/portable_math.h"
#include "base/vector3.h"
#include "pelage/demo/character.h"

namespace pelage {
namespace {

using detail::sinCos;
using Vector = detail::Vector3<double>;
using Rotation = detail::UnitQuaternion<double>;

constexpr double kDegree = detail::kPi / 180;
constexpr double kGravity = 9.81;  // m/s2

enum BoneIndex : size_t {
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kLeftArm,
  kRightArm = 9,
  kBoneCount = 13
};
enum ArmBone : size_t { kClavicle, kUpperArm, kForearm, kHand };

// How far the bones are turned from the bind pose, in degrees about their own joints: z first, then
// x, then y. Where the hips are moved to [m].
struct Pose {
  Vector hips;
  std::array<Vector, kBoneCount> jointRotations;

  void add(const Pose& other, double share) {
    hips += other.hips * share;
    for (size_t i = 0; i < kBoneCount; ++i) jointRotations[i] += other.jointRotations[i] * share;
  }
};

// Both arms alike: lowered towards the body, swung forwards, bent at the elbow.
void setArm(Pose& pose, bool left, double lowered, double forwards, double bent) {
  const size_t first = left ? kLeftArm : kRightArm;
  const double side = left ? 1 : -1;
  pose.jointRotations[first + kUpperArm] = {-forwards, 0, -side * lowered};
  pose.jointRotations[first + kForearm] = {-bent, 0, 0};
  pose.jointRotations[first + kHand] = {-0.15 * bent, 0, -side * 0.1 * lowered};
}

// From 0 to 1 without velocity and acceleration at the ends.
double smootherStep(double from, double to, double t) {
  const double x = detail::saturate((t - from) / (to - from));
  return x * x * x * (x * (6 * x - 15) + 10);
}

double sine(double jointRotations) { return sinCos(detail::kTwoPi * jointRotations).sine; }
double cosine(double jointRotations) { return sinCos(detail::kTwoPi * jointRotations).cosine; }

constexpr double kStride = 1.0;  // s of two steps

Pose walk(double seconds) {
  const double phase = seconds / kStride;
  const double swing = sine(phase), lag = sine(phase - 0.07);
  const double bob = 0.5 - 0.5 * cosine(2 * phase);  // twice a stride
  Pose pose;
  pose.hips = {0.012 * swing, -0.022 * bob, 0};
  pose.jointRotations[kHips] = {0, 6 * swing, -3 * swing};
  pose.jointRotations[kSpine] = {3 + bob, -7 * swing, 2.5 * swing};
  pose.jointRotations[kChest] = {1, -6 * swing, 1.5 * swing};
  pose.jointRotations[kNeck] = {-1.5 - bob, 4 * lag, -0.5 * swing};
  pose.jointRotations[kHead] = {-2 + 1.5 * bob, 3 * lag, -0.5 * swing};
  setArm(pose, true, 27, 26 * swing, 16 + 9 * swing);
  setArm(pose, false, 27, -26 * swing, 16 - 9 * swing);
  return pose;
}

constexpr double kShakeTime = 1.2;  // s

Pose headShake(double seconds) {
  const double amount =
      smootherStep(0, 0.30, seconds) * (1 - smootherStep(0.80, kShakeTime, seconds));
  const double yaw = 62 * amount * sine(1.75 * seconds);
  Pose pose;
  pose.jointRotations[kChest] = {0, -0.08 * yaw, 0};
  pose.jointRotations[kNeck] = {2 * amount, 0.42 * yaw, 0};
  pose.jointRotations[kHead] = {5 * amount, 0.66 * yaw, -0.05 * yaw};
  setArm(pose, true, 12 * amount, 3 * amount, 8 * amount);
  setArm(pose, false, 12 * amount, 3 * amount, 8 * amount);
  return pose;
}

// The jump: crouch, push off, fly, land, rise. In the air the hips follow the parabola that leaves
// and meets 0 at the same speed.
constexpr double kCrouched = 0.30, kLaunch = 0.46, kTouch = 0.76, kLanded = 0.93, kJumpTime = 1.30;
constexpr double kLaunchSpeed = kGravity * (kTouch - kLaunch) / 2;

struct State {
  double slot, speed, acceleration;
};

// The quintic that takes one state to another (Hermite interpolation of place, speed and
// acceleration): a Taylor polynomial of the first state and three terms for the second.
double quintic(const State& a, const State& b, double duration, double t) {
  const double x = t / duration, x3 = x * x * x;
  const double slot = a.slot + t * (a.speed + t * a.acceleration / 2);
  const double end = a.slot + duration * (a.speed + duration * a.acceleration / 2);
  const double dp = b.slot - end;
  const double dv = (b.speed - a.speed - a.acceleration * duration) * duration;
  const double da = (b.acceleration - a.acceleration) * duration * duration;
  return slot + x3 * ((10 * dp - 4 * dv + da / 2) +
                      x * ((-15 * dp + 7 * dv - da) + x * (6 * dp - 3 * dv + da / 2)));
}

double jumpHeight(double t) {
  constexpr State kRest = {0, 0, 0}, kLow = {-0.070, 0, 4}, kSoft = {-0.060, 0, 3};
  constexpr State kUp = {0, kLaunchSpeed, -kGravity}, kDown = {0, -kLaunchSpeed, -kGravity};
  if (t < kCrouched) return quintic(kRest, kLow, kCrouched, t);
  if (t < kLaunch) return quintic(kLow, kUp, kLaunch - kCrouched, t - kCrouched);
  if (t < kTouch) return (t - kLaunch) * (kLaunchSpeed - kGravity / 2 * (t - kLaunch));
  if (t < kLanded) return quintic(kDown, kSoft, kLanded - kTouch, t - kTouch);
  return quintic(kSoft, kRest, kJumpTime - kLanded, t - kLanded);
}

Pose jump(double seconds) {
  const double t = std::min(std::max(seconds, 0.0), kJumpTime);
  const double crouch =
      smootherStep(0, kCrouched, t) - smootherStep(kCrouched, 0.50, t) +
      0.8 * (smootherStep(0.72, kLanded, t) - smootherStep(kLanded, kJumpTime, t));
  const double flight = smootherStep(0.32, 0.56, t) - smootherStep(0.66, 0.95, t);
  Pose pose;
  pose.hips = {0, jumpHeight(t), -0.02 * crouch};
  pose.jointRotations[kHips] = {6 * crouch - 3 * flight, 0, 0};
  pose.jointRotations[kSpine] = {9 * crouch - 4 * flight, 0, 0};
  pose.jointRotations[kChest] = {4 * crouch - 4 * flight, 0, 0};
  pose.jointRotations[kNeck] = {-7 * crouch + 2 * flight, 0, 0};
  pose.jointRotations[kHead] = {-9 * crouch + 6 * flight, 0, 0};
  for (const bool left : {true, false})
    setArm(pose, left, 16 * crouch - 14 * flight, -20 * crouch + 38 * flight,
           20 * crouch + 20 * flight);
  return pose;
}

constexpr double kBreath = 4.0;  // s

Pose idle(double seconds) {
  const double in = 0.5 - 0.5 * cosine(seconds / kBreath), shift = sine(seconds / kBreath);
  Pose pose;
  pose.hips = {0.006 * shift, -0.002 * in, 0};
  pose.jointRotations[kHips] = {0, 1.5 * shift, -shift};
  pose.jointRotations[kSpine] = {0.5 * in, -shift, shift};
  pose.jointRotations[kChest] = {-2 * in, 0, 0};
  pose.jointRotations[kHead] = {1.5 * in, 3 * shift, 0.5 * shift};
  setArm(pose, true, 24 + 2 * in, 2 * shift, 10);
  setArm(pose, false, 24 + 2 * in, -2 * shift, 10);
  return pose;
}

// Times of kAll.
constexpr double kWalkEnd = 1.45, kShakeStart = 1.35, kJumpStart = 2.60, kAllTime = 4.0;
constexpr double kWalkIn = 0.45;  // s until it walks as it will go on

Pose poseAt(CharacterMotion motion, double t) {
  Pose pose;
  if (!(t > 0) || !std::isfinite(t)) return pose;
  const CharacterCycle cycle = characterCycle(motion);
  // Beyond the end of the cycle time goes back to its start.
  const double length = cycle.end - cycle.start;
  if (t > cycle.end && length > 0) t = cycle.start + std::fmod(t - cycle.start, length);
  switch (motion) {
    case CharacterMotion::kIdle:
      pose.add(idle(t), smootherStep(0, 0.8, t));
      break;
    case CharacterMotion::kWalk:
      pose.add(walk(t), smootherStep(0, kWalkIn, t));
      break;
    case CharacterMotion::kHeadShake:
      pose = headShake(t);
      break;
    case CharacterMotion::kJump:
      pose = jump(t);
      break;
    case CharacterMotion::kAll:
      pose.add(walk(t), smootherStep(0, kWalkIn, t) - smootherStep(kWalkEnd - 0.4, kWalkEnd, t));
      pose.add(headShake(std::max(t - kShakeStart, 0.0)), 1);
      pose.add(jump(t - kJumpStart), 1);
      break;
    case CharacterMotion::kBind:
      break;
  }
  return pose;
}

Rotation about(double x, double y, double z, double degrees) {
  const detail::SinCos half = sinCos(degrees * kDegree / 2);
  return {x * half.sine, y * half.sine, z * half.sine, half.cosine};
}

}  // namespace

CharacterCycle characterCycle(CharacterMotion motion) {
  switch (motion) {
    case CharacterMotion::kIdle:
      return {kBreath, 2 * kBreath};
    case CharacterMotion::kWalk:
      return {kStride, 2 * kStride};
    case CharacterMotion::kHeadShake:
      return {0, kShakeTime};
    case CharacterMotion::kJump:
      return {0, kJumpTime};
    case CharacterMotion::kAll:
      return {0, kAllTime};
    case CharacterMotion::kBind:
      break;
  }
  return {};
}

std::vector<AffineTransform> poseCharacter(CharacterMotion motion, double seconds) {
  static const Skeleton skeleton = characterSkeleton();
  const Pose pose = poseAt(motion, seconds);
  std::array<Rotation, kBoneCount> rotations;
  std::array<Vector, kBoneCount> slots;
  std::vector<AffineTransform> world(kBoneCount);
  const auto joint = [&](size_t bone) {
    const AffineTransform& bind = skeleton.bones[bone].bind;
    return Vector{bind.rows[0].w, bind.rows[1].w, bind.rows[2].w};
  };
  for (size_t i = 0; i < kBoneCount; ++i) {
    const Vector& rotation = pose.jointRotations[i];
    const Rotation own =
        about(0, 1, 0, rotation.y) * about(1, 0, 0, rotation.x) * about(0, 0, 1, rotation.z);
    if (skeleton.bones[i].parent < 0) {
      rotations[i] = own;
      slots[i] = joint(i) + pose.hips;
    } else {
      const auto parent = static_cast<size_t>(skeleton.bones[i].parent);
      rotations[i] = normalized(rotations[parent] * own);
      slots[i] = slots[parent] + rotate(rotations[parent], joint(i) - joint(parent));
    }
    const Rotation& q = rotations[i];
    world[i] = rigidTransform({static_cast<float>(q.x), static_cast<float>(q.y),
                               static_cast<float>(q.z), static_cast<float>(q.w)},
                              {static_cast<float>(slots[i].x), static_cast<float>(slots[i].y),
                               static_cast<float>(slots[i].z)});
  }
  return world;
}

}  // namespace pelage
