#include "bench_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pelage/demo/groom.h"
#include "reference/rod/exact_rod.h"
#include "reference/rod/planar_chain.h"
#include "reference/rod/static_rod.h"

namespace bench {

using pelage::HairAsset;
using pelage::Result;
using pelage::rod::axisAngle;
using pelage::rod::cross;
using pelage::rod::dot;
using pelage::rod::ExactRod;
using pelage::rod::helixPoints;
using pelage::rod::PlanarChain;
using pelage::rod::pointAt;
using pelage::rod::Quaterniond;
using pelage::rod::RestStrand;
using pelage::rod::RodSettings;
using pelage::rod::RootPose;
using pelage::rod::rotationBetween;
using pelage::rod::StaticRod;
using pelage::rod::straightPoints;
using pelage::rod::Vector3d;
using std::numbers::pi;

namespace {

// Classic strands are stiff with it; it has no equivalent in bending stiffness.
constexpr float kClassicStiffness = 0.9f;

RootPose still(double) { return {}; }

// From 0 to 1 in 0.6 s, with no velocity and no acceleration at the ends.
double rampedUp(double time) {
  const double s = std::clamp(time / 0.6, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}

RootPose shakenHead(double time) {
  const double s = rampedUp(time);
  const Quaterniond rotation =
      axisAngle(Vector3d(0, 1, 0), s * 0.8 * std::sin(2 * pi * 1.2 * time)) *
      axisAngle(Vector3d(0, 0, 1), s * 0.3 * std::sin(2 * pi * 1.9 * time));
  const Vector3d shift(s * 0.05 * std::sin(9 * time), 0, s * 0.03 * std::sin(7 * time));
  return {rotation, rotate(rotation, Vector3d(0.1, 0, 0)) + shift};
}

RootPose movedHead(double time) {
  const double s = rampedUp(time);
  const Quaterniond rotation =
      axisAngle(Vector3d(0, 1, 0), s * 0.6 * std::sin(2 * pi * 0.7 * time)) *
      axisAngle(Vector3d(1, 0, 0), s * 0.2 * std::sin(2 * pi * 1.1 * time));
  return {rotation, Vector3d(s * 0.2 * std::sin(2 * pi * 1.9 * time), 0, 0)};
}

template <class T>
void repeat(std::vector<T>& values, uint32_t copies) {
  const std::vector<T> once = values;
  values.reserve(once.size() * copies);
  for (uint32_t k = 1; k < copies; ++k) values.insert(values.end(), once.begin(), once.end());
}

HairAsset repeated(const HairAsset& asset, uint32_t copies) {
  HairAsset result;
  result.strandCount = asset.strandCount * copies;
  result.verticesPerStrand = asset.verticesPerStrand;
  result.positions = asset.positions;
  repeat(result.positions, copies);
  // Copies of an asset that was processed are as valid as it is.
  (void)result.process();
  return result;
}

HairAsset assetOf(const Points& points, uint32_t copies) {
  HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = static_cast<uint32_t>(points.size());
  for (const Vector3d& p : points) {
    const float inverseMass = asset.positions.size() < 2 ? 0.0f : 1.0f;
    asset.positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), inverseMass});
  }
  return repeated(asset, copies);
}

Reference swingReference(const Points& points, const BenchScene& scene) {
  PlanarChain chain(RestStrand(points), scene.bend, scene.airDrag, scene.gravity);
  Reference reference;
  for (int frame = 0; frame < scene.frames; ++frame) {
    for (int k = 0; k < 100; ++k) chain.step(kFrameSeconds / 100);
    reference.frames.push_back(chain.positions());
  }
  return reference;
}

Reference curlReference(const Points& points, const BenchScene& scene) {
  constexpr int kSteps = 128;
  RodSettings settings;
  settings.material = {.bend = scene.bend, .twist = scene.twist, .airDrag = scene.airDrag};
  settings.gravity = Vector3d(0, -scene.gravity, 0);
  settings.maxPasses = 4;
  settings.passTolerance = 0;
  ExactRod<double> rod(RestStrand(points), scene.motion(0));
  for (int frame = 0; frame < scene.settleFrames; ++frame)
    rod.step(kFrameSeconds, scene.motion(0), settings);
  Reference reference;
  for (int frame = 0; frame < scene.frames; ++frame) {
    for (int k = 1; k <= kSteps; ++k) {
      const double time = (frame + static_cast<double>(k) / kSteps) * kFrameSeconds;
      rod.step(kFrameSeconds / kSteps, scene.motion(time), settings);
    }
    reference.frames.push_back(rod.positions());
  }
  return reference;
}

std::optional<Reference> elasticaReference(const Points& points, const BenchScene& scene) {
  StaticRod rod;
  rod.length = length(points.back() - points[0]);
  rod.bend = scene.bend;
  rod.twist = scene.twist;
  rod.gravity = Vector3d(0, -scene.gravity, 0);
  rod.curls = [](double) { return Vector3d(); };
  rod.origin = points[0];
  const auto curve = rod.solve();
  if (!curve) return std::nullopt;
  Reference reference;
  reference.frames.emplace_back(points.size());
  reference.frames[0].back() = curve->back();
  reference.vertices = {static_cast<int>(points.size()) - 1};
  return reference;
}

struct Helix {
  double radius = 0.008, pitch = 0.03, rotations = 3;
  int vertices = 64;
};

