// Draws of strands as a scene makes them, with other pixel kernels.
#pragma once

#include <functional>
#include <vector>

#include "oit/hair_scene.h"

namespace bench {

/// The lists of a scene's linked lists with the smallest of pools; others are made from them.
pelage::Result<std::vector<pelage::PassList>> strandLists(HairScene& scene,
                                                          const pelage::View& view);

/// Adds the draws of smooth strands that `from` has to `to`, with their resources and another pixel
/// kernel. \param offer adds that kernel's own resources to a pass.
pelage::Result<void> addStrandDraws(const pelage::PassList& from,
                                    const pelage::KernelVariant& pixel,
                                    const std::function<void(pelage::PassBuilder&)>& offer,
                                    pelage::PassList& to);

/// Adds whatever of the passes of `from` is not a linked list's to `to`: the mesh, the shadows.
/// `to` must be empty.
void copyOtherPasses(const pelage::PassList& from, pelage::PassList& to);

/// A block of the first draw of strands; nothing when there is no such draw.
std::vector<std::byte> blockOfStrands(const pelage::PassList& list, std::string_view name);

}  // namespace bench
