// Host side of the exact solver: how its buffers are filled, and its constants. The layout is that
// of kernels/layouts/exact.hlsli.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
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
/// Contents of g_rest, with the second set for the global shape or without it.
std::vector<Float4> packExactRest(const HairAsset& asset, const ExactStrands& strands, bool goals);

/// True when a vertex beyond the two at the root is held where the bind pose has it.
bool hasHeldVertices(const HairAsset& asset);

/// Vertices of a strand.
uint32_t vertexCountOf(const HairAsset& asset, uint32_t strand);

/// A sub-step of h seconds after one of hBefore (0: without history).
/// \param wind velocity of the air, gusts included [m/s]
void setExactStep(ExactConstants& constants, const SimulationSettings& settings, double h,
                  double hBefore, Float3 wind);

}  // namespace pelage::detail
