// A torso and arms as a smooth blend of simple bodies, under the head of head.cpp.
#include "character_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "head.h"
#include "implicit_shapes.h"
#include "pelage/demo/character.h"

namespace pelage {
namespace detail {
namespace {

// The head's surface ends at y = 0; this far below, the body hides it. The body's neck ends inside
// the head, at least this far below its surface.
constexpr double kHeadRange = -0.045, kBodyRange = 0.19;
constexpr double kNeckBlend = 0.03;

constexpr Vector kClavicle = {0.030, -0.035, -0.030}, kShoulder = {0.152, -0.062, -0.040},
                 kElbow = {0.302, -0.241, -0.046}, kWrist = {0.421, -0.394, -0.014},
                 kFingertips = {0.489, -0.495, 0.018};

Vector mirrored(const Vector& p) { return {std::abs(p.x), p.y, p.z}; }

// Parts of a body, blended one after the other. Most are too far away to change a bit of the sum:
// these cost a comparison.
class Blend {
 public:
  Blend(const Vector& p, double first) : p_(p), distance_(first) {}

  void add(const BoundedCapsule& part, double width) {
    if (part.isBeyond(p_, distance_ + width)) return;
    distance_ = smoothUnion(distance_, part.distance(p_), width);
  }
  void add(const BoundedEllipsoid& part, double width) {
    if (part.isBeyond(p_, distance_ + width)) return;
    distance_ = smoothUnion(distance_, part.distance(p_), width);
  }
  double distance() const { return distance_; }

 private:
  const Vector& p_;
  double distance_;
};

// Expects p.x >= 0, as all below.
double torso(const Vector& p) {
  static const BoundedCapsule kShoulders({0, -0.040, -0.042}, {0.132, -0.060, -0.040}, 0.056,
                                         0.047),
      kNeckSide({0, 0.062, -0.042}, {0.118, -0.022, -0.045}, 0.047, 0.034),
      kNeck({0, 0.100, -0.027}, {0, -0.060, -0.036}, 0.0540, 0.0620);
  static const BoundedEllipsoid kChestSide({0.062, -0.112, 0.030}, {0.066, 0.046, 0.030}),
      kShoulderBlade({0.075, -0.120, -0.092}, {0.055, 0.075, 0.026}),
      kBelowArmpit({0.088, -0.170, -0.055}, {0.046, 0.110, 0.052}),
      kWaist({0, -0.300, -0.028}, {0.106, 0.130, 0.074}),
      kHip({0, -0.405, -0.032}, {0.132, 0.095, 0.092});
  Blend parts(p, ellipsoid(p, {0, -0.150, -0.030}, {0.128, 0.145, 0.088}));  // ribs
  parts.add(kShoulders, 0.05);
  parts.add(kNeckSide, 0.05);
  parts.add(kNeck, 0.04);
  parts.add(kChestSide, 0.03);
  parts.add(kShoulderBlade, 0.04);
  parts.add(kBelowArmpit, 0.05);
  parts.add(kWaist, 0.06);
  parts.add(kHip, 0.06);
  return -smoothUnion(-parts.distance(), p.y + 0.47, 0.03);  // cut off below
}

struct BlendedCapsule {
  BoundedCapsule capsule;
  double width;
};

std::vector<BlendedCapsule> armParts() {
  const Vector upper = kElbow - kShoulder, lower = kWrist - kElbow, hand = kFingertips - kWrist;
  std::vector<BlendedCapsule> parts = {
      {{kShoulder, kElbow, 0.047, 0.034}, 0.02},
      {{kShoulder + upper * 0.30 + Vector{0, 0, 0.010},
        kShoulder + upper * 0.75 + Vector{0, 0, 0.008}, 0.036, 0.030},
       0.03},  // biceps
      {{kElbow, kWrist, 0.034, 0.0225}, 0.02},
      {{kElbow + lower * 0.15, kElbow + lower * 0.45, 0.034, 0.031}, 0.03}};
  // A hand like a mitten: palm and fingers side by side, thumb in front.
  const Vector across = {0.25, 0.15, 0.95};
  for (const double side : {-1.0, 0.0, 1.0}) {
    const Vector offset = across * (side * 0.0145);
    parts.push_back(
        {{kWrist + hand * 0.12 + offset * 0.7, kWrist + hand * 0.55 + offset, 0.0170, 0.0150},
         0.016});
    parts.push_back({{kWrist + hand * 0.55 + offset,
                      kFingertips + offset * 0.8 - hand * (0.08 * std::abs(side)), 0.0115, 0.0080},
                     0.008});
  }
  parts.push_back({{kWrist + hand * 0.20 + across * 0.016, kWrist + hand * 0.58 + across * 0.046,
                    0.0135, 0.0085},
                   0.014});
  return parts;
}

double arm(const Vector& p) {
  static const std::vector<BlendedCapsule> kParts = armParts();
  Blend blend(p, taperedCapsule(p, {0.120, -0.058, -0.040}, kShoulder, 0.044, 0.051));
  for (const BlendedCapsule& part : kParts) blend.add(part.capsule, part.width);
  return blend.distance();
}

// Parts too far away to change the surface are left out.
double body(const Vector& p) {
  if (p.x > 0.26) return arm(p);
  const double d = torso(p);
  return p.x < 0.03 || p.y > 0.06 ? d : smoothUnion(d, arm(p), 0.03);
}

template <class Body, class HeadDistance>
double withHead(const Vector& p, const Body& below, const HeadDistance& head) {
  if (p.y > kBodyRange) return head(p);
  return p.y > kHeadRange ? smoothUnion(below(mirrored(p)), head(p), kNeckBlend)
                          : below(mirrored(p));
}

// A share of the way from a to b that a point is at, along the line through them.
double along(const Vector& p, const Vector& a, const Vector& b) {
  const Vector axis = b - a;
  return dot(p - a, axis) / dot(axis, axis);
}

double armShare(const Vector& p) { return smoothStep(-0.030, 0.030, torso(p) - arm(p)); }

enum BoneIndex : uint32_t { kHips, kSpine, kChest, kNeck, kHead, kLeftArm };
constexpr uint32_t kBonesAnArm = 4;

}  // namespace

double characterSurface(const Vector& p) { return withHead(p, body, headSurface); }
Vector characterNormal(const Vector& p) { return gradientOf(p, characterSurface); }
double combedCharacter(const Vector& p) { return withHead(p, body, combedSurface); }
Vector combedCharacterNormal(const Vector& p) { return gradientOf(p, combedCharacter); }
Vector characterSkullNormal(const Vector& p) {
  return p.y > 0.12 ? skullNormal(p) : characterNormal(p);
}

double trunkSurface(const Vector& p) { return withHead(p, torso, combedSurface); }

double leftArmSurface(const Vector& p) { return arm(p); }

ArmJoints leftArmJoints() { return {kClavicle, kShoulder, kElbow, kWrist, kFingertips}; }

BoneInfluences characterBones(const Vector& point) {
  const Vector p = mirrored(point);
  std::array<std::pair<double, uint32_t>, 9> shares = {};
  const double arms = armShare(p);
  // Down the trunk: each joint leaves a share to the bone below it.
  const double head = p.y > kHeadRange ? headBoneShare(p) : 0;
  const double neck = smoothStep(-0.030, 0.055, p.y - 0.3 * p.z);
  const double chest = smoothStep(-0.260, -0.170, p.y);
  const double spine = smoothStep(-0.400, -0.310, p.y);
  double rest = 1 - arms;
  const auto take = [&](size_t slot, double share, uint32_t bone) {
    shares[slot] = {rest * share, bone};
    rest *= 1 - share;
  };
  take(0, head, kHead);
  take(1, neck, kNeck);
  const uint32_t first = kLeftArm + (point.x < 0 ? kBonesAnArm : 0);
  take(2, 0.8 * smoothStep(0.035, 0.115, p.x) * smoothStep(-0.170, -0.080, p.y), first);
  take(3, chest, kChest);
  take(4, spine, kSpine);
  take(5, 1, kHips);
  rest = arms;
  take(6, smoothStep(0.85, 1.15, along(p, kElbow, kWrist)), first + 3);
  take(7, smoothStep(0.86, 1.14, along(p, kShoulder, kElbow)), first + 2);
  take(8, 1, first + 1);

  // The four largest; equal ones by their bone.
  std::sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) {
    return std::pair(-a.first, a.second) < std::pair(-b.first, b.second);
  });
  double sum = 0;
  for (size_t i = 0; i < 4; ++i) sum += shares[i].first;
  BoneInfluences influences;
  for (size_t i = 0; i < 4; ++i) {
    influences.weights[i] = static_cast<float>(shares[i].first / sum);
    influences.bones[i] = shares[influences.weights[i] > 0 ? i : 0].second;
  }
  return influences;
}

