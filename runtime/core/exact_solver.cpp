#include "exact_solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

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

float lengthOf(const HairAsset& asset, uint32_t strand) {
  float length = 0;
  for (uint32_t i = 0; i + 1 < asset.verticesPerStrand; ++i)
    length += asset.restLengths[size_t{strand} * asset.verticesPerStrand + i];
  return length;
}

// From the root's place, so that it does not depend on the order of the strands (FNV-1a).
uint32_t seedOf(const Float4& root) {
  uint32_t hash = 2166136261u;
  for (const float value : {root.x, root.y, root.z}) {
    const auto bits = std::bit_cast<uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8)
      hash = (hash ^ ((bits >> shift) & 255u)) * 16777619u;
  }
  return hash;
}

// Gusts: two incommensurate waves, so that the pattern does not repeat soon; in -1..1.
double gust(double phase) { return 0.6 * std::sin(phase) + 0.4 * std::sin(2.618 * phase + 1.3); }

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
                              .root = s,
                              .seed = seedOf(asset.positions[size_t{s} * asset.verticesPerStrand]),
                              .length = lengthOf(asset, s)});
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

std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands,
                                  const ExactRestSets& sets) {
  const size_t stride = strands.stateStride;
  std::vector<Float4> rest(sets.count() * stride);
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
      const double share = total > 0 ? arc / total : 0;
      if (sets.goals) {
        const bool held = i > 1 && asset.inverseMasses[strand.target + i] <= 0;
        rest[stride + at] = {bind[i].x - bind[0].x, bind[i].y - bind[0].y, bind[i].z - bind[0].z,
                             held ? -1 : static_cast<float>(share)};
      }
      if (sets.factors) {
        const StrandFactors own =
            sets.strands.empty() ? StrandFactors{} : sets.strands[strand.root];
        const auto factor = [&](const ParameterCurve& curve, float strandFactor) {
          return strandFactor * valueAt(curve, static_cast<float>(share));
        };
        rest[(sets.count() - 1) * stride + at] = {
            factor(sets.curves.stiffness, own.stiffness),
            factor(sets.curves.globalStiffness, own.globalStiffness),
            factor(sets.curves.damping, own.damping), 0};
      }
      if (!tip) arc += static_cast<double>(lengths[i]);
    }
  }
  return rest;
}

AirMotion airAt(const WindSettings& wind, double time) {
  const double phase = 2 * std::numbers::pi * time / static_cast<double>(wind.gustPeriod);
  const auto scaled = [&](double factor) {
    const auto of = [&](float v) { return static_cast<float>(static_cast<double>(v) * factor); };
    return Float3{of(wind.velocity.x), of(wind.velocity.y), of(wind.velocity.z)};
  };
  const double strength = static_cast<double>(wind.gustStrength);
  return {.velocity = scaled(1 + strength * gust(phase)),
          .gust0 = scaled(strength * gust(phase)),
          .gust1 = scaled(strength * gust(phase + std::numbers::pi / 2))};
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
                  const AirMotion& air) {
  // BDF2 of a varying step, or backward Euler: as the layout file says.
  const double ratio = hBefore > 0 ? h / hBefore : 0;
  double a2 = 0, he = h;
  if (ratio >= 0.4 && ratio <= 2.1) {
    a2 = -ratio * ratio / (1 + 2 * ratio);
    he = h * (1 + ratio) / (1 + 2 * ratio);
  }
  const double drag = -60 * std::log(1 - std::min(static_cast<double>(s.damping), 0.9999));
  const double weight = 1 / (he * he) + drag / he;
  const auto way = [&](float gravity, float wind) {
    return static_cast<float>((static_cast<double>(gravity) + drag * static_cast<double>(wind)) /
                              weight);
  };
  const Float3 wind = air.velocity;
  constants.drift = {way(s.gravity.x, wind.x), way(s.gravity.y, wind.y), way(s.gravity.z, wind.z),
                     0};
  const bool blows = wind.x != 0 || wind.y != 0 || wind.z != 0;
  constants.gust0 = {way(0, air.gust0.x), way(0, air.gust0.y), way(0, air.gust0.z),
                     blows ? s.wind.strandVariation : 0};
  constants.gust1 = {way(0, air.gust1.x), way(0, air.gust1.y), way(0, air.gust1.z), 0};
  constants.air = {wind.x, wind.y, wind.z, static_cast<float>(drag)};
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
