// The solvers of the simulation benchmark behind one interface: pelage's two and the baselines.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench_scene.h"
#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "workbench.h"

namespace bench {

/// One groom that one solver moves. Its buffers go with it.
class StrandSolver {
 public:
  virtual ~StrandSolver() = default;
  StrandSolver(const StrandSolver&) = delete;
  StrandSolver& operator=(const StrandSolver&) = delete;

  /// Writes the passes of the next frame of 1/60 s, at whose end the roots have this pose. The
  /// first frame takes the bind pose, at rest. Pass::bytes says what a pass moves at least.
  virtual pelage::Result<void> advance(const pelage::rod::RootPose& pose,
                                       pelage::PassList& list) = 0;
  /// [strand][vertex] Float4.
  virtual pelage::BufferId positions() const = 0;
  /// The same of the frame before, which Verlet integration takes the velocity from; kInvalid where
  /// a solver keeps none.
  virtual pelage::BufferId positionsBefore() const { return pelage::BufferId::kInvalid; }

 protected:
  StrandSolver() = default;
};

enum class SolverKind : uint8_t {
  kExact,     ///< pelage's exact solver
  kClassic,   ///< pelage's classic solver
  kSweeps,    ///< the classic baseline: baselines/sweeps_layout.hlsli
  kCosserat,  ///< XPBD Cosserat rods: baselines/simulate_cosserat.hlsl
};
const char* solverName(SolverKind kind);

/// A solver with the setting that trades its error for its time.
struct SolverChoice {
  SolverKind kind = SolverKind::kExact;
  uint32_t effort =
      1;  ///< sub-steps (kExact, kCosserat), length solves (kClassic), sweeps (kSweeps)

  std::string setting() const;
};

/// Makes the solver's buffers for a scene. Errors: settings that the solver refuses; a vertex count
/// that a baseline has no code for.
pelage::Result<std::unique_ptr<StrandSolver>> makeSolver(Workbench& workbench,
                                                         const BenchScene& scene,
                                                         const SolverChoice& choice);

pelage::Result<std::unique_ptr<StrandSolver>> makeSweepsSolver(Workbench& workbench,
                                                               const BenchScene& scene,
                                                               uint32_t sweeps);
/// \param inertia  of an edge over its length cubed; kEdgeInertia unless a test has its own
pelage::Result<std::unique_ptr<StrandSolver>> makeCosseratSolver(Workbench& workbench,
                                                                 const BenchScene& scene,
                                                                 uint32_t subSteps, float inertia);
inline constexpr float kEdgeInertia = 0.25f;

/// Microseconds that a copy of `bytes` takes, half of them read and half written, in float4 by a
/// thread a vertex; the least of some tries. Up to 7 float4 a vertex are copied, and the time of
/// more is in proportion. 0 without timestamps.
pelage::Result<double> copyFloor(Workbench& workbench, uint32_t vertices, uint64_t bytes);

}  // namespace bench