std::optional<Reference> helixReference(const Helix& helix, const BenchScene& scene) {
  const double rise = helix.pitch / (2 * pi), speed = std::hypot(helix.radius, rise);
  const double size = 2 * pi * helix.rotations * speed;
  StaticRod rod;
  rod.length = size;
  rod.bend = scene.bend;
  rod.twist = scene.twist;
  rod.gravity = Vector3d(0, -scene.gravity, 0);
  // Frenet frame: x the tangent, y the inward normal, z the binormal.
  const Vector3d tangent = Vector3d(0, -rise, helix.radius) * (1 / speed);
  const Quaterniond toTangent = rotationBetween(Vector3d(1, 0, 0), tangent);
  const Vector3d y = rotate(toTangent, Vector3d(0, 1, 0)), normal(-1, 0, 0);
  const double roll = std::atan2(dot(cross(y, normal), tangent), dot(y, normal));
  rod.clamp = axisAngle(tangent, roll) * toTangent;
  const Vector3d darboux(rise / (speed * speed), 0, helix.radius / (speed * speed));
  rod.curls = [darboux](double) { return darboux; };
  const auto curve = rod.solve();
  if (!curve) return std::nullopt;
  Reference reference;
  reference.frames.emplace_back(static_cast<size_t>(helix.vertices));
  for (int i = 2; i < helix.vertices; ++i) {
    reference.vertices.push_back(i);
    reference.frames[0][static_cast<size_t>(i)] = pointAt(*curve, i / (helix.vertices - 1.0));
  }
  return reference;
}

// A straight strand of 0.3 m, so many degrees below the horizontal, that falls.
BenchScene fallingStrand(const char* name, double degrees, double bendLength, int frames,
                         uint32_t copies) {
  const double angle = -degrees * pi / 180;
  const Points points = straightPoints(32, 0.3, Vector3d(std::cos(angle), std::sin(angle), 0));
  BenchScene scene;
  scene.name = name;
  scene.motion = still;
  scene.frames = frames;
  scene.bend = 9.81 * std::pow(bendLength, 3);
  scene.twist = 0.75 * scene.bend;
  if (bendLength > 0) scene.localStiffness = kClassicStiffness;
  scene.reference = [points, scene] { return std::optional(swingReference(points, scene)); };
  scene.asset = assetOf(points, copies);
  return scene;
}

}  // namespace

BenchScene limpSwing(uint32_t copies) { return fallingStrand("limp_swing", 60, 0, 60, copies); }

BenchScene limpWhip(uint32_t copies) { return fallingStrand("limp_whip", 0, 0, 60, copies); }

BenchScene softSwing(uint32_t copies) { return fallingStrand("soft_swing", 0, 0.05, 60, copies); }

BenchScene stiffSwing(uint32_t copies) { return fallingStrand("stiff_swing", 0, 0.15, 60, copies); }

BenchScene shakenCurl(uint32_t copies) {
  const Points points = helixPoints(32, 0.008, 0.06, 4);
  BenchScene scene;
  scene.name = "shaken_curl";
  scene.motion = shakenHead;
  scene.settleFrames = 400;
  scene.frames = 120;
  scene.bend = scene.twist = 1e-3;
  scene.airDrag = 3;
  scene.localStiffness = kClassicStiffness;
  scene.reference = [points, scene] { return std::optional(curlReference(points, scene)); };
  scene.asset = assetOf(points, copies);
  return scene;
}

BenchScene elastica(uint32_t copies) {
  const Points points = straightPoints(32, 0.2, Vector3d(1, 0, 0));
  BenchScene scene;
  scene.name = "elastica_tip";
  scene.motion = still;
  scene.settleFrames = 700;
  scene.frames = 20;
  scene.bend = 9.81e-3;
  scene.twist = 0.75 * scene.bend;
  scene.airDrag = 5;
  scene.localStiffness = kClassicStiffness;
  scene.reference = [points, scene] { return elasticaReference(points, scene); };
  scene.asset = assetOf(points, copies);
  return scene;
}

BenchScene saggingHelix(uint32_t copies) {
  const Helix helix;
  BenchScene scene;
  scene.name = "helix_sag";
  scene.motion = still;
  scene.settleFrames = 1180;
  scene.frames = 20;
  scene.bend = 1e-3;
  scene.twist = 0.75e-3;
  scene.airDrag = 8;
  scene.localStiffness = kClassicStiffness;
  scene.reference = [helix, scene] { return helixReference(helix, scene); };
  scene.asset =
      assetOf(helixPoints(helix.vertices, helix.radius, helix.pitch, helix.rotations), copies);
  return scene;
}

BenchScene movedGroom(std::string name, const HairAsset& asset, uint32_t copies, double carry) {
  BenchScene scene;
  scene.name = std::move(name);
  scene.asset = repeated(asset, copies);
  scene.motion = movedHead;
  scene.frames = 240;
  scene.bend = 1e-3;
  scene.twist = 0.75e-3;
  scene.airDrag = -60 * std::log(1 - 0.04);
  scene.carry = carry;
  scene.localStiffness = kClassicStiffness;
  scene.reference = [] { return std::nullopt; };
  return scene;
}

BenchScene restingGroom(std::string name, const HairAsset& asset, uint32_t copies) {
  BenchScene scene = movedGroom(std::move(name), asset, copies, 0);
  scene.motion = still;
  scene.settleFrames = 900;
  scene.frames = 60;
  scene.sleeps = true;
  return scene;
}

Result<HairAsset> generatedHair(uint32_t strands) {
  pelage::GroomDef def;
  def.strandCount = strands;
  def.verticesPerStrand = 32;
  auto groom = pelage::generateGroom(def);
  if (!groom) return groom.error();
  return std::move(groom->hair);
}

}  // namespace bench
