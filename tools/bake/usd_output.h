// A cache of a shot as a file for other tools.
#pragma once

#include <cstdint>
#include <filesystem>

#include "pelage/result.h"

namespace pelage::bake {

/// Writes the frames of a .pelagecache file as USD curves, with velocities and the numbers of the
/// strands as ids. \param width  diameter of fibers [m]. \param threads  that write the text of a
/// frame together, >= 1. Errors: those of reading and writing.
Result<void> writeUsd(const std::filesystem::path& cache, float width,
                      const std::filesystem::path& path, uint32_t threads);

}  // namespace pelage::bake
