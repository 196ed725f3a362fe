// Host side of the exact solver: how its buffers are filled, and its constants.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assets/groom.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/simulation_settings.h"
#include "simulation/sag_balance.h"
#include "skinning/hair_frame.h"

namespace pelage {

/// A strand of the exact solver; strandAt() in kernels/simulation/exact/exact_state.hlsli reads it
/// from g_rest, where it is two elements. kernels/simulation/layouts/exact.hlsli has the members.
struct ExactStrand {
  uint32_t state = 0, count = 0, target = 0, root = 0;
  uint32_t seed = 0;
  float strandLength = 0;
  uint32_t pad0 = 0, pad1 = 0;
};
static_assert(sizeof(ExactStrand) == 2 * sizeof(Float4));

}  // namespace pelage

namespace pelage::detail {

/// Bytes that a pass moves for a vertex: 5 vectors of the state, the rest shape and 6 gains on the
/// way to the root; 1, 6 and 2 + 2 written on the way to the tip.
inline constexpr uint64_t kExactBytesAVertex = 23 * 16;

struct ExactStrands {
  std::vector<ExactStrand> strands;  ///< sorted by vertex count
  uint32_t stateStride = 0;          ///< elements of a set
};

/// Strands in tiles of 32, in the order of the kernel's threads: by vertex count, then as in the
/// asset, or, for level of detail, at random, so that every prefix covers the scalp.
ExactStrands packExactStrands(const HairAsset& asset, bool levelOfDetail);
/// Strands of an object in the order of its first rest pose, with the lengths of the current one.
ExactStrands exactStrandsOf(const Groom& groom, const RestPose& rest);
/// For every strand except the first one: an earlier strand near it.
std::vector<uint32_t> nearStrandsBefore(const HairAsset& asset, const ExactStrands& strands);
/// Number of elements of g_state, which starts as zeros.
inline uint64_t exactStateCount(uint64_t stateStride, uint64_t strands) {
  return uint64_t{exact::kStateSets} * stateStride +
         uint64_t{exact::kStateSlots} * exact::kStrandElements * strands +
         uint64_t{exact::kGainSets} * stateStride;
}
/// The optional contents of g_rest.
struct RestSets {
  bool targets = false;                         ///< set 1: bind positions for the global shape
  bool factors = false;                         ///< the last set
  std::span<const StrandFactors> strands = {};  ///< [strand], or empty for 1
  ParameterCurves curves = {};
  /// The load that the rest shape balances; if it acts, a set has the joints of the bind pose.
  SagLoad sag = {};
  bool operator==(const RestSets& other) const {
    return targets == other.targets && factors == other.factors && curves == other.curves &&
           sag == other.sag;
  }
  /// The set with the joints of the bind pose; 0: they are those at rest.
  uint32_t bindSet() const { return sag.acts() ? 1u + (targets ? 1u : 0u) : 0; }
  uint32_t count() const {
    return 1u + (targets ? 1u : 0u) + (sag.acts() ? 1u : 0u) + (factors ? 1u : 0u);
  }
};

/// Factors at a fraction of a strand's arc length: on stiffness, global stiffness and damping.
Float4 vertexFactors(const RestSets& sets, uint32_t strand, double share);
/// The third set of the classic solver's g_rest.
std::vector<Float4> packClassicFactors(const HairAsset& asset, const RestSets& sets);

/// Contents of g_rest: the sets, then the strands.
/// \param limp  receives the number of strands that cannot balance the load
std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands,
                                  const RestSets& sets, uint32_t* limp = nullptr);

/// The load that rest shapes balance: SimulationSettings::sagCompensation of the gravity that acts.
SagLoad sagLoadOf(const SimulationSettings& settings);

/// The wind at a time, in seconds.
/// \param loadShare  of the wind that acts on hair
AirMotion airAt(const WindSettings& wind, double time, float loadShare = 1);
/// Share of gravity, wind and forces that acts on hair: 1 up to a VSP coefficient of 0.75, from
/// there linearly to 0 at 1.
float loadShareOf(const SimulationSettings& settings);

/// The data of earlier sub-steps that a sub-step needs; zeros if there are none.
struct ExactHistory {
  double step = 0;         ///< length of the last one [s]
  double share = 0;        ///< its a2
  double rate = 0;         ///< its 1 / he [1/s]
  double shareBefore = 0;  ///< of the one before it
  double rateBefore = 0;
};

/// Computes a sub-step of h seconds, which becomes the last one of the history.
/// \param loadShare  of gravity and forces that acts; `air` has it already
void setExactStep(ExactConstants& constants, const SimulationSettings& settings, double h,
                  ExactHistory& history, const AirMotion& air, float loadShare = 1);

}  // namespace pelage::detail
