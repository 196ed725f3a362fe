// The solvers of guides, exact and classic: their buffers, their state, and their passes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "passes/buffer_factory.h"
#include "passes/moved_elements.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "simulation/exact_solver.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// Sets of vectors in g_state of the classic solver.
inline constexpr uint64_t kClassicStateSets = simulation::kStateSets;

/// The settings pull vertices to the bind pose.
inline bool usesTargets(const SimulationSettings& s) {
  return s.globalStiffness > 0 && s.globalRange > 0;
}
/// Tiles of 32 strands.
inline uint64_t tileCount(uint64_t strands) {
  return (strands + exact::kTileStrands - 1) / exact::kTileStrands;
}
/// Words of g_sleep.
inline uint64_t sleepWordCount(uint64_t strands) {
  return exact::kSleepHead + 2 * tileCount(strands) + strands;
}

/// Functions that the solver calls for each sub-step.
struct StepInputs {
  /// Adds passes before a step of h seconds: what acts on the hair in it.
  std::function<Result<void>(double h, bool reset)> beginStep;
  /// Adds the pass that finds the contacts of a sub-step.
  std::function<Result<void>(const ContactPart& part)> findContacts;
};

/// The rest data on the GPU and the last frame: both solvers continue from them.
struct SolverMemory {
  RestSets rest;
  uint32_t limpGuides = 0;            ///< in `rest`
  uint64_t restVersion = 0;           ///< likewise, of RestPose::version
  uint64_t restVersionBefore = 0;     ///< of the last frame
  SimulationSettings settingsBefore;  ///< likewise; a change of others than subSteps wakes all
  float loadShareBefore = 1;          ///< likewise
  float lastFrame = 0;                ///< its length [s]; 0 before the first one
  bool followsShifted = false;        ///< not placed anew since a shift
  bool restChanged() const { return restVersion != restVersionBefore; }
};

/// The passes of the classic solver.
class ClassicSolver {
 public:
  Result<void> record(const HairFrame& frame, const StepInputs& inputs, const SolverMemory& memory);
  Result<void> skin(const HairFrame& frame, const SolverMemory& memory);
  static Result<void> rewritePositions(const HairFrame& frame);

 private:
  float lastStep_ = 0;  ///< length of the last sub-step [s]; 0 before the first one
};

/// The passes of the exact solver.
class ExactSolver {
 public:
  explicit ExactSolver(uint32_t stateStride = 0) : stateStride_(stateStride) {}
  Result<void> record(HairFrame& frame, const StepInputs& inputs, const SolverMemory& memory);
  Result<void> skin(const HairFrame& frame, const SolverMemory& memory);
  Result<void> rewritePositions(const HairFrame& frame, const SolverMemory& memory) const;
  uint32_t stateStride() const { return stateStride_; }

 private:
  ExactConstants constantsOf(const HairFrame& frame, const SolverMemory& memory) const;
  ExactConstants frameConstants(const HairFrame& frame, const SolverMemory& memory) const;
  Result<void> addSleepPass(HairFrame& frame, ExactConstants constants, const SolverMemory& memory);
  void setLevelOfDetail(const HairFrame& frame, ExactConstants& constants);

  uint32_t stateStride_;
  uint32_t slot_ = 0;            ///< of the state now
  uint32_t simulatedCount_ = 0;  ///< in the last frame; 0 before the first one
  uint32_t simulatedBefore_ = 0;
  bool sleptBefore_ = false;  ///< tiles could sleep in the last frame
  ExactHistory history_;
};

/// The solver of one object. A copy of it is what a frame is taken back to.
class StrandSolver {
 public:
  /// Makes the buffers where those that are there are for something else; the hair has no state
  /// then, and the frame is a reset.
  void prepare(HairFrame& frame);
  void remove(HairBuffers& buffers, const BufferFactory& factory);
  /// Strands in the order of the solver, for contacts.
  static ContactStrands strandsOf(const HairFrame& frame);
  /// Adds the passes of the frame.
  Result<void> record(HairFrame& frame, const StepInputs& inputs);
  /// Adds the pass that poses the guides without simulating them, in place of record(). A frame
  /// behind it continues from there, with the velocity of the roots.
  Result<void> skin(HairFrame& frame);
  /// Adds the passes that write the positions anew from the state, after a shift of the world.
  Result<void> rewritePositions(const HairFrame& frame) const;
  /// Elements of the state, the roots and the tangents that a rigid motion of the object moves.
  std::vector<MovedElements> moved(const HairFrame& frame) const;
  /// Call it where follow hairs are where no simulation has put them: the next frame places all of
  /// them anew, also those that sleep.
  void placeFollowsAnew() { memory_.followsShifted = true; }

  /// [2][guide] RootTransform
  BufferRange rootTransforms(const HairBuffers& buffers) const {
    return {buffers.state, rootBytes_, rootOffset_};
  }
  /// Strands that cannot balance SimulationSettings::sagCompensation.
  uint32_t limpGuides() const { return memory_.limpGuides; }
  float lastFrame() const { return memory_.lastFrame; }  ///< [s]; 0 before the first one

 private:
  void makeExactBuffers(HairFrame& frame);
  void makeState(const HairFrame& frame, uint64_t elements);
  void makeRest(const HairFrame& frame, const RestSets& sets);
  void keepFrame(const HairFrame& frame);

  std::optional<Solver> solver_;  ///< that the buffers were made for
  SolverMemory memory_;
  ClassicSolver classic_;
  ExactSolver exact_;
  uint64_t rootOffset_ = 0, rootBytes_ = 0;  ///< of the roots in the buffer of the state
};

}  // namespace pelage::detail
