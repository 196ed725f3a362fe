#include "simulation/exact_solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>

#include "pelage/sag_compensation.h"

namespace pelage::detail {

static_assert(kMaxVerticesPerStrand == strand_indexing::kMaxVertices);
namespace {

using Rotation = UnitQuaternion<double>;

Rotation rotationOf(const Quaternion& q) {
  return {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z),
          static_cast<double>(q.w)};
}

// conj(a) b, normalized.
Rotation relative(const Quaternion& from, const Quaternion& to) {
  const Rotation a = rotationOf(from), b = rotationOf(to);
  Rotation r = {
      a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y, a.w * b.y + a.x * b.z - a.y * b.w - a.z * b.x,
      a.w * b.z - a.x * b.y + a.y * b.x - a.z * b.w, a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z};
  const double scale = 1 / std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
  return {r.x * scale, r.y * scale, r.z * scale, r.w * scale};
}

Float4 packed(const Rotation& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
          static_cast<float>(q.w)};
}

// The two numbers of a joint at rest: see g_rest.
Float4 jointOf(const Rotation& q, float edgeLength, float voronoiLength) {
  const double scale = (q.w < 0 ? -1 : 1) / (1 + std::abs(q.w));
  return {static_cast<float>(q.y * scale), static_cast<float>(q.z * scale), edgeLength,
          voronoiLength};
}

// Length whose bending is in the joint at vertex 1: edge 0, which follows the root, and half of
// edge 1. It is longer than their sum, because moment and lever grow towards the clamp: a straight
// strand of length T under its own weight bends by (T - s)^2, which moves its tip by (T - s)^3. The
// value is the integral of that from 0 to b = first + second / 2, over its value at vertex 1; at
// most three times b, for strands that almost end there. (b alone is also of second order, with
// twice the error; the usual (first + second) / 2 is of first order.)
double rootVoronoiLength(double first, double second, double total) {
  const double end = first + 0.5 * second, left = total - first;
  const double whole = std::pow(total, 4) - std::pow(total - end, 4), at = 4 * std::pow(left, 3);
  return whole < 3 * end * at ? whole / at : 3 * end;
}

// Voronoi lengths of the vertices of a strand [m].
// \param lengths  of the edges behind the vertices; that of the tip does not count
void setVoronoiLengths(std::span<const float> lengths, std::vector<double>& to) {
  const size_t count = lengths.size();
  double total = 0;
  for (size_t i = 0; i + 1 < count; ++i) total += static_cast<double>(lengths[i]);
  const double least = std::max(1e-3 * total / static_cast<double>(count - 1), 1e-7);
  to.clear();
  for (size_t i = 0; i < count; ++i) {
    const bool tip = i + 1 == count;
    const double before = i > 0 ? static_cast<double>(lengths[i - 1]) : 0;
    const double after = tip ? 0 : static_cast<double>(lengths[i]);
    const double stands =
        i == 1 && !tip ? rootVoronoiLength(before, after, total) : 0.5 * (before + after);
    to.push_back(std::max(stands, least));
  }
}

float lengthOf(const HairAsset& asset, uint32_t strand) {
  float length = 0;
  for (uint32_t i = 0; i + 1 < asset.verticesPerStrand; ++i)
    length += asset.restLengths[size_t{strand} * asset.verticesPerStrand + i];
  return length;
}

// From the root's position, so that it does not depend on the order of the strands (FNV-1a).
uint32_t seedOf(const Float4& root) {
  uint32_t hash = 2166136261u;
  for (const float value : {root.x, root.y, root.z}) {
    const auto bits = std::bit_cast<uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8)
      hash = (hash ^ ((bits >> shift) & 255u)) * 16777619u;
  }
  return hash;
}

// The finalizer of MurmurHash3 (A. Appleby, public domain): neighboring numbers get far apart.
uint32_t mixed(uint32_t value) {
  value = (value ^ (value >> 16)) * 0x85ebca6bu;
  value = (value ^ (value >> 13)) * 0xc2b2ae35u;
  return value ^ (value >> 16);
}

// Gusts: two incommensurate waves, so that the pattern does not repeat soon; in -1..1.
double gust(double phase) { return 0.6 * std::sin(phase) + 0.4 * std::sin(2.618 * phase + 1.3); }

