#include "contact/hair_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <vector>

#include "passes/upload_memory.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage {
namespace {

using namespace contact_records;

static_assert(sizeof(ContactRecord) == kContactElements * sizeof(Uint4));
static_assert(sizeof(Collider) == contact::kColliderElements * sizeof(Uint4));
static_assert(sizeof(Sdf) == sizeof(Collider), "both are elements of one buffer");

// Vertices this near to a surface have a record [m]; falling hair reaches further.
constexpr float kRange = 3e-3f;
// Falls longer than this are part of a vertex's predicted position; for shorter ones the planes at
// the unpredicted position are better [m].
constexpr float kLeap = 0.01f;
// Corners of the needle that draws a record.
constexpr uint32_t kNeedleCorners = 3;

// Depth of the deepest record of a vertex.
float deepestOf(const ContactRecord* records, const Float3& point) {
  float deepest = 0;
  for (uint32_t k = 0; k < kMaxContacts; ++k) {
    const ContactRecord& r = records[k];
    const float distance = r.plane.w + r.plane.x * (point.x - r.foundX) +
                           r.plane.y * (point.y - r.foundY) + r.plane.z * (point.z - r.foundZ);
    if (!std::isfinite(distance)) return std::numeric_limits<float>::infinity();
    deepest = std::max(deepest, -distance);
    if ((r.bits & kContactMore) == 0) break;
  }
  return deepest;
}

template <class T>
std::vector<T> copied(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

}  // namespace

ContactCounters readContactCounters(std::span<const std::byte> words) {
  uint32_t totals[kContactTotalWords] = {};
  const size_t bytes = std::min(words.size(), sizeof(totals));
  std::copy_n(words.begin(), bytes, std::as_writable_bytes(std::span(totals)).begin());
  return {.records = totals[kContactCount], .strandsSolvedAgain = totals[kContactAgain]};
}

namespace detail {

uint32_t ContactLayout::head(uint32_t step) const {
  return kContactTotalWords + step * kContactHeadWords;
}

uint32_t ContactLayout::groupVertices() const {
  return std::min(verticesPerStrand, contact::kMaskVertices);
}

uint32_t ContactLayout::groupStrands() const {
  return verticesPerStrand == 0
             ? contact::kListedStrands
             : std::min(contact::kGroupThreads / groupVertices(), contact::kTileStrands);
}

uint32_t ContactLayout::tileGroups() const {
  return (contact::kTileStrands + groupStrands() - 1) / groupStrands();
}

// The word where they begin; what draws them binds them from there on.
uint32_t ContactLayout::strands() const {
  const uint64_t end = uint64_t{masks()} +
                       uint64_t{strandCount} * (maskWords + kContactListCount * kContactListWords);
  return static_cast<uint32_t>((end + kContactAlignment - 1) / kContactAlignment *
                               kContactAlignment);
}

uint64_t ContactLayout::recordBufferBytes() const {
  const uint64_t before = (vertices + 2 * uint64_t{strandCount}) * sizeof(Float4);
  // Vertices 0 and 1 have no contacts.
  const uint32_t sets = verticesPerStrand > kMatrixContacts + 2 ? kScratchSweepSets : kScratchSets;
  return recordBytes() + before + uint64_t{sets} * stateStride * sizeof(Uint4);
}

void HairContacts::prepare(ResourceTable& resources, const std::string& name,
                           const ContactStrands& strands, uint32_t verticesPerStrand,
                           uint64_t vertices, uint32_t steps) {
  layout_.strandCount = static_cast<uint32_t>(strands.strands.size());
  layout_.stateStride = strands.stateStride;
  layout_.maskWords = (verticesPerStrand + contact::kMaskVertices - 1) / contact::kMaskVertices;
  layout_.verticesPerStrand = verticesPerStrand;
  layout_.vertices = vertices;
  layout_.steps = steps;
  auto targets = std::make_shared<std::vector<uint32_t>>();
  for (const ContactStrand& strand : strands.strands) targets->push_back(strand.target);
  targets_ = std::move(targets);
  const auto add = [&](const char* what, uint64_t bytes, uint32_t stride, BufferUsage usage,
                       HostArray<std::byte> initial = {}) {
    return resources.add({.name = name + "/" + what,
                          .size = bytes,
                          .stride = stride,
                          .usage = usage,
                          .initial = std::move(initial)});
  };
  records_ = add("contacts", layout_.recordBufferBytes(), sizeof(ContactRecord),
                 BufferUsage::kStorage | BufferUsage::kReadback);
  HostArray<std::byte> initial(layout_.wordBytes());
  std::memcpy(initial.data() + layout_.strands() * sizeof(uint32_t), strands.strands.data(),
              layout_.strandBytes());
  words_ = add("contactWords", layout_.wordBytes(), sizeof(uint32_t),
               BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
                   BufferUsage::kReadback,
               std::move(initial));
  known_ = false;
}

std::vector<MovedElements> HairContacts::moved() const {
  using namespace move_rigidly;
  if (!known_ || records_ == BufferId::kInvalid) return {};
  const uint64_t before = layout_.recordBytes() / sizeof(Float4);
  // Records, the positions before the last sub-step, and the displacements of the roots.
  return {
      {records_, 0, before, 1, {kMovesDirection, kMovesDirection, kMovesDirection, kMovesPoint}},
      {records_, before, layout_.vertices, 1, {kMovesPoint}, true},
      {records_,
       before + layout_.vertices,
       2 * uint64_t{layout_.strandCount},
       1,
       {kMovesDirection}}};
}

void HairContacts::clearTotals(PassList& list) {
  if (!counted_ || words_ == BufferId::kInvalid) return;
  const uint32_t zeros[kContactTotalWords] = {};
  addUpload(list, words_, std::as_bytes(std::span(zeros)));
  counted_ = false;
}

void HairContacts::begin(PassList& list) {
  counted_ = true;
  const std::span<uint32_t> heads = uploadOf<uint32_t>(
      list, words_, kContactTotalWords + size_t{layout_.steps} * kContactHeadWords);
  for (uint32_t step = 0; step < layout_.steps; ++step) {
    uint32_t* head = heads.data() + layout_.head(step);
    head[kContactFindArguments + 1] = layout_.maskWords;
    head[kContactStrandArguments + 1] = head[kContactSolveArguments + 1] = 1;
    head[kContactGroupArguments + 1] = 1;
  }
}

ContactConstants HairContacts::constantsOf(const ContactHair& hair,
                                           const ColliderBuffers& colliders,
                                           const AwakeTiles& awake, const ContactStep& step) const {
  ContactConstants constants = {};
  const Float3 origin = hair.origin.world();
  constants.contactOrigin = {origin.x, origin.y, origin.z, 0};
  constants.contactStride = layout_.stateStride;
  constants.contactStrandCount = hair.strands;
  constants.contactRootCount = hair.rootCount;
  constants.contactVertexCount = static_cast<uint32_t>(layout_.vertices);
  constants.contactMaskWords = layout_.maskWords;
  constants.capsuleCount = colliders.capsuleCount;
  constants.contactSdfCount = colliders.contactSdfCount;
  constants.contactHead = layout_.head(step.index);
  constants.contactList = layout_.list();
  constants.contactMasks = layout_.masks();
  constants.contactBefore = static_cast<uint32_t>(layout_.recordBytes() / sizeof(Uint4));
  constants.contactStrands = layout_.strands();
  constants.tileList = awake.firstWord;
  constants.contactFlags = (step.again ? contact::kAgainFlag : 0) |
                           (known_ || step.again ? 0 : contact::kNoHistoryFlag) |
                           (awake.listed && !step.again ? contact::kListedFlag : 0);
  if (odd_) constants.contactFlags |= contact::kOddFlag;
  if (step.fast) constants.contactFlags |= contact::kFastFlag;
  if (colliders.hasMovingSdfs) constants.contactFlags |= contact::kMovingFlag;
  constants.contactStrandTotal = layout_.strandCount;
  constants.contactTileCount = layout_.tiles();
  constants.contactBegin = step.begin;
  constants.contactEnd = step.end;
  constants.contactRatio = lastLength_ > 0 ? step.length / lastLength_ : 1;
  const float squared = step.length * step.length;
  const Float3 fall = {step.gravity.x * squared, step.gravity.y * squared,
                       step.gravity.z * squared};
  const float height = std::hypot(fall.x, fall.y, fall.z);
  constants.contactRange = kRange + height + step.furtherRange;
  constants.contactGroupVertices = layout_.groupVertices();
  constants.contactGroupStrands = layout_.groupStrands();
  constants.contactTileGroups = layout_.tileGroups();
  if (height > kLeap) constants.contactFall = {fall.x, fall.y, fall.z, 0};
  return constants;
}

Result<void> HairContacts::find(PassList& list, const ResourceTable& resources,
                                const ContactHair& hair, const ColliderBuffers& colliders,
                                const AwakeTiles& awake, const ContactStep& step) {
  foundStrands_ = hair.strands;
  origin_ = hair.origin;
  const ContactConstants constants = constantsOf(hair, colliders, awake, step);
  const KernelVariant& variant = *findContactsVariant(
      {.sdf = colliders.contactSdfCount > 0, .denseSdf = colliders.hasDenseSdfs});
  PassBuilder builder(list);
  if (step.again)
    builder.dispatchIndirect(variant, words_, layout_.head(step.index) * sizeof(uint32_t));
  else if (awake.listed)
    builder.dispatchIndirect(variant, awake.buffer, awake.argumentBytes);
  else
    builder.dispatch(
        variant, std::min(layout_.tiles(), dispatch::kRowGroups) * kFindContactsGroupSize.x,
        layout_.rows() * ((layout_.tiles() + dispatch::kRowGroups - 1) / dispatch::kRowGroups));
  builder.bytes(layout_.vertices * 3 * sizeof(Float4));
  if (!step.again) {
    odd_ = !odd_;
    known_ = true;
    lastLength_ = step.length;
  }
  return builder.finish(ContactBindings{
      .contactConstants = constants,
      .contactPositions = {hair.positions, layout_.vertices * sizeof(Float4)},
      .awakeTiles = resources.whole(awake.buffer),
      .contactRoots = hair.roots,
      .capsules = resources.whole(colliders.capsules),
      .contactColliders = resources.whole(colliders.sdfs),
      .contactSdfKeys = resources.whole(colliders.contactSdfKeys),
      .contactSdfSurface = resources.whole(colliders.contactSdfSurface),
      .contacts = {records_, layout_.recordBufferBytes()},
      .contactWords = {words_, layout_.wordBytes()},
  });
}

Result<void> HairContacts::addDraw(PassList& list, BufferId positions, const View& view,
                                   const ContactLook& look) const {
  if (!known_ || records_ == BufferId::kInvalid) return {};
  DrawContactsConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.contactsToClip));
  const Float3 origin = origin_.world();
  constants.drawnOrigin = {origin.x, origin.y, origin.z, 0};
  constants.drawnPixels = {static_cast<float>(view.width), static_cast<float>(view.height)};
  constants.drawnStrandCount = foundStrands_;
  constants.drawnVertexCount = static_cast<uint32_t>(layout_.vertices);
  constants.drawnMasks = layout_.masks();
  constants.drawnMaskWords = layout_.maskWords;
  constants.needleLength = look.length;
  constants.needleWidth = look.width;
  constants.deepestDepth = look.deepestDepth;
  DrawState state;
  state.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  const uint32_t records = layout_.verticesPerStrand * kMaxContacts;
  PassBuilder pass(list);
  return pass
      .draw(contactVertexVariant({}), contactPixelVariant({}), state, records * kNeedleCorners,
            foundStrands_)
      .bytes(uint64_t{foundStrands_} * layout_.maskWords * sizeof(uint32_t))
      .finish(DrawContactsBindings{
          .drawContactsConstants = constants,
          .drawnPositions = {positions, layout_.vertices * sizeof(Float4)},
          .drawnContacts = {records_, layout_.recordBytes()},
          .drawnWords = {words_, layout_.wordBytes()},
          .drawnStrands = {words_, layout_.strandBytes(), layout_.strands() * sizeof(uint32_t)},
      });
}

