#include "stress/fuzz_group.h"

#include <algorithm>
#include <cmath>

#include "pelage/random.h"
#include "reference/rod/rod_fuzz.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using rod::FuzzCase;

float narrow(double value) { return static_cast<float>(value); }
Float3 narrowed(const rod::Vector3d& v) { return {narrow(v.x), narrow(v.y), narrow(v.z)}; }

HairAsset toAsset(const std::vector<FuzzCase>& cases) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(cases.size());
  // The same for all groups, since a driver may compile a kernel for it.
  asset.verticesPerStrand = 128;
  for (const FuzzCase& c : cases)
    asset.vertexCounts.push_back(static_cast<uint32_t>(c.points.size()));
  for (const FuzzCase& c : cases) {
    const size_t tip = c.points.size() - 1;
    for (size_t v = 0; v < asset.verticesPerStrand; ++v) {
      const Float3 p = narrowed(c.points[std::min(v, tip)]);
      const bool held = v < 2 || (v >= tip && cases[0].settings.holdTip);
      asset.positions.push_back({p.x, p.y, p.z, held ? 0.0f : 1.0f});
    }
  }
  return asset;
}

SimulationSettings toSettings(const rod::RodSettings& from, Solver solver, uint32_t seed) {
  const rod::RodMaterial& material = from.material;
  pelage::Random random(seed, 0);
  const auto between = [&](double low, double high) {
    return low + (high - low) * random.uniformDouble();
  };
  SimulationSettings s;
  s.solver = solver;
  s.gravity = narrowed(from.gravity);
  s.damping = narrow(1 - std::exp(-material.airDrag / 60));
  s.bendLength = narrow(std::cbrt(material.bend / 9.81));
  s.twistRatio = narrow(material.bend > 0 ? material.twist / material.bend : 0.75);
  s.relaxationTime = narrow(material.relaxation);
  s.globalStiffness = narrow(from.globalStiffness);
  s.globalRange = narrow(from.globalRange);
  s.vspCoefficient = narrow(from.transport);
  s.vspThreshold = narrow(from.transportThreshold);
  s.wind.velocity = narrowed(from.wind);
  // The classic solver's own settings.
  s.localStiffness = narrow(between(0, 1) < 0.3 ? 0 : between(0, 1));
  s.localIterations = 1 + static_cast<uint32_t>(between(0, 16));
  s.lengthIterations = 1 + static_cast<uint32_t>(between(0, 16));
  s.airDrag = narrow(between(0, 20));
  s.maxSpeed = narrow(between(0, 1) < 0.5 ? 50 : between(0.1, 1e4));
  s.sagCompensation = narrow(between(0, 1) < 0.5 ? 0 : between(0, 1));
  return s;
}

AffineTransform boneOf(const rod::Quaterniond& rotation, const rod::Vector3d& shift) {
  const rod::Vector3d x = rotate(rotation, rod::Vector3d(1, 0, 0)),
                      y = rotate(rotation, rod::Vector3d(0, 1, 0)),
                      z = rotate(rotation, rod::Vector3d(0, 0, 1));
  AffineTransform bone;
  bone.rows[0] = {narrow(x.x), narrow(y.x), narrow(z.x), narrow(shift.x)};
  bone.rows[1] = {narrow(x.y), narrow(y.y), narrow(z.y), narrow(shift.y)};
  bone.rows[2] = {narrow(x.z), narrow(y.z), narrow(z.z), narrow(shift.z)};
  return bone;
}

}  // namespace

FuzzGroup makeFuzzGroup(uint32_t seed, uint32_t strands, int frames, Solver solver, bool cached) {
  std::vector<FuzzCase> cases;
  for (uint32_t s = 0; s < strands; ++s) cases.push_back(rod::makeFuzzCase(seed + s, frames));
  const FuzzCase& first = cases[0];
  FuzzGroup group;
  group.asset = toAsset(cases);
  group.settings = toSettings(first.settings, solver, seed);
  group.heldTips = first.settings.holdTip;
  if (cached) {
    group.settings.gravity.x = group.settings.wind.velocity.x = 0;
    if (group.settings.wind.velocity.z == 0) group.settings.wind.velocity.z = 0.1f;
    if (std::isinf(group.settings.vspThreshold)) group.settings.vspThreshold = 1e4f;
  }
  for (const double step : first.steps) group.steps.push_back(narrow(step));
  // Half of the colliders stay where they are; the others are carried along, so that strands that
  // have gone far from the start meet some, too.
  const bool transported = (seed / strands) % 2 == 1;
  for (size_t frame = 0; frame < first.poses.size(); ++frame) {
    const rod::Vector3d& shift = first.poses[frame].translation;
    std::vector<AffineTransform>& bones = group.bones.emplace_back();
    for (const FuzzCase& c : cases) bones.push_back(boneOf(c.poses[frame].rotation, shift));
    std::vector<CapsuleCollider>& colliders = group.colliders.emplace_back();
    for (const rod::RodCollider& c : first.colliders) {
      const rod::Vector3d displacement = transported ? shift : rod::Vector3d();
      colliders.push_back({.head = narrowed(c.head + displacement),
                           .headRadius = narrow(c.headRadius),
                           .tail = narrowed(c.tail + displacement),
                           .tailRadius = narrow(c.tailRadius),
                           .friction = narrow(c.friction)});
    }
  }
  return group;
}

}  // namespace pelage::test