// The bending stiffness over the mass a length [m4/s2].
double bendOf(const SimulationSettings& s) {
  const auto bendLength = static_cast<double>(s.bendLength);
  return 9.81 * bendLength * bendLength * bendLength;
}

// Converts a fraction of the displacement to the bind pose in 1/60 s to a spring [1/s2].
double targetSpring(double share) { return share * 3600 / std::max(1 - share, 1e-3); }

// Maximum rotation of a first Newton pass without a second one [rad]. Without air, whipping strands
// gain energy above 0.04. With air, the drag of a step removes more than a larger rotation adds,
// and a second pass does not improve the motion (docs/decisions/0005-second-pass.md). Strands that
// twist far more easily than they bend tremble permanently by the remaining error of a first pass:
// 0.1 m/s at a twistRatio of 0.1 to 0.3.
double passTolerance(double h, double drag, double twistRatio) {
  if (twistRatio < 0.4) return 2e-4;
  const double c = std::min(drag, 3.0) * std::min(60 * h, 1.0);
  return 0.04 + 0.2 * c * c;
}

// See ExactConstants.
double slowRotation(double h, double drag) {
  const double share = std::min(240 * h, 1.0), slow = drag * std::pow(std::min(60 * h, 1.0), 2);
  return 0.02 * share * share + slow * slow;
}

}  // namespace

ExactStrands packExactStrands(const HairAsset& asset, bool levelOfDetail) {
  ExactStrands packed;
  packed.strands.reserve(asset.strandCount);
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    packed.strands.push_back({.state = 0,
                              .count = vertexCountOf(asset, s),
                              .target = s * asset.verticesPerStrand,
                              .root = s,
                              .seed = seedOf(asset.positions[size_t{s} * asset.verticesPerStrand]),
                              .strandLength = lengthOf(asset, s)});
  }
  std::stable_sort(packed.strands.begin(), packed.strands.end(),
                   [&](const ExactStrand& a, const ExactStrand& b) {
                     // Every prefix must cover the scalp, whatever the counts are.
                     return levelOfDetail ? mixed(a.seed) < mixed(b.seed) : a.count < b.count;
                   });
  for (size_t from = 0; from < packed.strands.size(); from += exact::kTileStrands) {
    const size_t to = std::min<size_t>(packed.strands.size(), from + exact::kTileStrands);
    for (size_t s = from; s < to; ++s)
      packed.strands[s].state = packed.stateStride + static_cast<uint32_t>(s - from);
    uint32_t longest = 0;
    for (size_t s = from; s < to; ++s) longest = std::max(longest, packed.strands[s].count);
    packed.stateStride += exact::kTileStrands * longest;
  }
  return packed;
}

ExactStrands exactStrandsOf(const Groom& groom, const RestPose& rest) {
  ExactStrands packed = packExactStrands(*groom.firstAsset, groom.levelOfDetail);
  if (rest.asset == groom.firstAsset) return packed;
  for (ExactStrand& strand : packed.strands)
    strand.strandLength = lengthOf(*rest.asset, strand.root);
  return packed;
}

Float4 vertexFactors(const RestSets& sets, uint32_t strand, double share) {
  const StrandFactors own = sets.strands.empty() ? StrandFactors{} : sets.strands[strand];
  const auto factor = [&](const ParameterCurve& curve, float strandFactor) {
    return strandFactor * valueAt(curve, static_cast<float>(share));
  };
  return {factor(sets.curves.stiffness, own.stiffness),
          factor(sets.curves.globalStiffness, own.globalStiffness),
          factor(sets.curves.damping, own.damping), 0};
}

std::vector<Float4> packClassicFactors(const HairAsset& asset, const RestSets& sets) {
  const size_t strands = asset.strandCount, count = asset.verticesPerStrand;
  std::vector<Float4> factors(strands * count);
  for (size_t s = 0; s < strands; ++s) {
    const double total = static_cast<double>(lengthOf(asset, static_cast<uint32_t>(s)));
    double arc = 0;
    for (size_t i = 0; i < count; ++i) {
      factors[i * strands + s] =
          vertexFactors(sets, static_cast<uint32_t>(s), total > 0 ? arc / total : 0);
      if (i + 1 < count) arc += static_cast<double>(asset.restLengths[s * count + i]);
    }
  }
  return factors;
}

