// The passes of the exact solver.
#include <algorithm>
#include <cmath>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "simulation/hair_passes.h"
#include "simulation/strand_solver.h"

namespace pelage::detail {

using exact::kSleepHead;

namespace {

// A change of the level of detail over all guides takes this long [s]; and the share of them, one
// in so many, that fade.
constexpr double kLevelOfDetailSeconds = 0.25;
constexpr uint32_t kFadingShare = 8;
// Tiles that an indirect dispatch can list.
constexpr uint32_t kMaxListedTiles = 65535;

// Number of simulated guides that take on more and more of the shape of another one.
uint32_t fadingGuides(uint32_t guides, uint32_t simulated) {
  return std::min({guides / kFadingShare, guides - simulated, std::max(simulated, 1u) - 1});
}

// Kernels of shock propagation want it where either of its parameters acts.
bool usesShockPropagation(const SimulationSettings& s) {
  return s.vspCoefficient > 0 || std::isfinite(s.vspThreshold);
}

// Strands of a group of eliminate_strands and roll_out_strands. Groups of few strands are faster
// while the device has room for all of them.
uint32_t groupStrands(uint32_t strands) {
  constexpr uint32_t kFew = 8192;
  return strands <= kFew ? exact::kNarrowStrands : exact::kTileStrands;
}

// Offset of the arguments of an indirect dispatch over the strands that are solved again.
uint64_t listArguments(const ExactConstants& constants, uint32_t arguments) {
  return (uint64_t{constants.contactHead} + arguments) * sizeof(uint32_t);
}

// Bytes that a pass over all vertices moves.
uint64_t vertexBytes(const HairFrame& frame, const ExactConstants& constants) {
  return uint64_t{constants.simulatedCount} * frame.vertexCount * kExactBytesAVertex;
}

// Adds a pass of the group "exact".
// \param bytes that it moves
Result<void> finishExactPass(const HairFrame& frame, PassBuilder& builder,
                             const ExactConstants& constants, uint64_t bytes) {
  const HairBuffers& buffers = frame.buffers;
  const uint64_t guides = frame.guideCount;
  const uint64_t vertices = guides * frame.vertexCount;
  const BufferRange rest = frame.factory.resources.whole(buffers.rest);
  const BufferRange colliders = frame.factory.resources.whole(buffers.colliders);
  builder.bytes(bytes);
  return builder.finish(
      ExactPosTanBindings{
          .positions = {buffers.positions, vertices * kVector},
          .tangents = {buffers.tangents, vertices * kVector},
      },
      ExactBindings{
          .exactConstants = constants,
          .rest = rest,
          // A stand-in that is not read, where there are no colliders.
          .exactColliders = colliders.isBound() ? colliders : rest,
          .forces = {frame.forces, vertices * kVector},
          .lodParents = {buffers.lodParents, guides * sizeof(uint32_t)},
          .state = frame.factory.resources.whole(buffers.state),
          .sleep = {buffers.sleep, sleepWordCount(guides) * sizeof(uint32_t)},
          .contacts = frame.contacts.records,
          .contactWords = frame.contacts.words,
      });
}

Result<void> addInterpolationPass(const HairFrame& frame, const ExactConstants& constants,
                                  uint32_t strands) {
  PassBuilder builder(frame.list);
  builder.dispatch(interpolateGuidesVariant({}), strands);
  return finishExactPass(frame, builder, constants,
                         uint64_t{strands} * frame.vertexCount * 5 * kVector);
}

// Adds a pass with contacts that has a thread a strand.
Result<void> addStrandPass(const HairFrame& frame, const KernelVariant& variant,
                           const ExactConstants& constants) {
  PassBuilder builder(frame.list);
  const uint32_t strands = groupStrands(frame.guideCount);
  if ((constants.flags & exact::kAgainFlag) != 0)
    builder.dispatchIndirect(variant, frame.contacts.words.buffer,
                             listArguments(constants, contact_records::kContactStrandArguments));
  else if (frame.sleeps)
    builder.dispatchIndirect(variant, frame.buffers.sleep);
  else
    dispatchGroups(builder, variant, (uint64_t{constants.simulatedCount} + strands - 1) / strands);
  return finishExactPass(frame, builder, constants, vertexBytes(frame, constants));
}

// A sub-step with contacts: two rounds, the second one of the strands that the first one lists.
Result<void> addContactStep(const HairFrame& frame, const StepInputs& inputs,
                            ExactConstants constants, uint32_t step, bool globalShape) {
  const bool narrow = groupStrands(frame.guideCount) == exact::kNarrowStrands;
  if (narrow) constants.flags |= exact::kNarrowFlag;
  const auto eliminate = [&](bool blocks) -> const KernelVariant& {
    return eliminateStrandsVariant({.blocks = blocks,
                                    .globalShape = globalShape,
                                    .forces = frame.forces != BufferId::kInvalid});
  };
  if (step == 0 && frame.reset) {
    // The positions are those of the frame before.
    ExactConstants pose = constants;
    pose.flags |= exact::kPoseFlag;
    if (Result<void> added = addStrandPass(frame, eliminate(narrow), pose); !added) return added;
  }
  for (const bool again : {false, true}) {
    if (again) constants.flags |= exact::kAgainFlag;
    const ContactPart part = {.step = step,
                              .steps = frame.steps * frame.settings.subSteps,
                              .strands = constants.simulatedCount,
                              .again = again};
    if (Result<void> found = inputs.findContacts(part); !found) return found;
    const bool blocks = narrow || again;
    if (Result<void> added = addStrandPass(frame, eliminate(blocks), constants); !added)
      return added;
    PassBuilder builder(frame.list);
    const KernelVariant& solve = solveContactsVariant({});
    builder.dispatchIndirect(
        solve, frame.contacts.words.buffer,
        listArguments(constants, again ? contact_records::kContactSolveArguments
                                       : contact_records::kContactGroupArguments));
    Result<void> added = finishExactPass(frame, builder, constants, vertexBytes(frame, constants));
    if (added) added = addStrandPass(frame, rollOutStrandsVariant({.blocks = blocks}), constants);
    if (!added) return added;
  }
  return {};
}

// A sub-step.
Result<void> addStep(const HairFrame& frame, const ExactConstants& constants, bool globalShape) {
  const KernelVariant& variant =
      simulateExactVariant({.globalShape = globalShape,
                            .velocityShockPropagation = usesShockPropagation(frame.settings),
                            .forces = frame.forces != BufferId::kInvalid});
  PassBuilder builder(frame.list);
  if (frame.sleeps)
    builder.dispatchIndirect(variant, frame.buffers.sleep);
  else
    dispatchRows(builder, variant, constants.simulatedCount);
  return finishExactPass(frame, builder, constants, vertexBytes(frame, constants));
}

}  // namespace

ExactConstants ExactSolver::constantsOf(const HairFrame& frame, const SolverMemory& memory) const {
  const Float3 origin = frame.origin.world();
  ExactConstants constants = {};
  constants.origin = {origin.x, origin.y, origin.z, 0};
  constants.rebase = {frame.rebase.x, frame.rebase.y, frame.rebase.z, 0};
  constants.strandCount = frame.guideCount;
  constants.stateStride = stateStride_;
  constants.strandRecords = memory.rest.count() * stateStride_;
  constants.bindSet = memory.rest.bindSet();
  constants.rootCount = frame.guideCount;
  constants.outputCount = frame.guideCount * frame.vertexCount;
  constants.outputVertices = frame.vertexCount;
  constants.colliderCount = frame.contacts.capsuleCount;
  constants.slot = slot_;
  constants.simulatedCount = simulatedCount_;
  constants.fadeStart = simulatedCount_ - fadingGuides(frame.guideCount, simulatedCount_);
  return constants;
}

// The tiles that sleep in this frame; nothing where all are awake for sure.
Result<void> ExactSolver::addSleepPass(HairFrame& frame, ExactConstants constants,
                                       const SolverMemory& memory) {
  const SimulationSettings& s = frame.settings;
  const HairBuffers& buffers = frame.buffers;
  const uint64_t tiles = tileCount(frame.guideCount);
  const bool gusts =
      !isZero(s.wind.velocity) && s.wind.gustStrength > 0 && s.damping > 0 && frame.loadShare > 0;
  const bool forced = frame.forces != BufferId::kInvalid;
  const bool refined = simulatedCount_ != simulatedBefore_;
  simulatedBefore_ = simulatedCount_;
  frame.sleeps = s.sleep.enabled && !gusts && !forced && tiles <= kMaxListedTiles;
  // Fast colliders change the number of sub-steps; that moves nothing which rests.
  SimulationSettings before = memory.settingsBefore;
  before.subSteps = s.subSteps;
  const bool wake = frame.reset || !isZero(frame.rebase) || !sleptBefore_ || refined ||
                    frame.contacts.replaced || memory.restChanged() || s != before ||
                    frame.loadShare != memory.loadShareBefore;
  sleptBefore_ = frame.sleeps;
  if (!frame.sleeps) return {};

  const KernelVariant& follow = updateFollowHairsVariant({});
  const auto groups = [](uint32_t threads, uint32_t size) { return (threads + size - 1) / size; };
  const uint32_t followGroups = frame.groom.storesFollowHairs
                                    ? groups(followThreads(frame.followCount), follow.groupSize[0])
                                    : 0;
  uint32_t head[kSleepHead] = {};
  const auto set = [&](uint32_t arguments, uint32_t x, uint32_t y) {
    head[arguments] = x;
    head[arguments + 1] = y;
    head[arguments + 2] = 1;
  };
  set(exact::kSleepSolveArguments, 0,
      frame.contacts.any ? exact::kTileStrands / groupStrands(frame.guideCount) : 1);
  set(exact::kSleepFollowArguments, memory.followsShifted ? followGroups : 0,
      groups(frame.vertexCount, follow.groupSize[1]));
  set(exact::kSleepFindArguments, 0, frame.contacts.rows);
  addUpload(frame.list, buffers.sleep, std::as_bytes(std::span(head)));
  constants.flags = wake ? exact::kWakeAllFlag : 0;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.slot = slot_;
  constants.followGroups = followGroups;
  PassBuilder builder(frame.list);
  dispatchGroups(builder, selectAwakeTilesVariant({}), tiles);
  return finishExactPass(frame, builder, constants,
                         frame.guideCount * sizeof(uint32_t) + tiles * 2 * sizeof(uint32_t));
}

// Constants that do not depend on the step.
ExactConstants ExactSolver::frameConstants(const HairFrame& frame,
                                           const SolverMemory& memory) const {
  const SimulationSettings& s = frame.settings;
  const uint32_t steps = frame.steps * s.subSteps;
  ExactConstants constants = constantsOf(frame, memory);
  constants.frameTime = frame.length;
  constants.frameTimeBefore =
      frame.reset || !(memory.lastFrame > 0) ? frame.length : memory.lastFrame;
  constants.parameterSet = memory.rest.factors ? memory.rest.count() - 1 : 0;
  constants.restSpeed = s.sleep.speed;
  constants.restTime = s.sleep.time;
  constants.wakeDistance = s.sleep.wakeDistance;
  constants.slotsBack = (exact::kStateSlots - steps % exact::kStateSlots) % exact::kStateSlots;
  return constants;
}

Result<void> ExactSolver::record(HairFrame& frame, const StepInputs& inputs,
                                 const SolverMemory& memory) {
  const SimulationSettings& s = frame.settings;
  const uint32_t steps = frame.steps * s.subSteps;
  const double h = static_cast<double>(frame.length) / steps;
  ExactConstants constants = frameConstants(frame, memory);
  const uint32_t countBefore = simulatedCount_;
  setLevelOfDetail(frame, constants);
  if (Result<void> added = addSleepPass(frame, constants, memory); !added) return added;
  if (countBefore > 0 && simulatedCount_ > countBefore && !frame.reset) {
    ExactConstants restart = constants;
    restart.flags = exact::kRestartFlag;
    restart.restartFrom = countBefore;
    restart.slot = slot_;
    const Result<void> added = addInterpolationPass(frame, restart, simulatedCount_ - countBefore);
    if (!added) return added;
  }
  if (frame.reset) history_ = {};
  constants.contactList = frame.contacts.list;
  constants.contactMasks = frame.contacts.masks;
  constants.contactMaskWords = frame.contacts.maskWords;
  for (uint32_t step = 0; step < steps; ++step) {
    if (step % s.subSteps == 0) {
      const Result<void> added = inputs.beginStep(h * s.subSteps, step == 0 && frame.reset);
      if (!added) return added;
    }
    setExactStep(constants, s, h, history_, frame.air, frame.loadShare);
    constants.rootBegin = static_cast<float>(step) / static_cast<float>(steps);
    constants.rootEnd = static_cast<float>(step + 1) / static_cast<float>(steps);
    constants.flags = step + 1 == steps ? exact::kLastFlag : 0;
    if (frame.sleeps) constants.flags |= exact::kSleepFlag;
    if (constants.rotationRatio != 1 || (step == 0 && memory.restChanged()))
      constants.flags |= exact::kChangedFlag;
    if (step == 0 && frame.reset) constants.flags |= exact::kResetFlag;
    if (step == 0 && !isZero(frame.rebase)) constants.flags |= exact::kRebaseFlag;
    constants.slot = slot_;
    slot_ = (slot_ + 1) % exact::kStateSlots;
    constants.contactHead = frame.contacts.firstHead + step * frame.contacts.headWords;
    const Result<void> added =
        frame.contacts.any ? addContactStep(frame, inputs, constants, step, memory.rest.targets)
                           : addStep(frame, constants, memory.rest.targets);
    if (!added) return added;
  }
  if (constants.fadeStart == frame.guideCount) return {};
  constants.flags = 0;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.slot = slot_;
  return addInterpolationPass(frame, constants, frame.guideCount - constants.fadeStart);
}

// How many guides are simulated in this frame, and from which one on they fade.
void ExactSolver::setLevelOfDetail(const HairFrame& frame, ExactConstants& constants) {
  const uint32_t guides = frame.guideCount;
  const float share = frame.simulatedShare;
  const auto wanted =
      std::clamp(static_cast<uint32_t>(std::ceil(static_cast<double>(share) * guides)), 1u, guides);
  const auto most = static_cast<uint32_t>(
      std::ceil(guides * static_cast<double>(frame.length) / kLevelOfDetailSeconds));
  uint32_t& count = simulatedCount_;
  if (count == 0 || frame.reset)
    count = wanted;
  else if (wanted < count)
    count -= std::min(count - wanted, most);
  else if (isZero(frame.rebase))  // new states are relative to the new origin already
    count += std::min(wanted - count, most);
  constants.simulatedCount = count;
  constants.fadeStart = count - fadingGuides(guides, count);
}

// The bind shape under the roots. The frame counts as the second of two steps of backward Euler.
Result<void> ExactSolver::skin(const HairFrame& frame, const SolverMemory& memory) {
  if (sleptBefore_) {
    const uint32_t nothingIsAwake[kSleepHead] = {};
    addUpload(frame.list, frame.buffers.sleep, std::as_bytes(std::span(nothingIsAwake)));
  }
  sleptBefore_ = false;
  simulatedCount_ = simulatedBefore_ = frame.guideCount;
  const double rate = 1 / static_cast<double>(frame.length);
  history_ = {.step = static_cast<double>(frame.length), .rate = rate, .rateBefore = rate};
  ExactConstants constants = frameConstants(frame, memory);
  constants.vspCoefficient = frame.settings.vspCoefficient;
  PassBuilder builder(frame.list);
  dispatchRows(builder, skinExactStrandsVariant({}), frame.guideCount);
  return finishExactPass(frame, builder, constants, 7 * frame.guideVertices() * kVector);
}

// Positions from the state, after a shift of the world.
Result<void> ExactSolver::rewritePositions(const HairFrame& frame,
                                           const SolverMemory& memory) const {
  const uint32_t guides = frame.guideCount;
  ExactConstants constants = constantsOf(frame, memory);
  const Float3 origin = frame.stateOrigin.world();
  constants.origin = {origin.x, origin.y, origin.z, 0};
  constants.rootEnd = 1;  // of the last frame
  PassBuilder builder(frame.list);
  dispatchRows(builder, rewriteExactPositionsVariant({}), constants.simulatedCount);
  const uint64_t bytes = uint64_t{constants.simulatedCount} * frame.vertexCount * 4 * kVector;
  if (Result<void> added = finishExactPass(frame, builder, constants, bytes); !added) return added;
  if (constants.fadeStart == guides) return {};
  return addInterpolationPass(frame, constants, guides - constants.fadeStart);
}

}  // namespace pelage::detail
