#include "simulation/hair_passes.h"

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

namespace {

constexpr uint32_t kFollowsAThread = simulation::kStrandsAThread;

}  // namespace

SimulationConstants constantsOf(const HairFrame& frame) {
  const Float3 from = frame.origin.world();
  SimulationConstants constants = {};
  constants.origin = {from.x, from.y, from.z, 0};
  constants.rebase = {frame.rebase.x, frame.rebase.y, frame.rebase.z, 0};
  constants.guideCount = frame.guideCount;
  constants.followCount = frame.groom.storesFollowHairs ? frame.followCount : 0;
  constants.vertexCount = frame.vertexCount;
  constants.boneCount = frame.boneCount;
  constants.timeStepRatio = 1;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.tipSeparation = frame.settings.tipSeparation;
  constants.flags = frame.reset ? simulation::kResetFlag : 0;
  return constants;
}

uint32_t followThreads(uint32_t strands) {
  return (strands + kFollowsAThread - 1) / kFollowsAThread;
}

uint64_t maxStoredFollows() {
  return kMaxGroups * updateFollowHairsVariant({}).groupSize[0] * kFollowsAThread;
}

Result<void> addRootPass(const HairFrame& frame, SkinningMethod skinning) {
  const HairBuffers& buffers = frame.buffers;
  const uint64_t guides = frame.guideCount;
  SimulationConstants constants = constantsOf(frame);
  if (skinning == SkinningMethod::kDualQuaternions)
    constants.flags |= simulation::kDualQuaternionsFlag;
  PassBuilder builder(frame.list);
  builder.dispatch(skinRootsVariant(), frame.guideCount)
      .bytes(guides * (sizeof(RootBinding) + kVector + 3 * sizeof(RootTransform)));
  return builder.finish(SimBindings{
      .simulationConstants = constants,
      .rest = {buffers.bindRoots, guides * kVector},
      .boneTransforms = {buffers.boneTransforms, rowsOf(skinning) * frame.boneCount * kVector},
      .rootBindings = {buffers.rootBindings, guides * sizeof(RootBinding)},
      .rootTransforms = frame.roots,
  });
}

Result<void> addFollowPass(const HairFrame& frame) {
  if (!frame.groom.storesFollowHairs) return {};
  const HairBuffers& buffers = frame.buffers;
  const uint64_t guides = frame.guideCount;
  const uint64_t follows = frame.followCount;
  const uint64_t vertices = frame.vertexCount;
  SimulationConstants constants = constantsOf(frame);
  constants.flags = 0;
  PassBuilder builder(frame.list);
  if (frame.sleeps)
    builder.dispatchIndirect(updateFollowHairsVariant({}), buffers.sleep, kFollowArguments);
  else
    builder.dispatch(updateFollowHairsVariant({}), followThreads(frame.followCount),
                     frame.vertexCount);
  builder.bytes(follows * (sizeof(FollowHairRecord) + 3 * vertices * kVector));
  return builder.finish(
      SimPosTanBindings{
          .positions = {buffers.positions, (guides + follows) * vertices * kVector},
          .tangents = {buffers.tangents, (guides + follows) * vertices * kVector},
      },
      SimBindings{
          .simulationConstants = constants,
          .rest = {buffers.bindRoots, guides * kVector},
          .followHairRecords = {buffers.followHairRecords, follows * sizeof(FollowHairRecord)},
          .rootTransforms = frame.roots,
      });
}

Result<void> addShift(const HairFrame& frame, Float3 by, BufferId buffer, uint64_t first,
                      uint64_t count) {
  ShiftPositionsConstants constants = {};
  constants.shift = {by.x, by.y, by.z, 0};
  constants.shiftedFirst = static_cast<uint32_t>(first);
  constants.shiftedCount = static_cast<uint32_t>(count);
  PassBuilder builder(frame.list);
  dispatchRows(builder, shiftPositionsVariant({}), count);
  builder.bytes(2 * count * kVector);
  return builder.finish(ShiftPositionsBindings{
      .shiftPositionsConstants = constants,
      .shiftedPositions = {buffer, (first + count) * kVector},
  });
}

Result<void> addRigidMove(const HairFrame& frame, const RigidMove& move,
                          const MovedElements& elements) {
  const auto narrow = [](double v) { return static_cast<float>(v); };
  const Float3 shift = toFloat3(move.shift);
  MoveRigidlyConstants constants = {};
  constants.moveRotation = {narrow(move.rotation.x), narrow(move.rotation.y),
                            narrow(move.rotation.z), narrow(move.rotation.w)};
  constants.moveShift = {shift.x, shift.y, shift.z, 0};
  constants.movedFirst = static_cast<uint32_t>(elements.first);
  constants.movedCount = static_cast<uint32_t>(elements.count);
  constants.movedBlock = static_cast<uint32_t>(elements.block);
  constants.movedPeriod = elements.period;
  constants.movedKinds = elements.kinds;
  PassBuilder builder(frame.list);
  dispatchRows(builder, moveRigidlyVariant({}), elements.count);
  builder.bytes(2 * elements.count * kVector);
  return builder.finish(MoveRigidlyBindings{
      .moveRigidlyConstants = constants,
      .movedElements = {elements.buffer, (elements.first + elements.count) * kVector},
  });
}

}  // namespace pelage::detail
