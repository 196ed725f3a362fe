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
  void placeFollowsAnew() { followsShifted_ = true; }

  /// [2][guide] RootTransform
  BufferRange rootTransforms(const HairBuffers& buffers) const {
    return {buffers.state, rootBytes_, rootOffset_};
  }
  /// Strands that cannot balance SimulationSettings::sagCompensation.
  uint32_t limpGuides() const { return limpGuides_; }
  float lastFrame() const { return lastFrame_; }  ///< [s]; 0 before the first one

 private:
  void makeClassicBuffers(const HairFrame& frame);
  void makeExactBuffers(const HairFrame& frame);
  void makeState(const HairFrame& frame, uint64_t elements);
  void makeRest(const HairFrame& frame, const RestSets& sets);
  bool restChanged() const { return restVersion_ != restVersionBefore_; }

  SimulationConstants classicConstants(const HairFrame& frame) const;
  Result<void> addClassicPasses(const HairFrame& frame, const StepInputs& inputs);
  Result<void> skinClassic(const HairFrame& frame);
  Result<void> rewriteClassic(const HairFrame& frame) const;

  ExactConstants exactConstants(const HairFrame& frame) const;
  ExactConstants frameConstants(const HairFrame& frame) const;
  Result<void> addExactPasses(HairFrame& frame, const StepInputs& inputs);
  Result<void> addExactStep(const HairFrame& frame, const StepInputs& inputs,
                            const ExactConstants& constants, uint32_t step) const;
  Result<void> addContactStep(const HairFrame& frame, const StepInputs& inputs,
                              ExactConstants constants, uint32_t step) const;
  Result<void> addStrandPass(const HairFrame& frame, const KernelVariant& variant,
                             const ExactConstants& constants) const;
  uint64_t vertexBytes(const HairFrame& frame) const;
  Result<void> addSleepPass(HairFrame& frame, ExactConstants constants);
  Result<void> addInterpolationPass(const HairFrame& frame, const ExactConstants& constants,
                                    uint32_t strands) const;
  Result<void> finishExactPass(const HairFrame& frame, PassBuilder& builder,
                               const ExactConstants& constants, uint64_t bytes) const;
  void setLevelOfDetail(const HairFrame& frame, ExactConstants& constants);
  Result<void> skinExact(const HairFrame& frame);
  Result<void> rewriteExact(const HairFrame& frame) const;

  std::optional<Solver> solver_;    ///< that the buffers were made for
  RestSets restSets_;               ///< likewise
  uint32_t limpGuides_ = 0;         ///< in restSets_
  uint64_t restVersion_ = 0;        ///< likewise, of RestPose::version
  uint64_t restVersionBefore_ = 0;  ///< of the last frame
  /// Settings of the last frame; a change wakes all strands.
  SimulationSettings settingsBefore_;
  float loadShareBefore_ = 1;  ///< likewise
  float lastFrame_ = 0;
  float lastStep_ = 0;        ///< classic: length of the last sub-step [s]; 0 before the first one
  bool sleptBefore_ = false;  ///< tiles could sleep in the last frame
  bool followsShifted_ = false;  ///< not placed anew since a shift
  uint32_t simulatedBefore_ = 0;
  uint32_t simulatedCount_ = 0;  ///< exact: in the last frame; 0 before the first one
  ExactHistory history_;
  uint32_t slot_ = 0;  ///< exact: of the state now
  uint32_t stateStride_ = 0;
  uint64_t rootOffset_ = 0, rootBytes_ = 0;  ///< of the roots in the buffer of the state
};

}  // namespace pelage::detail
