// The rows of the scene benchmark: which scene is run with which solver.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace bench {

enum class SceneKind : uint8_t {
  kFree,          ///< generated hair of 32 vertices without colliders
  kHeadCapsules,  ///< the sample's head, whose hair collides with capsules
  kHeadSdf,       ///< the same with the head's SDF
  kCharacter,     ///< the sample's character: three hair objects, three SDFs
};

enum class RowSolver : uint8_t {
  kExact,
  kClassic,
  kBaseline,  ///< the classic baseline: baselines/sweeps_layout.hlsli, field_layout.hlsli
};
const char* rowSolverName(RowSolver solver);

struct SceneRow {
  std::string scene;
  SceneKind kind = SceneKind::kFree;
  uint32_t guides = 0;  ///< of a character: those of its long hair
  RowSolver solver = RowSolver::kExact;
  bool followsCollide = false;
  uint32_t characters = 1;

  /// Scene, solver, and which hair collides: "head_sdf/exact/guides", "head_sdf/exact/follow".
  std::string name() const;
};

enum class SceneSize : uint8_t {
  kFull,
  kSmall,  ///< for software drivers, and within the buffers that they can bind
  kQuick,  ///< a handful of strands, for a smoke test
};

/// All rows, the baseline of a scene before what is compared with it.
std::vector<SceneRow> sceneRows(SceneSize size);

}  // namespace bench
