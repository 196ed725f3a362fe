#include "rod_fuzz.h"

#include <numbers>
#include <random>

namespace pelage::rod {
namespace {

// The distributions of the standard library differ from one implementation to the next.
class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed * 7919u + 13u) {}
  uint32_t integer() { return static_cast<uint32_t>(engine_()); }
  double between(double a, double b) { return a + (b - a) * (integer() / 4294967296.0); }
  bool chance(double share) { return between(0, 1) < share; }
  double logBetween(double a, double b) { return std::exp(between(std::log(a), std::log(b))); }
  Vector3d cube(double half) {
    const double x = between(-half, half), y = between(-half, half), z = between(-half, half);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

std::vector<Vector3d> randomPoints(Random& random) {
  enum Kind : uint32_t { kEven, kWide, kUneven, kGaps, kFolds, kPoint, kKinds };
  const uint32_t kind = random.integer() % kKinds;
  const int n = 3 + static_cast<int>(random.between(0, 1) * random.between(0, 1) * 126);
  const double base = random.logBetween(1e-6, 3e-2);
  const double relativeRotation = random.chance(0.2) ? 3.1 : random.between(0, 0.5);
  const double spread = kind == kWide ? 100 : kind == kUneven ? 3 : 1.0001;
  std::vector<Vector3d> points(1);
  Vector3d direction(0, -1, 0);
  while (static_cast<int>(points.size()) < n) {
    direction = directionOr(direction + random.cube(1) * relativeRotation, Vector3d(0, -1, 0));
    double size = base * random.logBetween(1, spread);
    if (kind == kPoint || (kind == kGaps && random.chance(0.1))) size = 0;
    if (kind == kFolds && random.chance(1.0 / 7)) direction = -direction;
    points.push_back(points.back() + direction * size);
  }
  return points;
}

}  // namespace

FuzzCase makeFuzzCase(uint32_t seed, int frames) {
  Random random(seed);
  FuzzCase result;
  result.points = randomPoints(random);
  RodMaterial& material = result.settings.material;
  material.bend = random.chance(0.1) ? 0 : random.logBetween(1e-9, 1e2);
  material.twist = material.bend * random.logBetween(0.05, 10);
  material.airDrag = random.chance(0.3) ? 0 : random.between(0, 20);
  material.relaxation = random.chance(0.7) ? 0 : random.logBetween(1e-4, 1e-1);
  result.settings.gravity = random.cube(1) * random.logBetween(1e-3, 1e4);
  if (random.chance(0.3)) result.settings.wind = random.cube(1) * random.logBetween(0.1, 1e3);
  if (random.chance(0.2)) {
    result.settings.globalStiffness = random.between(0, 1);
    result.settings.globalRange = random.between(0, 1);
  }
  result.settings.holdTip = random.chance(0.05);
  if (random.chance(0.3)) {
    result.settings.transport = random.between(0, 1);
    result.settings.transportThreshold = random.logBetween(10, 1e4);
  }
  if (random.chance(0.4)) {
    Vector3d center = random.cube(0.2);
    center.y -= 0.15;
    RodCollider shape = RodCollider::sphere(center, random.logBetween(1e-3, 0.3));
    if (random.chance(0.5)) {
      shape.tail = shape.tailBefore = center + random.cube(0.2);
      shape.tailRadius = random.logBetween(1e-3, 0.3);
    }
    if (random.chance(0.5)) shape.friction = random.between(0, 1);
    result.colliders.push_back(shape);
  }
  const bool steady = random.chance(0.5);
  for (int f = 0; f < frames; ++f) {
    result.steps.push_back(steady ? 1 / 60.0 : random.between(1 / 240.0, 1 / 15.0));
  }
  const double teleports = random.chance(0.3) ? 0.05 : 0;
  const double rotations = random.chance(0.5) ? 0.1 : std::numbers::pi;
  RootPose pose;
  result.poses.push_back(pose);
  for (int f = 0; f < frames; ++f) {
    const Vector3d axis = directionOr(random.cube(1), Vector3d(1, 0, 0));
    pose.rotation =
        normalized(axisAngle(axis, random.between(-rotations, rotations)) * pose.rotation);
    pose.translation += random.cube(0.03);
    if (random.chance(teleports)) pose.translation += random.cube(3);
    result.poses.push_back(pose);
  }
  return result;
}

}  // namespace pelage::rod
