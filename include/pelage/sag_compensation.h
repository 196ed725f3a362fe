// Whether strands are stiff enough to hang in the shape that they were groomed in.
#pragma once

#include <span>
#include <vector>

#include "pelage/export.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"

namespace pelage {

/// Returns for each guide the largest SimulationSettings::sagCompensation that its rest shape can
/// balance, 0..1, to 1/4096. A guide with 1 hangs in its bind shape at 1. One below is too limp: no
/// rest shape holds it there, because it would fall to one side when it is touched, as a long
/// strand that stands on its root does. Whatever the setting is, it takes at most this share; raise
/// bendLength, or groom it as it hangs.
/// \param asset     as process() left it
/// \param settings  sagCompensation and the solver do not matter: the answer is for the exact one
/// \param factors   HairDef::strandFactors; empty: all are 1
/// Errors: an asset without rest data, settings that validate() refuses, another number of factors.
/// Cost on the host: 0.5 us a vertex, and up to 15 times that for a guide that is too limp.
PELAGE_API Result<std::vector<float>> reachableSagCompensation(
    const HairAsset& asset, const SimulationSettings& settings,
    std::span<const StrandFactors> factors = {});

}  // namespace pelage
