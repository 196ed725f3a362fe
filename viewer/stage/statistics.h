// Statistics of a frame, from the counters of the library.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pelage/hair_object.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "pelage/transparency.h"

namespace viewer {

/// Statistics of a hair object; counters have no value if its settings do not keep them.
struct HairStatistics {
  std::string name;
  uint32_t guides = 0, followHairs = 0;
  pelage::ObjectBytes bytes;
  std::optional<pelage::SimulationCounters> simulation;
  std::optional<pelage::ContactCounters> contacts;
  std::optional<pelage::FollowContactCounters> followContacts;
};

/// Statistics of a mesh collider.
struct ColliderStatistics {
  std::string name;
  uint32_t nodes[3] = {};
  float cellSize = 0;  ///< [m]
  pelage::ObjectBytes bytes;
};

struct StageStatistics {
  std::vector<HairStatistics> hairs;
  std::vector<ColliderStatistics> colliders;
  /// Counters of methods with lists or tiles.
  std::optional<pelage::TransparencyCounters> transparency;
};

/// Reads the counters of hair objects of a scene. Errors: those of `read`.
pelage::Result<std::vector<HairStatistics>> hairStatistics(const pelage::Scene& scene,
                                                           std::span<const pelage::HairId> hairs,
                                                           const pelage::BufferReader& read);
std::vector<ColliderStatistics> colliderStatistics(const pelage::Scene& scene,
                                                   std::span<const pelage::ColliderId> colliders);

inline double mebibytes(uint64_t bytes) { return static_cast<double>(bytes) / (1024 * 1024); }

/// Return statistics as lines of text.
std::vector<std::string> linesOf(const HairStatistics& hair);
std::string lineOf(const ColliderStatistics& collider);
std::vector<std::string> linesOf(const pelage::TransparencyCounters& counters);

}  // namespace viewer
