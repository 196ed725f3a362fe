// The kernels that light strands: pelage's, or the same ones with an engine's lights.
#pragma once

#include "pelage/engine_lights.h"
#include "pelage/kernel.h"
#include "pelage/result.h"

namespace pelage::detail {

/// Whether the engine has all kernels that a transparency method may draw with. Error: the one that
/// it lacks. \param lights may be nullptr.
Result<void> checkLights(const EngineLights* lights);
/// The engine's variant of one of pelage's, or `own` where there is none. \param lights that
/// checkLights() took, or nullptr.
const KernelVariant& litVariant(const EngineLights* lights, const KernelVariant& own);
/// Whether they read the UV of roots: pelage_add_engine_lights() with ROOT_UV.
bool readsRootUv(const EngineLights* lights);
/// `lights` for a draw or dispatch with their variant of a kernel; nullptr with one of pelage's.
const EngineLights* lightsOf(const EngineLights* lights, const KernelVariant& variant);

}  // namespace pelage::detail
