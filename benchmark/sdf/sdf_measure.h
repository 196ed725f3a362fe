// Builds one field in one way and collides hair with it: what it got wrong, and what it cost.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sdf/build_bench.h"
#include "simulation/copy_reference.h"

namespace bench {

/// One row of the results. What a row does not have is negative.
struct SdfRow {
  std::string shape, what, method;  ///< what: build, collide_near, collide_usual
  std::string response;             ///< of a collision
  uint32_t triangles = 0, cells = 0;
  float cellSize = 0;  ///< [m]
  /// All passes [us]; 0 without timestamps.
  double median = 0, least = 0;
  /// Medians of its parts: surface records, interior beyond the band; keys and signs are the rest.
  double surface = -1, interior = -1;
  SdfErrors errors;
  bool hasErrors = false;
  uint32_t vertices = 0;  ///< that collide
  double resolved = -1;   ///< share of those deeper than 0.05 cell that end above -0.02 cell, 0..1
  uint64_t nodes = 0, sdfBytes = 0, bytes = 0;
  double ratioToClassic = 0;  ///< of median, to the classic build on its own grid
  CopyTimes copies;           ///< beside the frames
  std::string passes;         ///< name and median of each [us]
};

/// Hair that collides, and which of its vertices are judged.
struct HairSet {
  std::string name;
  std::vector<pelage::Float4> start;
  std::vector<uint32_t> deep;  ///< a sample of those deeper than 0.05 cell
};
/// \param vertices  a multiple of 32
/// \param from,to   of a strand's ends from the surface [cell], negative inside
HairSet makeHairSet(const SdfShape& shape, const pelage::reference::DistanceOracle& oracle,
                    std::string name, uint32_t vertices, float from, float to, float cellSize);

/// The shape and size at which all methods are compared.
struct SdfCase {
  const SdfShape& shape;
  uint32_t cells;
  const NodeGrid& grid;
  std::span<const float> truth;  ///< trueDistances() of the grid
  std::span<const HairSet> hair;
};

/// Builds, and collides what there is of hair. The frames of a row run again where the copy drifts.
/// \param frames  an even number
pelage::Result<std::vector<SdfRow>> measureSdf(Workbench& workbench, CopyReference& copies,
                                               const SdfCase& what, const SdfMethod& method,
                                               const pelage::reference::DistanceOracle& oracle,
                                               int frames);

/// Appends rows to a CSV file, and the header when it is new.
pelage::Result<void> appendSdfCsv(const std::string& path, const std::vector<SdfRow>& rows,
                                  const pelage::DeviceInfo& device, const std::string& commit);

}  // namespace bench
