// What the passes of a frame share.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "simulation/exact_solver.h"

namespace pelage {
namespace detail {

inline constexpr uint64_t kVector = sizeof(Float4);
/// Root frames a guide in g_rootTransforms, as in kernels/layouts/simulation.hlsli.
inline constexpr uint64_t kRootTransformSets = 2;
/// Of g_state, as in kernels/layouts/simulation.hlsli.
inline constexpr uint64_t kClassicStateSets = 3;
/// Words of g_sleep before its list, as in kernels/layouts/exact.hlsli; and where the groups of the
/// follow strands are.
inline constexpr uint64_t kSleepHead = 12;
inline constexpr uint64_t kFollowArguments = 4 * sizeof(uint32_t);
inline constexpr uint64_t kFindArguments = 8 * sizeof(uint32_t);

template <class T>
std::vector<std::byte> bytesOf(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

inline bool isZero(Float3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

inline uint64_t tileCount(uint64_t strands) { return (strands + kTileStrands - 1) / kTileStrands; }

/// Threads in x of update_follow_strands, as there.
inline constexpr uint32_t kFollowsAThread = 4;
inline uint32_t followThreads(uint32_t strands) {
  return (strands + kFollowsAThread - 1) / kFollowsAThread;
}

inline bool usesVsp(const SimulationSettings& s) {
  return s.vspCoefficient > 0 || std::isfinite(s.vspThreshold);
}

}  // namespace detail

/// A frame of one object.
struct Scene::Frame {
  HairObject& object;
  detail::HairInternals& internals;
  const SimulationSettings& settings;
  PassList& list;
  float length;  ///< [s]
  uint32_t steps;
  detail::AirMotion air;
  bool reset;
  detail::LocalOrigin stateOrigin;  ///< of the state that the frame begins with
  Float3 rebase;                    ///< from there to that of the object
  uint32_t colliderCount;
  uint32_t fieldCount;  ///< of mesh colliders within reach
  bool sleeps;
  bool collidersReplaced;
  bool contacts = false;  ///< they are found in this frame

  SimulationConstants commonConstants() const;
  /// What does not depend on the step, for the state as it is.
  ExactConstants exactConstants() const;
};

}  // namespace pelage
