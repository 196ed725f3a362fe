// SDFs of an engine's own: a grid of distances in a buffer, which a pass converts to keys.
#pragma once

#include <cstdint>
#include <string>

#include "base/bounds.h"
#include "base/local_origin.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"

namespace pelage::detail {

/// Describes the error in an SDF; empty if there is none.
std::string faultOf(const DenseSdf& sdf, const ResourceTable& resources);
uint64_t nodeCountOf(const SdfGrid& grid);
/// Box around the nodes, in world space.
Box boxOf(const SdfGrid& grid);
/// The SDF relative to an origin. \param firstKey  of the scene's keys
Sdf sdfOf(const DenseSdf& dense, uint32_t firstKey, const LocalOrigin& origin);
/// Adds the pass that writes the keys.
Result<void> addImport(const DenseSdf& dense, uint32_t firstKey, BufferId keys,
                       const ResourceTable& resources, PassList& list);

}  // namespace pelage::detail
