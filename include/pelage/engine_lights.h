// Lights of an engine in place of pelage's, in every transparency method: docs/shading.md.
#pragma once

#include <span>
#include <vector>

#include "pelage/kernel.h"
#include "pelage/pass_list.h"

namespace pelage {

/// An engine's own lights: its function engineLight() compiled into the kernels that light strands,
/// and what that function reads. A view draws with them through TransparencySettings::engineLights:
///
///     EngineLights lights{.kernels = my_lights::allKernels()};  // pelage_add_engine_lights()
///     lights.resources.push_back(NamedResource::constants("MyLights", block));
///     lights.resources.push_back({.name = "g_cascades", .texture = cascades});
///     auto drawn = frame->draw(view, {}, {.engineLights = &lights});
///
/// The runtime needs their code: addCode(my_lights::allSpirv()), or allGlsl(), allEssl(),
/// allCode().
///
/// Threads: as a standard container.
struct EngineLights {
  /// All that pelage_add_engine_lights() has made, of the same version of pelage. Static tables:
  /// they outlive the lists that name them.
  std::span<const Kernel* const> kernels = {};
  /// Resources of the engine's kernels, by the names in HLSL; a kernel need not use all of them.
  /// They are copied into the lists, where the buffers get barriers as all others do. The engine
  /// makes its textures ready before the lists run.
  std::vector<NamedResource> resources = {};
};

}  // namespace pelage
