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
inline constexpr uint64_t kExactStateSets = 9;
inline constexpr uint64_t kExactGainSets = 6;
/// Bytes that a pass moves for a vertex: 7 vectors of the state and the rest shape and 6 gains on
/// the way to the root; 5, 6 and 3 + 2 written on the way to the tip.
inline constexpr uint64_t kExactBytesAVertex = 29 * 16;

struct ExactStrands {
  std::vector<ExactStrand> strands;  ///< sorted by vertex count
  uint32_t stateStride = 0;          ///< elements of a set
};

/// Strands in tiles of 32, in the order in which the kernel's threads take them.
ExactStrands packExactStrands(const HairAsset& asset);
/// Initial contents of g_state.
std::vector<Float4> packExactState(const HairAsset& asset, const ExactStrands& strands);
/// What g_rest holds beside the rest shape.
struct ExactRestSets {
  bool goals = false;                           ///< set 1: bind positions for the global shape
  bool factors = false;                         ///< the last set
  std::span<const StrandFactors> strands = {};  ///< [strand], or empty for 1
  ParameterCurves curves = {};
  bool operator==(const ExactRestSets& other) const {
    return goals == other.goals && factors == other.factors && curves == other.curves;
  }
  uint32_t count() const { return 1u + (goals ? 1u : 0u) + (factors ? 1u : 0u); }
};

/// Contents of g_rest.
std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands,
                                  const ExactRestSets& sets);

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

/// A sub-step of h seconds after one of hBefore (0: without history).
void setExactStep(ExactConstants& constants, const SimulationSettings& settings, double h,
                  double hBefore, const AirMotion& air);

}  // namespace pelage::detail