namespace {

// A strand in its bind pose, and the joints that balance it; its memory serves many strands.
class BoundStrand {
 public:
  std::vector<SagJoint> joints;

  // Returns the fraction of the load that joints can balance.
  double balance(const HairAsset& asset, uint32_t strand, uint32_t count, const RestSets& sets) {
    const size_t first = size_t{strand} * asset.verticesPerStrand;
    const std::span<const float> own(&asset.restLengths[first], count);
    setVoronoiLengths(own, voronoiLengths_);
    tangents_.clear();
    lengths_.clear();
    stiffness_.clear();
    springs_.clear();
    double total = 0, arc = 0;
    for (uint32_t i = 0; i + 1 < count; ++i) total += static_cast<double>(own[i]);
    bool held = false;
    for (uint32_t i = 0; i < count; ++i) {
      const double share = total > 0 ? arc / total : 0;
      const Float4 factors = sets.factors ? vertexFactors(sets, strand, share) : Float4{1, 1, 1, 0};
      const bool isHeld = i > 1 && asset.inverseMasses[first + i] <= 0;
      held = held || isHeld;
      stiffness_.push_back(std::max(static_cast<double>(factors.x), 1e-6));
      springs_.push_back(isHeld ? kHeldSpring
                                : springOf(sets.sag, share, static_cast<double>(factors.y)));
      if (i + 1 == count) break;
      const auto length = static_cast<double>(own[i]);
      lengths_.push_back(length);
      tangents_.push_back(axisX(relative({}, asset.restFrames[first + i + 1])));
      arc += length;
    }
    if (!held && !(sets.sag.targetSpring > 0)) springs_.clear();
    joints.resize(count - 1);
    return balanceSag({.rootFrame = relative({}, asset.restFrames[first + 1]),
                       .tangents = tangents_,
                       .lengths = lengths_,
                       .voronoiLengths = voronoiLengths_,
                       .stiffness = stiffness_,
                       .springs = springs_},
                      sets.sag, joints);
  }

 private:
  // As stiff as the solver's: kHoldStiffness in kernels/simulation/exact.
  static constexpr double kHeldSpring = 1e6;

  static double springOf(const SagLoad& load, double share, double factor) {
    if (!(load.targetSpring > 0)) return 0;
    const double fade = 0.25 * load.targetRange;
    return load.targetSpring * factor *
           std::clamp((load.targetRange + fade - share) / fade, 0.0, 1.0);
  }

  std::vector<Vector3<double>> tangents_;
  std::vector<double> lengths_, voronoiLengths_, stiffness_, springs_;
};

}  // namespace

std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands,
                                  const RestSets& sets, uint32_t* limp) {
  const size_t stride = strands.stateStride, bindSet = sets.bindSet();
  std::vector<Float4> rest(sets.count() * stride);
  std::vector<double> voronoiLengths;
  BoundStrand bound;
  uint32_t limpStrands = 0;
  for (const ExactStrand& strand : strands.strands) {
    const Quaternion* frames = &asset.restFrames[strand.target];
    const Float4* bind = &asset.positions[strand.target];
    const float* lengths = &asset.restLengths[strand.target];
    double total = 0, arc = 0;
    for (uint32_t i = 0; i + 1 < strand.count; ++i) total += static_cast<double>(lengths[i]);
    setVoronoiLengths({lengths, strand.count}, voronoiLengths);
    if (bindSet > 0 && bound.balance(asset, strand.root, strand.count, sets) < 1) ++limpStrands;
    for (uint32_t i = 0; i < strand.count; ++i) {
      const size_t at = strand.state + size_t{exact::kTileStrands} * i;
      const bool tip = i + 1 == strand.count;
      const auto voronoiLength = static_cast<float>(voronoiLengths[i]);
      // Frame of the edge after vertex i: restFrames has that of the edge before it.
      if (i == 0) {
        const Rotation frame = relative({}, frames[1]);
        rest[at] = packed(frame);
      } else if (tip) {
        rest[at] = {lengths[0], 0, 0, voronoiLength};
      } else if (bindSet > 0) {
        rest[at] = jointOf(bound.joints[i].rest, lengths[i], voronoiLength);
        rest[bindSet * stride + at] = packed(bound.joints[i].bind);
      } else {
        rest[at] = jointOf(relative(frames[i], frames[i + 1]), lengths[i], voronoiLength);
      }
      const double share = total > 0 ? arc / total : 0;
      if (sets.targets) {
        const bool held = i > 1 && asset.inverseMasses[strand.target + i] <= 0;
        rest[stride + at] = {bind[i].x - bind[0].x, bind[i].y - bind[0].y, bind[i].z - bind[0].z,
                             held ? -1 : static_cast<float>(share)};
      }
      if (sets.factors) {
        rest[(sets.count() - 1) * stride + at] = vertexFactors(sets, strand.root, share);
      }
      if (!tip) arc += static_cast<double>(lengths[i]);
    }
  }
  if (limp != nullptr) *limp = limpStrands;
  const size_t records = rest.size();
  rest.resize(records + 2 * strands.strands.size());
  std::memcpy(static_cast<void*>(rest.data() + records), strands.strands.data(),
              strands.strands.size() * sizeof(ExactStrand));
  return rest;
}