Result<float> HairContacts::deepest(std::span<const std::byte> records,
                                    std::span<const std::byte> words,
                                    std::span<const std::byte> positions) const {
  if (!known_ || records_ == BufferId::kInvalid) return 0.0f;
  if (records.size() < layout_.recordBytes() || words.size() != layout_.wordBytes() ||
      positions.size() < layout_.vertices * sizeof(Float4)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("deepestContact(): contacts, words and positions have {}, {} and {} "
                             "bytes; the object's have at least {}, {} and at least {}",
                             records.size(), words.size(), positions.size(), layout_.recordBytes(),
                             layout_.wordBytes(), layout_.vertices * sizeof(Float4))};
  }
  const auto found = copied<ContactRecord>(records);
  const auto masks = copied<uint32_t>(words.subspan(layout_.masks() * sizeof(uint32_t)));
  const auto points = copied<Float4>(positions);
  float deepest = 0;
  for (size_t strand = 0; strand < foundStrands_; ++strand) {
    for (size_t vertex = 0; vertex < layout_.verticesPerStrand; ++vertex) {
      const uint32_t mask = masks[strand * layout_.maskWords + vertex / contact::kMaskVertices];
      if (((mask >> (vertex % contact::kMaskVertices)) & 1) == 0) continue;
      const size_t element = (*targets_)[strand] + vertex;
      const Float4& p = points[element];
      deepest = std::max(
          deepest, deepestOf(&found[element * kMaxContacts], origin_.relative({p.x, p.y, p.z})));
    }
  }
  return deepest;
}

}  // namespace detail
}  // namespace pelage
