// The passes of the exact solver.
#include <algorithm>
#include <cmath>

#include "pelage/kernels.h"
#include "scene/scene_frame.h"

namespace pelage {

using detail::followThreads;
using detail::isZero;
using detail::kRootTransformSets;
using detail::kSleepHead;
using detail::kVector;
using detail::tileCount;
using detail::usesVsp;

namespace {

// Bits of ExactConstants::flags, as in kernels/layouts/exact.hlsli.
constexpr uint32_t kExactReset = 1;
constexpr uint32_t kExactLast = 2;
constexpr uint32_t kExactRebase = 4;
constexpr uint32_t kExactSleep = 8;
constexpr uint32_t kExactWakeAll = 16;
constexpr uint32_t kExactChanged = 32;
constexpr uint32_t kExactRestart = 64;
constexpr uint32_t kExactAgain = 128;
constexpr uint32_t kExactPose = 256;
// A change of the level of detail over all guides takes this long [s]; and the share of them, one
// in so many, that fade.
constexpr double kLevelOfDetailSeconds = 0.25;
constexpr uint32_t kFadingShare = 8;
// Groups in a row of select_awake_tiles, and tiles that an indirect dispatch can list.
constexpr uint32_t kSelectRow = 32768;
constexpr uint32_t kMaxListedTiles = 65535;
// Threads of an exact dispatch in x, as in simulate_rods.
constexpr uint32_t kExactRow = 1u << 20;

// Of those that are simulated, how many take on more and more of the shape of another one.
uint32_t fadingGuides(uint32_t guides, uint32_t simulated) {
  return std::min({guides / kFadingShare, guides - simulated, std::max(simulated, 1u) - 1});
}

}  // namespace

ExactConstants Scene::Frame::exactConstants() const {
  const Float3 origin = internals.origin.world();
  ExactConstants constants = {};
  constants.origin = {origin.x, origin.y, origin.z, 0};
  constants.rebase = {rebase.x, rebase.y, rebase.z, 0};
  constants.strandCount = object.guideCount_;
  constants.stateStride = internals.stateStride;
  constants.rootCount = object.guideCount_;
  constants.outputCount = object.guideCount_ * object.vertexCount_;
  constants.outputVertices = object.vertexCount_;
  constants.colliderCount = colliderCount;
  constants.slot = internals.slot;
  constants.simulatedCount = internals.simulatedCount;
  constants.fadeStart =
      internals.simulatedCount - fadingGuides(object.guideCount_, internals.simulatedCount);
  return constants;
}

// The tiles that sleep in this frame; nothing where all are awake for sure.
Result<void> Scene::addSleepPass(Frame& frame, ExactConstants constants) {
  const SimulationSettings& s = frame.settings;
  HairObject& object = frame.object;
  detail::HairInternals& internals = frame.internals;
  const HairBuffers& buffers = object.buffers_;
  const uint64_t tiles = tileCount(object.guideCount_);
  const bool gusts = !isZero(s.wind.velocity) && s.wind.gustStrength > 0 && s.damping > 0;
  const bool forced = forcesOf(object) != BufferId::kInvalid;
  const bool refined = internals.simulatedCount != internals.simulatedBefore;
  internals.simulatedBefore = internals.simulatedCount;
  frame.sleeps = s.sleep.enabled && !gusts && !forced && tiles <= kMaxListedTiles;
  const bool wake = frame.reset || !isZero(frame.rebase) || !internals.sleptBefore || refined ||
                    frame.collidersReplaced || s != internals.settingsBefore;
  internals.sleptBefore = frame.sleeps;
  if (!frame.sleeps) return {};

  const KernelVariant& follow = updateFollowStrandsVariant({});
  const auto groups = [](uint32_t threads, uint32_t size) { return (threads + size - 1) / size; };
  const uint32_t followGroups =
      internals.storesFollowHairs ? groups(followThreads(object.followCount_), follow.groupSize[0])
                                  : 0;
  const uint32_t head[kSleepHead] = {0,
                                     1,
                                     1,
                                     0,
                                     internals.followsShifted ? followGroups : 0,
                                     groups(object.vertexCount_, follow.groupSize[1]),
                                     1,
                                     0,
                                     0,
                                     internals.contacts.rows(),
                                     1,
                                     0};
  addUpload(frame.list, buffers.sleep, std::as_bytes(std::span(head)));
  constants.flags = wake ? kExactWakeAll : 0;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.slot = internals.slot;
  constants.followGroups = followGroups;
  PassBuilder builder(frame.list);
  const auto columns = static_cast<uint32_t>(std::min<uint64_t>(tiles, kSelectRow));
  const auto rows = static_cast<uint32_t>((tiles + kSelectRow - 1) / kSelectRow);
  builder.dispatch(selectAwakeTilesVariant({}), columns * detail::kTileStrands, rows);
  bindExact(frame, builder);
  // A stand-in that is not read, where there are no colliders.
  builder.bind("g_exactColliders", buffers.strands, object.guideCount_ * sizeof(ExactStrand));
  builder.constants("ExactConstants", constants)
      .bytes(object.guideCount_ * sizeof(uint32_t) + tiles * 2 * sizeof(uint32_t));
  return builder.finish();
}

// Offers what the kernels of the group "exact" read and write.
void Scene::bindExact(const Frame& frame, PassBuilder& builder) const {
  const HairObject& object = frame.object;
  const HairBuffers& buffers = object.buffers_;
  const uint64_t guides = object.guideCount_;
  const uint64_t vertices = guides * object.vertexCount_;
  const uint64_t stride = frame.internals.stateStride;
  builder.bind("g_positions", buffers.positions, vertices * kVector)
      .bind("g_tangents", buffers.tangents, vertices * kVector)
      .bind("g_state", buffers.state, detail::exactStateCount(stride, guides) * kVector)
      .bind("g_gains", buffers.gains, detail::kExactGainSets * stride * kVector)
      .bind("g_rest", buffers.rest, frame.internals.restSets.count() * stride * kVector)
      .bind("g_rootFrames", buffers.rootTransforms,
            kRootTransformSets * guides * sizeof(RootTransform))
      .bind("g_strands", buffers.strands, guides * sizeof(ExactStrand))
      .bind("g_exactColliders", buffers.colliders, bytesOfBuffer(buffers.colliders))
      .bind("g_contacts", frame.internals.contacts.records(),
            frame.internals.contacts.recordBytes())
      .bind("g_contactWords", frame.internals.contacts.words(),
            frame.internals.contacts.wordBytes())
      .bind("g_forces", forcesOf(object), vertices * kVector)
      .bind("g_lodParents", buffers.lodParents, guides * sizeof(uint32_t))
      .bind("g_sleep", buffers.sleep,
            (kSleepHead + 2 * tileCount(guides) + guides) * sizeof(uint32_t));
}

Result<void> Scene::addExactPasses(Frame& frame) {
  const SimulationSettings& s = frame.settings;
  HairObject& object = frame.object;
  detail::HairInternals& internals = frame.internals;
  const HairBuffers& buffers = object.buffers_;
  const uint32_t steps = frame.steps * s.subSteps;
  const double h = static_cast<double>(frame.length) / steps;

  ExactConstants constants = frame.exactConstants();
  constants.frameTime = frame.length;
  constants.frameTimeBefore =
      frame.reset || !(internals.lastFrame > 0) ? frame.length : internals.lastFrame;

  constants.parameterSet = internals.restSets.factors ? internals.restSets.count() - 1 : 0;
  constants.restSpeed = s.sleep.speed;
  constants.restTime = s.sleep.time;
  constants.wakeDistance = s.sleep.wakeDistance;
  constants.slotsBack = (4 - steps % 4) % 4;
  const uint32_t countBefore = internals.simulatedCount;
  setLevelOfDetail(frame, constants);
  if (Result<void> added = addSleepPass(frame, constants); !added) return added;
  if (countBefore > 0 && internals.simulatedCount > countBefore && !frame.reset) {
    ExactConstants restart = constants;
    restart.flags = kExactRestart;
    restart.restartFrom = countBefore;
    restart.slot = internals.slot;
    const Result<void> added =
        addInterpolationPass(frame, restart, internals.simulatedCount - countBefore);
    if (!added) return added;
  }

  SimulateRodsKey key;
  key.globalShape = internals.restSets.goals;
  key.forces = forcesOf(object) != BufferId::kInvalid;
  key.contacts = frame.contacts;
  key.velocityShockPropagation = usesVsp(s);
  const KernelVariant& variant = *simulateRodsVariant(completeKey(key));
  if (frame.reset) internals.history = {};
  const detail::HairContacts& contacts = internals.contacts;
  constants.contactList = contacts.list();
  constants.contactMasks = contacts.masks();
  constants.contactMaskWords = contacts.maskWords();

  for (uint32_t step = 0; step < steps; ++step) {
    if (step % s.subSteps == 0) {
      const Result<void> added =
          addHairGridPasses(object, h * s.subSteps, step == 0 && frame.reset, frame.list);
      if (!added) return added;
    }
    detail::setExactStep(constants, s, h, internals.history, frame.air);
    constants.rootBegin = static_cast<float>(step) / static_cast<float>(steps);
    constants.rootEnd = static_cast<float>(step + 1) / static_cast<float>(steps);
    constants.flags = step + 1 == steps ? kExactLast : 0;
    if (frame.sleeps) constants.flags |= kExactSleep;
    if (constants.turnRatio != 1) constants.flags |= kExactChanged;
    if (step == 0 && frame.reset) constants.flags |= kExactReset;
    if (step == 0 && !isZero(frame.rebase)) constants.flags |= kExactRebase;
    constants.slot = internals.slot;
    internals.slot = (internals.slot + 1) % 4;
    constants.contactHead = contacts.head(step);
    PassBuilder builder(frame.list);
    const auto solve = [&](const ExactConstants& values) {
      const uint32_t count = internals.simulatedCount;
      if (frame.sleeps)
        builder.dispatchIndirect(variant, buffers.sleep);
      else
        builder.dispatch(variant, std::min(count, kExactRow), (count + kExactRow - 1) / kExactRow);
      return finishExactPass(frame, builder, values);
    };
    if (frame.contacts && step == 0 && frame.reset) {
      // The positions are those of the frame before.
      ExactConstants pose = constants;
      pose.flags |= kExactPose;
      if (Result<void> added = solve(pose); !added) return added;
    }
    if (frame.contacts) {
      if (Result<void> found = addContactPass(frame, step, steps, false); !found) return found;
    }
    if (Result<void> added = solve(constants); !added) return added;
    if (!frame.contacts) continue;
    // Where a vertex ended far from where its contact was found.
    if (Result<void> found = addContactPass(frame, step, steps, true); !found) return found;
    ExactConstants again = constants;
    again.flags = (constants.flags & ~(kExactReset | kExactRebase)) | kExactAgain;
    builder.dispatchIndirect(variant, contacts.words(), contacts.solveArguments(step));
    if (Result<void> added = finishExactPass(frame, builder, again); !added) return added;
  }
  if (constants.fadeStart == object.guideCount_) return {};
  constants.flags = 0;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.slot = internals.slot;
  return addInterpolationPass(frame, constants, object.guideCount_ - constants.fadeStart);
}

Result<void> Scene::finishExactPass(const Frame& frame, PassBuilder& builder,
                                    const ExactConstants& constants) const {
  bindExact(frame, builder);
  builder.constants("ExactConstants", constants)
      .bytes(uint64_t{frame.internals.simulatedCount} * frame.object.vertexCount_ *
             detail::kExactBytesAVertex);
  return builder.finish();
}

// How many guides are simulated in this frame, and from which one on they fade.
void Scene::setLevelOfDetail(const Frame& frame, ExactConstants& constants) {
  const HairObject& object = frame.object;
  detail::HairInternals& internals = frame.internals;
  const uint32_t guides = object.guideCount_;
  const float share = object.simulatedShare;
  const auto wanted =
      std::clamp(static_cast<uint32_t>(std::ceil(static_cast<double>(share) * guides)), 1u, guides);
  const auto most = static_cast<uint32_t>(
      std::ceil(guides * static_cast<double>(frame.length) / kLevelOfDetailSeconds));
  uint32_t& count = internals.simulatedCount;
  if (count == 0 || frame.reset)
    count = wanted;
  else if (wanted < count)
    count -= std::min(count - wanted, most);
  else if (isZero(frame.rebase))  // new states are relative to the new origin already
    count += std::min(wanted - count, most);
  constants.simulatedCount = count;
  constants.fadeStart = count - fadingGuides(guides, count);
}

Result<void> Scene::addInterpolationPass(const Frame& frame, const ExactConstants& constants,
                                         uint32_t strands) {
  PassBuilder builder(frame.list);
  builder.dispatch(interpolateGuidesVariant({}), strands);
  bindExact(frame, builder);
  builder.constants("ExactConstants", constants)
      .bytes(uint64_t{strands} * frame.object.vertexCount_ * 5 * kVector);
  return builder.finish();
}

}  // namespace pelage
