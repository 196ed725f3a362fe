#include "contact/hair_colliders.h"

#include <algorithm>
#include <cmath>

#include "contact/capsules.h"
#include "passes/upload_memory.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"

namespace pelage::detail {

namespace {

// Where g_sleep has the groups of find_contacts [bytes].
constexpr uint64_t kFindArguments = exact::kSleepFindArguments * sizeof(uint32_t);

bool isExact(const HairFrame& frame) { return frame.settings.solver == Solver::kExact; }

}  // namespace

void HairColliders::prepare(HairFrame& frame) {
  if (frame.otherSolver) {
    contacts_.remove(frame.factory);
    frame.buffers.contacts = frame.buffers.contactWords = BufferId::kInvalid;
  }
  frame.contacts = inputs();
}

ContactInputs HairColliders::inputs() const {
  const ContactLayout& layout = contacts_.layout();
  return {.any = false,
          .replaced = false,
          .capsuleCount = 0,
          .records = {contacts_.records(), layout.recordBufferBytes()},
          .recordBytes = layout.recordBytes(),
          .words = {contacts_.words(), layout.wordBytes()},
          .firstHead = layout.head(0),
          .headWords = layout.head(1) - layout.head(0),
          .list = layout.list(),
          .masks = layout.masks(),
          .maskWords = layout.maskWords,
          .rows = layout.rows()};
}

uint32_t HairColliders::subSteps(const HairInputs& inputs,
                                 std::span<const AffineTransform> bonesBefore,
                                 const SimulationSettings& settings, const Ball& ball,
                                 const SdfRoom* sdfs, uint32_t steps) const {
  if (settings.maxSubSteps <= settings.subSteps || bonesBefore.size() != inputs.bones.size())
    return settings.subSteps;
  const Float3 middle = middleOf(inputs.bounds, inputs.bones);
  const Float3 from = middleOf(inputs.bounds, bonesBefore);
  const BoneMoves moves = {.middle = {middle.x - from.x, middle.y - from.y, middle.z - from.z},
                           .before = bonesBefore,
                           .now = inputs.bones};
  // Ways in radii and cells. What is no longer than these in a frame needs no more sub-steps.
  const uint32_t parts = steps * settings.subSteps;
  const double slowRadii = parts * 2.0 / 3, slowCells = parts * 1.5;
  const auto needs = [](double way, double slow) { return way > slow ? way / 0.5 : 0.0; };
  double needed =
      needs(wayInRadii(inputs.colliders, capsulesBefore_, ball, moves, slowRadii), slowRadii);
  if (sdfs != nullptr) {
    const HairReach reach = {ball, inputs.meshColliders ? &*inputs.meshColliders : nullptr};
    needed = std::max(needed, needs(sdfs->wayInCells(reach, moves, slowCells), slowCells));
  }
  needed = std::ceil(needed / steps);
  // Also for NaN.
  if (!(needed > settings.subSteps)) return settings.subSteps;
  return static_cast<uint32_t>(std::min(needed, static_cast<double>(settings.maxSubSteps)));
}

void HairColliders::record(HairFrame& frame, SdfRoom& sdfs, const Ball& ball,
                           const Strands& strands) {
  bool replaced = areReplaced(capsulesBefore_, frame.inputs.colliders);
  replaced |= sendSdfs(frame, sdfs, ball);
  replaced |= sendCapsules(frame, ball);
  beginContacts(frame, strands);
  frame.contacts.replaced = replaced;
  frame.contacts.capsuleCount = inReach_.capsuleCount;
}

// Returns whether they are others than in the frame before.
bool HairColliders::sendSdfs(HairFrame& frame, SdfRoom& sdfs, const Ball& ball) {
  const HairInputs& inputs = frame.inputs;
  const HairReach reach = {ball, inputs.meshColliders ? &*inputs.meshColliders : nullptr};
  const SdfRoom::InReach& found =
      sdfs.inReach(frame.usesMeshColliders ? &reach : nullptr, frame.origin);
  const auto bytes = std::as_bytes(std::span(found.sdfs));
  const auto isSent = [&] { return std::ranges::equal(bytes, sdfsBefore_); };
  const auto count = static_cast<uint32_t>(found.sdfs.size());
  const bool replaced = found.rebuilt || !isSent();
  // Capsules come behind the SDFs.
  const uint32_t wanted = count > 0 ? count + static_cast<uint32_t>(inputs.colliders.size()) : 0;
  if (wanted > sdfCapacity_) {
    frame.factory.remove(frame.buffers.sdfs);
    sdfCapacity_ = wanted;
    frame.buffers.sdfs = frame.factory.add(frame.name + "/fields", wanted, sizeof(Sdf), {},
                                           BufferUsage::kStorage | BufferUsage::kUpload);
    sdfsBefore_.clear();
  }
  if (!bytes.empty() && !isSent()) addUpload(frame.list, frame.buffers.sdfs, bytes);
  sdfsBefore_.assign(bytes.begin(), bytes.end());
  inReach_.sdfs = frame.buffers.sdfs;
  inReach_.contactSdfCount = count;
  inReach_.hasDenseSdfs = found.dense;
  inReach_.hasMovingSdfs =
      std::ranges::any_of(found.sdfs, [](const Sdf& sdf) { return sdf.motionScale > 0; });
  inReach_.contactSdfKeys = sdfs.keys;
  inReach_.contactSdfSurface = sdfs.surface;
  return replaced;
}

// Returns whether sleeping strands, which are not tested against capsules, have to wake.
bool HairColliders::sendCapsules(HairFrame& frame, const Ball& ball) {
  const HostArray<CapsuleCollider>& capsules = frame.inputs.colliders;
  if (rounded_ > 0) settleCapsules(capsulesBefore_, capsules, rounded_);
  rounded_ = 0;
  const bool wakes = frame.groom.collidesFollowHairs && capsules != capsulesBefore_;
  const auto pack = [&](std::span<Collider> packed) {
    return packCapsules(capsules, capsulesBefore_, frame.origin, ball, frame.length, packed);
  };
  const auto count = static_cast<uint32_t>(pack({}));
  // SDF permutations bind the capsule buffer, too.
  const uint32_t wanted = std::max(count, inReach_.contactSdfCount > 0 ? 1u : 0u);
  if (wanted > capsuleCapacity_) {
    frame.factory.remove(frame.buffers.colliders);
    capsuleCapacity_ = wanted;
    frame.buffers.colliders = frame.factory.add(frame.name + "/colliders", wanted, sizeof(Collider),
                                                {}, BufferUsage::kStorage | BufferUsage::kUpload);
  }
  pack(uploadOf<Collider>(frame.list, frame.buffers.colliders, count));
  if (const uint64_t sdfs = inReach_.contactSdfCount; sdfs > 0)
    pack(uploadOf<Collider>(frame.list, frame.buffers.sdfs, count, sdfs * sizeof(Sdf)));
  capsulesBefore_ = capsules;
  inReach_.capsules = frame.buffers.colliders;
  inReach_.capsuleCount = count;
  return wakes;
}

void HairColliders::beginContacts(HairFrame& frame, const Strands& strands) {
  const bool exact = isExact(frame);
  const uint32_t subSteps =
      exact ? std::max(frame.settings.subSteps, frame.settings.maxSubSteps) : 1;
  // A reset of the classic solver takes the bind pose, and moves nothing.
  const bool any = (exact || !frame.reset) && inReach_.any();
  if (frame.reset || !any) contacts_.forget();
  if (!any) {
    contacts_.clearTotals(frame.list);
    return;
  }
  if (!contacts_.isPrepared(frame.steps * subSteps)) {
    contacts_.remove(frame.factory);
    contacts_.prepare(frame.factory.resources, frame.name, strands(), frame.vertexCount,
                      frame.guideVertices(), kMaxFrameSteps * subSteps);
    frame.buffers.contacts = contacts_.records();
    frame.buffers.contactWords = contacts_.words();
  }
  contacts_.begin(frame.list);
  frame.contacts = inputs();
  frame.contacts.any = true;
}

Result<void> HairColliders::find(const HairFrame& frame, const ContactPart& part) {
  const HairBuffers& buffers = frame.buffers;
  const auto step = static_cast<float>(part.step), steps = static_cast<float>(part.steps);
  const AwakeTiles awake = {.buffer = isExact(frame) ? buffers.sleep : buffers.state,
                            .listed = frame.sleeps,
                            .firstWord = exact::kSleepHead,
                            .argumentBytes = kFindArguments};
  const ContactStep of = {.index = part.step,
                          .begin = step / steps,
                          .end = static_cast<float>(part.step + 1) / steps,
                          .length = frame.length / steps,
                          .gravity = frame.gravity(),
                          .again = part.again,
                          .fast = frame.hasFastColliders};
  const ContactHair hair = {.positions = buffers.positions,
                            .roots = frame.roots,
                            .rootCount = frame.guideCount,
                            .strands = part.strands,
                            .origin = frame.origin};
  return contacts_.find(frame.list, frame.factory.resources, hair, inReach_, awake, of);
}

void HairColliders::pause(HairFrame& frame) {
  contacts_.forget();
  contacts_.clearTotals(frame.list);
  // Capsules have not moved when the hair collides again.
  capsulesBefore_ = frame.inputs.colliders;
  rounded_ = 0;
}

void HairColliders::move(const WorldMove& move) {
  moveCapsules(capsulesBefore_, move);
  rounded_ += move.extent;
  if (move.origin) contacts_.moveTo(*move.origin);
}

void HairColliders::remove(HairBuffers& buffers, const BufferFactory& factory) {
  contacts_.remove(factory);
  buffers.contacts = buffers.contactWords = BufferId::kInvalid;
  factory.remove(buffers.colliders);
  factory.remove(buffers.sdfs);
}

}  // namespace pelage::detail