std::vector<uint32_t> nearStrandsBefore(const HairAsset& asset, const ExactStrands& strands) {
  // More candidates would be nearer, and take minutes for a hundred thousand strands.
  constexpr size_t kMostCandidates = 2048;
  std::vector<uint32_t> parents(strands.strands.size(), 0);
  for (size_t slot = 1; slot < parents.size(); ++slot) {
    // From the first half, so that the path to an ancestor is short.
    const size_t candidates = std::min((slot + 1) / 2, kMostCandidates);
    const Float4& p = asset.positions[strands.strands[slot].target];
    float least = std::numeric_limits<float>::max();
    for (size_t c = 0; c < candidates; ++c) {
      const Float4& q = asset.positions[strands.strands[c].target];
      const float dx = p.x - q.x, dy = p.y - q.y, dz = p.z - q.z;
      const float squared = dx * dx + dy * dy + dz * dz;
      if (squared < least) {
        least = squared;
        parents[slot] = static_cast<uint32_t>(c);
      }
    }
  }
  return parents;
}

float loadShareOf(const SimulationSettings& settings) {
  return std::min(1.0f, 4 * (1 - settings.vspCoefficient));
}

SagLoad sagLoadOf(const SimulationSettings& s) {
  const double share = static_cast<double>(s.sagCompensation) * static_cast<double>(loadShareOf(s));
  const Vector3<double> acceleration = toVector(s.gravity) * share;
  if (s.solver != Solver::kExact || !(dot(acceleration, acceleration) > 0)) return {};
  const double bend = bendOf(s);
  SagLoad load = {.acceleration = acceleration,
                  .bend = bend,
                  .twist = bend * static_cast<double>(s.twistRatio)};
  if (s.globalStiffness > 0 && s.globalRange > 0) {
    load.targetSpring = targetSpring(static_cast<double>(s.globalStiffness));
    load.targetRange = static_cast<double>(s.globalRange);
  }
  return load;
}

AirMotion airAt(const WindSettings& wind, double time, float loadShare) {
  const double phase = 2 * std::numbers::pi * time / static_cast<double>(wind.gustPeriod);
  const auto scaled = [&](double factor) {
    const auto of = [&](float v) { return static_cast<float>(static_cast<double>(v) * factor); };
    return Float3{of(wind.velocity.x), of(wind.velocity.y), of(wind.velocity.z)};
  };
  const double strength = static_cast<double>(wind.gustStrength);
  const double share = static_cast<double>(loadShare);
  return {.velocity = scaled((1 + strength * gust(phase)) * share),
          .gust0 = scaled(strength * gust(phase) * share),
          .gust1 = scaled(strength * gust(phase + std::numbers::pi / 2) * share)};
}

