#include "exact_solver.h"

#include <algorithm>
#include <cmath>

namespace pelage::detail {
namespace {

struct Rotation {
  double x = 0, y = 0, z = 0, w = 1;
};

Rotation rotationOf(const Quaternion& q) {
  return {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z),
          static_cast<double>(q.w)};
}

// conj(a) b, normalised.
Float4 relative(const Quaternion& from, const Quaternion& to) {
  const Rotation a = rotationOf(from), b = rotationOf(to);
  Rotation r = {
      a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y, a.w * b.y + a.x * b.z - a.y * b.w - a.z * b.x,
      a.w * b.z - a.x * b.y + a.y * b.x - a.z * b.w, a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z};
  const double scale = 1 / std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
  return {static_cast<float>(r.x * scale), static_cast<float>(r.y * scale),
          static_cast<float>(r.z * scale), static_cast<float>(r.w * scale)};
}

// A share of the way to the bind pose in 1/60 s as a spring [1/s2].
double goalSpring(double share) { return share * 3600 / std::max(1 - share, 1e-3); }

}  // namespace

uint32_t vertexCountOf(const HairAsset& asset, uint32_t strand) {
  return asset.vertexCounts.empty() ? asset.verticesPerStrand : asset.vertexCounts[strand];
}

ExactStrands packExactStrands(const HairAsset& asset) {
  ExactStrands packed;
  packed.strands.reserve(asset.strandCount);
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    packed.strands.push_back({.state = 0,
                              .count = vertexCountOf(asset, s),
                              .target = s * asset.verticesPerStrand,
                              .root = s});
  }
  std::stable_sort(packed.strands.begin(), packed.strands.end(),
                   [](const ExactStrand& a, const ExactStrand& b) { return a.count < b.count; });
  for (size_t from = 0; from < packed.strands.size(); from += kTileStrands) {
    const size_t to = std::min<size_t>(packed.strands.size(), from + kTileStrands);
    for (size_t s = from; s < to; ++s)
      packed.strands[s].state = packed.stateStride + static_cast<uint32_t>(s - from);
    packed.stateStride += kTileStrands * packed.strands[to - 1].count;
  }
  return packed;
}

std::vector<Float4> packExactState(const HairAsset& asset, const ExactStrands& strands) {
  const size_t stride = strands.stateStride;
  std::vector<Float4> state(kExactStateSets * stride);
  for (const ExactStrand& strand : strands.strands) {
    const float* lengths = &asset.restLengths[strand.target];
    const uint32_t edges = strand.count - 1;
    double total = 0;
    for (uint32_t i = 0; i < edges; ++i) total += static_cast<double>(lengths[i]);
    const double least = std::max(1e-3 * total / edges, 1e-7);
    for (uint32_t i = 0; i < strand.count; ++i) {
      const double before = i > 0 ? static_cast<double>(lengths[i - 1]) : 0;
      const double after = i < edges ? static_cast<double>(lengths[i]) : 0;
      const size_t at = strand.state + size_t{kTileStrands} * i;
      for (size_t slot = 0; slot < 3; ++slot) {
        state[slot * stride + at].w = static_cast<float>(after);
        state[(3 + slot) * stride + at].w =
            static_cast<float>(std::max(0.5 * (before + after), least));
        state[(6 + slot) * stride + at] = {0, 0, 0, 1};
      }
    }
  }
  return state;
}

std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands, bool goals) {
  const size_t stride = strands.stateStride;
  std::vector<Float4> rest((goals ? 2 : 1) * stride);
  for (const ExactStrand& strand : strands.strands) {
    const Quaternion* frames = &asset.restFrames[strand.target];
    const Float4* bind = &asset.positions[strand.target];
    const float* lengths = &asset.restLengths[strand.target];
    double total = 0, arc = 0;
    for (uint32_t i = 0; i + 1 < strand.count; ++i) total += static_cast<double>(lengths[i]);
    for (uint32_t i = 0; i < strand.count; ++i) {
      const size_t at = strand.state + size_t{kTileStrands} * i;
      const bool tip = i + 1 == strand.count;
      // Frame of the edge behind vertex i: restFrames holds that of the edge before it.
      if (tip) {
        rest[at] = {0, 0, 0, 1};
      } else {
        rest[at] = i == 0 ? relative({}, frames[1]) : relative(frames[i], frames[i + 1]);
      }
      if (goals) {
        const bool held = i > 1 && asset.inverseMasses[strand.target + i] <= 0;
        const auto share = static_cast<float>(total > 0 ? arc / total : 0);
        rest[stride + at] = {bind[i].x - bind[0].x, bind[i].y - bind[0].y, bind[i].z - bind[0].z,
                             held ? -1 : share};
      }
      if (!tip) arc += static_cast<double>(lengths[i]);
    }
  }
  return rest;
}

bool hasHeldVertices(const HairAsset& asset) {
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const size_t first = size_t{s} * asset.verticesPerStrand;
    for (uint32_t i = 2; i < vertexCountOf(asset, s); ++i)
      if (asset.inverseMasses[first + i] <= 0) return true;
  }
  return false;
}

void setExactStep(ExactConstants& constants, const SimulationSettings& s, double h, double hBefore,
                  Float3 wind) {
  // BDF2 of a varying step, or backward Euler: as the layout file says.
  const double ratio = hBefore > 0 ? h / hBefore : 0;
  double a2 = 0, he = h;
  if (ratio >= 0.4 && ratio <= 2.1) {
    a2 = -ratio * ratio / (1 + 2 * ratio);
    he = h * (1 + ratio) / (1 + 2 * ratio);
  }
  const double drag = -60 * std::log(1 - std::min(static_cast<double>(s.damping), 0.9999));
  const double weight = 1 / (he * he) + drag / he;
  const auto drift = [&](float gravity, float air) {
    return static_cast<float>((static_cast<double>(gravity) + drag * static_cast<double>(air)) /
                              weight);
  };
  constants.drift = {drift(s.gravity.x, wind.x), drift(s.gravity.y, wind.y),
                     drift(s.gravity.z, wind.z), 0};
  constants.historyShare = static_cast<float>(a2);
  constants.inverseStep = static_cast<float>(1 / he);
  constants.weight = static_cast<float>(weight);
  constants.velocityShare = static_cast<float>(1 / (he * weight));
  constants.turnRatio = static_cast<float>(ratio);
  constants.slowTurn = static_cast<float>(0.02 * std::min(1.0, (240 * h) * (240 * h)));
  const double bendLength = static_cast<double>(s.bendLength);
  const double bend = 9.81 * bendLength * bendLength * bendLength;
  constants.bendStiffness = static_cast<float>(bend);
  constants.twistStiffness = static_cast<float>(bend * static_cast<double>(s.twistRatio));
  constants.damping = static_cast<float>(static_cast<double>(s.relaxationTime) / h);
  constants.goalStiffness = static_cast<float>(goalSpring(static_cast<double>(s.globalStiffness)));
  constants.goalRange = std::max(s.globalRange, 1e-6f);
  constants.passTolerance = 0.04f;
  constants.vspCoefficient = s.vspCoefficient;
  constants.vspThreshold = s.vspThreshold;
}

}  // namespace pelage::detail
