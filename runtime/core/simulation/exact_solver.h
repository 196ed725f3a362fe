// Host side of the exact solver: how its buffers are filled, and its constants. The layout is that
// of kernels/layouts/exact.hlsli.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "pelage/simulation_settings.h"

namespace pelage::detail {

/// Strands a tile.
inline constexpr uint32_t kTileStrands = 32;
/// Sets of float4 that g_state and g_gains have.
inline constexpr uint64_t kExactStateSets = 8;
inline constexpr uint64_t kExactGainSets = 6;
/// Elements of g_state behind its sets: four states of 5 a strand.
inline constexpr uint64_t kExactStrandElements = 4 * 5;
/// Bytes that a pass moves for a vertex: 5 vectors of the state, the rest shape and 6 gains on the
/// way to the root; 1, 6 and 2 + 2 written on the way to the tip.
inline constexpr uint64_t kExactBytesAVertex = 23 * 16;

struct ExactStrands {
  std::vector<ExactStrand> strands;  ///< sorted by vertex count
  uint32_t stateStride = 0;          ///< elements of a set
};

/// Strands in tiles of 32, in the order in which the kernel's threads take them: by vertex count,
/// then as in the asset, or, for level of detail, at random, so that every beginning covers the
/// scalp.
ExactStrands packExactStrands(const HairAsset& asset, bool levelOfDetail);
/// For every strand but the first one, one before it and near it.
std::vector<uint32_t> nearStrandsBefore(const HairAsset& asset, const ExactStrands& strands);
/// Elements of g_state, which starts as zeros.
inline uint64_t exactStateCount(uint64_t stateStride, uint64_t strands) {
  return kExactStateSets * stateStride + kExactStrandElements * strands;
}
/// What g_rest holds beside the rest shape.
struct RestSets {
  bool goals = false;                           ///< set 1: bind positions for the global shape
  bool factors = false;                         ///< the last set
  std::span<const StrandFactors> strands = {};  ///< [strand], or empty for 1
  ParameterCurves curves = {};
  bool operator==(const RestSets& other) const {
    return goals == other.goals && factors == other.factors && curves == other.curves;
  }
  uint32_t count() const { return 1u + (goals ? 1u : 0u) + (factors ? 1u : 0u); }
};

/// Factors at a share of a strand's arc length: on stiffness, global stiffness and damping.
Float4 vertexFactors(const RestSets& sets, uint32_t strand, double share);
/// The third set of the classic solver's g_rest.
std::vector<Float4> packClassicFactors(const HairAsset& asset, const RestSets& sets);

/// Contents of g_rest.
std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands,
                                  const RestSets& sets);

/// The wind at a time [m/s].
struct AirMotion {
  Float3 velocity;  ///< gusts included
  Float3 gust0;     ///< the part of it that is the gusts'
  Float3 gust1;     ///< the same a quarter of their period later
};
AirMotion airAt(const WindSettings& wind, double time);

/// True when a vertex beyond the two at the root is held where the bind pose has it.
bool hasHeldVertices(const HairAsset& asset);

/// Vertices of a strand.
uint32_t vertexCountOf(const HairAsset& asset, uint32_t strand);

/// What a sub-step has to know of those before it; zeros without any.
struct ExactHistory {
  double step = 0;         ///< length of the last one [s]
  double share = 0;        ///< its a2
  double rate = 0;         ///< its 1 / he [1/s]
  double shareBefore = 0;  ///< of the one before it
  double rateBefore = 0;
};

/// A sub-step of h seconds, which becomes the last one of the history.
void setExactStep(ExactConstants& constants, const SimulationSettings& settings, double h,
                  ExactHistory& history, const AirMotion& air);

}  // namespace pelage::detail