double furShare(const Vector& point) {
  const Vector p = mirrored(point);
  const double neck = 1 - smoothStep(0.000, 0.040, p.y - 0.25 * (p.x - 0.05) + 0.5 * (p.z + 0.04));
  const double arms = armShare(p);
  const double onArm = 1 - smoothStep(0.55, 0.85, along(p, kShoulder, kElbow));
  const double onTrunk = smoothStep(-0.270, -0.190, p.y + 0.2 * p.x);
  return neck * (arms * onArm + (1 - arms) * onTrunk);
}

bool isMohawkStrip(const Vector& p) {
  // As wide as two fingers, ending at the back of the head.
  const double width = 0.019 * smoothStep(0.165, 0.215, p.y - 0.2 * p.z);
  return std::abs(p.x) < width;
}

}  // namespace detail

float characterDistance(const Float3& point) {
  return static_cast<float>(detail::characterSurface({point.x, point.y, point.z}));
}

Skeleton characterSkeleton() {
  using detail::Vector;
  Skeleton skeleton;
  const auto add = [&](const char* name, int32_t parent, const Vector& position) {
    skeleton.bones.push_back({name, parent, rigidTransform({}, detail::toFloat3(position))});
  };
  add("hips", -1, {0, -0.420, -0.035});
  add("spine", 0, {0, -0.350, -0.035});
  add("chest", 1, {0, -0.210, -0.040});
  add("neck", 2, {0, 0.030, -0.035});
  add("head", 3, {0, 0.150, -0.020});
  const detail::ArmJoints left = detail::leftArmJoints();
  int32_t first = 5;
  for (const double side : {1.0, -1.0}) {
    const auto at = [&](const Vector& p) { return Vector{side * p.x, p.y, p.z}; };
    const bool isLeft = side > 0;
    add(isLeft ? "clavicle.L" : "clavicle.R", 2, at(left.clavicle));
    add(isLeft ? "upperArm.L" : "upperArm.R", first, at(left.shoulder));
    add(isLeft ? "forearm.L" : "forearm.R", first + 1, at(left.elbow));
    add(isLeft ? "hand.L" : "hand.R", first + 2, at(left.wrist));
    first += 4;
  }
  return skeleton;
}

}  // namespace pelage