void setExactStep(ExactConstants& constants, const SimulationSettings& s, double h,
                  ExactHistory& history, const AirMotion& air, float loadShare) {
  // BDF2 of a varying step, or backward Euler: as the layout file says.
  const double ratio = history.step > 0 ? h / history.step : 0;
  double a2 = 0, he = h;
  if (ratio >= 0.4 && ratio <= 2.1) {
    a2 = -ratio * ratio / (1 + 2 * ratio);
    he = h * (1 + ratio) / (1 + 2 * ratio);
  }
  const double drag = -60 * std::log(1 - std::min(static_cast<double>(s.damping), 0.9999));
  const double weight = 1 / (he * he) + drag / he;
  const auto displacement = [&](float gravity, float wind) {
    return static_cast<float>((static_cast<double>(gravity) + drag * static_cast<double>(wind)) /
                              weight);
  };
  const Float3 wind = air.velocity;
  // Gravity that the rest shape balances does not fade: without it hair would rise.
  const float gravityShare = loadShare + s.sagCompensation * (loadShareOf(s) - loadShare);
  constants.drift = {displacement(s.gravity.x * gravityShare, wind.x),
                     displacement(s.gravity.y * gravityShare, wind.y),
                     displacement(s.gravity.z * gravityShare, wind.z), 1 - loadShare};
  const bool blows = wind.x != 0 || wind.y != 0 || wind.z != 0;
  constants.gust0 = {displacement(0, air.gust0.x), displacement(0, air.gust0.y),
                     displacement(0, air.gust0.z), blows ? s.wind.strandVariation : 0};
  constants.gust1 = {displacement(0, air.gust1.x), displacement(0, air.gust1.y),
                     displacement(0, air.gust1.z), 0};
  constants.air = {wind.x, wind.y, wind.z, static_cast<float>(drag)};
  constants.historyShare = static_cast<float>(a2);
  constants.inverseStep = static_cast<float>(1 / he);
  constants.weight = static_cast<float>(weight);
  const double share = 1 / (he * weight);
  constants.displacementShare = static_cast<float>(share * (1 - a2) * history.rate - a2);
  constants.displacementShareBefore = static_cast<float>(
      share * ((1 - a2) * history.share * history.rate + a2 * history.rateBefore));
  constants.displacementShareEarlier =
      static_cast<float>(share * a2 * history.shareBefore * history.rateBefore);
  history = {.step = h,
             .share = a2,
             .rate = 1 / he,
             .shareBefore = history.share,
             .rateBefore = history.rate};
  constants.rotationRatio = static_cast<float>(ratio);
  constants.slowRotation = static_cast<float>(slowRotation(h, drag));
  constants.twistInertia = static_cast<float>(0.005 * std::min(60 * h, 1.0));
  constants.guessTrend = static_cast<float>(0.5 * std::min(drag, 1.0));
  const double bend = bendOf(s);
  constants.bendStiffness = static_cast<float>(bend);
  constants.twistStiffness = static_cast<float>(bend * static_cast<double>(s.twistRatio));
  constants.damping = static_cast<float>(static_cast<double>(s.relaxationTime) / h);
  constants.targetStiffness =
      static_cast<float>(targetSpring(static_cast<double>(s.globalStiffness)));
  constants.targetRange = std::max(s.globalRange, 1e-6f);
  constants.passTolerance =
      static_cast<float>(passTolerance(h, drag, static_cast<double>(s.twistRatio)));
  constants.vspCoefficient = s.vspCoefficient;
  constants.vspThreshold = s.vspThreshold;
}

}  // namespace pelage::detail

namespace pelage {

Result<std::vector<float>> reachableSagCompensation(const HairAsset& asset,
                                                    const SimulationSettings& settings,
                                                    std::span<const StrandFactors> factors) {
  if (Result<void> checked = validate(asset); !checked) return checked.error();
  if (Result<void> checked = detail::checkRestData(asset); !checked) return checked.error();
  if (Result<void> checked = validate(settings); !checked) return checked.error();
  if (!factors.empty() && factors.size() != asset.strandCount) {
    return Error{ErrorCode::kInvalidArgument, "reachableSagCompensation() got " +
                                                  std::to_string(factors.size()) + " factors for " +
                                                  std::to_string(asset.strandCount) + " guides"};
  }
  SimulationSettings whole = settings;
  whole.solver = Solver::kExact;
  whole.sagCompensation = 1;
  const detail::RestSets sets = {.factors = true,
                                 .strands = factors,
                                 .curves = settings.curves,
                                 .sag = detail::sagLoadOf(whole)};
  std::vector<float> shares(asset.strandCount, 1);
  if (!sets.sag.acts()) return shares;
  detail::BoundStrand bound;
  for (uint32_t s = 0; s < asset.strandCount; ++s)
    shares[s] = static_cast<float>(bound.balance(asset, s, detail::vertexCountOf(asset, s), sets));
  return shares;
}

}  // namespace pelage
