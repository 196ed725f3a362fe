#include "contact/hair_contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <vector>

#include "pelage/kernels.h"

namespace pelage {
namespace {

// As in kernels/layouts/contact_records.hlsli and contact.hlsli.
constexpr uint32_t kTotalWords = 4, kHeadWords = 8, kFindArguments = 0, kSolveArguments = 3;
constexpr uint32_t kListed = 1, kAgain = 2, kNoHistory = 4, kOdd = 8;
constexpr uint32_t kTileStrands = 32, kMaskBits = 32, kTilesARow = 32768;
// What is this near to a surface has a record [m]; or as near as it falls further in a sub-step.
constexpr float kReach = 1e-3f;
// Falls from this on are part of where a vertex is expected, though the planes at shorter ones are
// better where it is [m].
constexpr float kLeap = 0.01f;
constexpr uint32_t kMore = 0x80000u;
// Corners of what is drawn of a record.
constexpr uint32_t kNeedleCorners = 3;

// Of a vertex that has records.
float deepestOf(const ContactRecord* records, const Float3& place) {
  float deepest = 0;
  for (uint32_t k = 0; k < detail::HairContacts::kMaxContacts; ++k) {
    const ContactRecord& r = records[k];
    const float distance = r.plane.w + r.plane.x * (place.x - r.foundX) +
                           r.plane.y * (place.y - r.foundY) + r.plane.z * (place.z - r.foundZ);
    if (!std::isfinite(distance)) return std::numeric_limits<float>::infinity();
    deepest = std::max(deepest, -distance);
    if ((r.bits & kMore) == 0) break;
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
  uint32_t head[3] = {};
  const size_t bytes = std::min(words.size(), sizeof(head));
  std::copy_n(words.begin(), bytes, std::as_writable_bytes(std::span(head)).begin());
  return {.records = head[0], .furtherPasses = head[1], .tilesSolvedAgain = head[2]};
}

namespace detail {

uint32_t HairContacts::head(uint32_t step) const { return kTotalWords + step * kHeadWords; }

uint64_t HairContacts::wordBytes() const {
  return (uint64_t{masks()} + uint64_t{strandCount_} * maskWords_) * sizeof(uint32_t);
}

uint64_t HairContacts::solveArguments(uint32_t step) const {
  return (uint64_t{head(step)} + kSolveArguments) * sizeof(uint32_t);
}

void HairContacts::prepare(ResourceTable& resources, const std::string& name,
                           std::span<const ContactStrand> strands, uint32_t verticesPerStrand,
                           uint64_t vertices, uint32_t steps) {
  strandCount_ = static_cast<uint32_t>(strands.size());
  tiles_ = (strandCount_ + kTileStrands - 1) / kTileStrands;
  maskWords_ = (verticesPerStrand + kMaskBits - 1) / kMaskBits;
  verticesPerStrand_ = verticesPerStrand;
  vertices_ = vertices;
  steps_ = steps;
  auto targets = std::make_shared<std::vector<uint32_t>>();
  for (const ContactStrand& strand : strands) targets->push_back(strand.target);
  targets_ = std::move(targets);
  const auto add = [&](const char* what, uint64_t bytes, uint32_t stride, BufferUsage usage,
                       std::vector<std::byte> initial = {}) {
    return resources.add({.name = name + "/" + what,
                          .size = bytes,
                          .stride = stride,
                          .usage = usage,
                          .initial = std::move(initial)});
  };
  const auto bytes = std::as_bytes(strands);
  strands_ = add("contactStrands", bytes.size(), sizeof(ContactStrand), BufferUsage::kStorage,
                 {bytes.begin(), bytes.end()});
  before_ = add("contactBefore", beforeBytes(), sizeof(Float4), BufferUsage::kStorage);
  records_ = add("contacts", recordBytes(), sizeof(ContactRecord),
                 BufferUsage::kStorage | BufferUsage::kReadback);
  words_ = add("contactWords", wordBytes(), sizeof(uint32_t),
               BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
                   BufferUsage::kReadback);
  known_ = false;
}

void HairContacts::clearTotals(PassList& list) {
  if (!counted_ || words_ == BufferId::kInvalid) return;
  const uint32_t zeros[kTotalWords] = {};
  addUpload(list, words_, std::as_bytes(std::span(zeros)));
  counted_ = false;
}

void HairContacts::begin(PassList& list) {
  counted_ = true;
  std::vector<uint32_t> heads(kTotalWords + steps_ * kHeadWords);
  for (uint32_t step = 0; step < steps_; ++step) {
    uint32_t* head = heads.data() + this->head(step);
    head[kFindArguments + 1] = rows();
    head[kFindArguments + 2] = head[kSolveArguments + 1] = head[kSolveArguments + 2] = 1;
  }
  addUpload(list, words_, std::as_bytes(std::span(heads)));
}

Result<void> HairContacts::find(PassList& list, const ResourceTable& resources,
                                const ContactHair& hair, const ColliderBuffers& colliders,
                                const AwakeTiles& awake, const ContactStep& step) {
  foundStrands_ = hair.strands;
  origin_ = hair.origin;
  ContactConstants constants = {};
  const Float3 origin = hair.origin.world();
  constants.contactOrigin = {origin.x, origin.y, origin.z, 0};
  constants.contactStrandCount = hair.strands;
  constants.contactRootCount = hair.rootCount;
  constants.contactVertexCount = static_cast<uint32_t>(vertices_);
  constants.contactMaskWords = maskWords_;
  constants.capsuleCount = colliders.capsuleCount;
  constants.fieldCount = colliders.fieldCount;
  constants.contactHead = head(step.index);
  constants.contactList = this->list();
  constants.contactMasks = masks();
  constants.tileList = awake.firstWord;
  constants.contactFlags = (step.again ? kAgain : 0) | (known_ || step.again ? 0 : kNoHistory) |
                           (awake.listed && !step.again ? kListed : 0);
  if (odd_) constants.contactFlags |= kOdd;
  constants.contactStrandTotal = strandCount_;
  constants.contactTileCount = tiles_;
  constants.contactBegin = step.begin;
  constants.contactEnd = step.end;
  constants.contactRatio = lastLength_ > 0 ? step.length / lastLength_ : 1;
  const float squared = step.length * step.length;
  const Float3 fall = {step.gravity.x * squared, step.gravity.y * squared,
                       step.gravity.z * squared};
  const float height = std::hypot(fall.x, fall.y, fall.z);
  constants.contactReach = kReach + height + step.furtherReach;
  if (height > kLeap) constants.contactFall = {fall.x, fall.y, fall.z, 0};
  const auto sizeOf = [&](BufferId id) {
    const BufferDesc* desc = resources.find(id);
    return desc == nullptr ? 0 : desc->size;
  };
  const KernelVariant& variant = findContactsVariant({.sdf = colliders.fieldCount > 0});
  PassBuilder builder(list);
  if (step.again)
    builder.dispatchIndirect(variant, words_, head(step.index) * sizeof(uint32_t));
  else if (awake.listed)
    builder.dispatchIndirect(variant, awake.buffer, awake.argumentBytes);
  else
    builder.dispatch(variant, std::min(tiles_, kTilesARow) * variant.groupSize[0],
                     rows() * ((tiles_ + kTilesARow - 1) / kTilesARow) * variant.groupSize[1]);
  builder.bind("g_contactPositions", hair.positions, vertices_ * sizeof(Float4))
      .bind("g_contactBefore", before_, beforeBytes())
      .bind("g_contacts", records_, recordBytes())
      .bind("g_contactWords", words_, wordBytes())
      .bind("g_contactStrands", strands_, strandCount_ * sizeof(ContactStrand))
      .bind("g_contactRoots", hair.roots, sizeOf(hair.roots))
      .bind("g_awakeTiles", awake.buffer, sizeOf(awake.buffer))
      .bind("g_capsules", colliders.capsules, sizeOf(colliders.capsules))
      .bind("g_fields", colliders.fields, colliders.fieldCount * sizeof(SdfField))
      .bind("g_fieldKeys", colliders.fieldKeys, sizeOf(colliders.fieldKeys))
      .bind("g_fieldSurface", colliders.fieldSurface, sizeOf(colliders.fieldSurface))
      .constants("ContactConstants", constants)
      .bytes(vertices_ * 3 * sizeof(Float4));
  if (!step.again) {
    odd_ = !odd_;
    known_ = true;
    lastLength_ = step.length;
  }
  return builder.finish();
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
  constants.drawnVertexCount = static_cast<uint32_t>(vertices_);
  constants.drawnMasks = masks();
  constants.drawnMaskWords = maskWords_;
  constants.needleLength = look.length;
  constants.needleWidth = look.width;
  constants.deepestDepth = look.deepestDepth;
  DrawState state;
  state.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  const uint32_t records = verticesPerStrand_ * static_cast<uint32_t>(kMaxContacts);
  PassBuilder pass(list);
  return pass
      .draw(contactVertexVariant({}), contactPixelVariant({}), state, records * kNeedleCorners,
            foundStrands_)
      .bind("g_drawnPositions", positions, vertices_ * sizeof(Float4))
      .bind("g_drawnContacts", records_, recordBytes())
      .bind("g_drawnWords", words_, wordBytes())
      .bind("g_drawnStrands", strands_, strandCount_ * sizeof(ContactStrand))
      .constants("DrawContactsConstants", constants)
      .bytes(uint64_t{foundStrands_} * maskWords_ * sizeof(uint32_t))
      .finish();
}

Result<float> HairContacts::deepest(std::span<const std::byte> records,
                                    std::span<const std::byte> words,
                                    std::span<const std::byte> positions) const {
  if (!known_ || records_ == BufferId::kInvalid) return 0.0f;
  if (records.size() != recordBytes() || words.size() != wordBytes() ||
      positions.size() < vertices_ * sizeof(Float4)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("deepestContact(): contacts, words and positions have {}, {} and {} "
                             "bytes; the object's have {}, {} and at least {}",
                             records.size(), words.size(), positions.size(), recordBytes(),
                             wordBytes(), vertices_ * sizeof(Float4))};
  }
  const auto found = copied<ContactRecord>(records);
  const auto masks = copied<uint32_t>(words.subspan(this->masks() * sizeof(uint32_t)));
  const auto places = copied<Float4>(positions);
  float deepest = 0;
  for (size_t strand = 0; strand < foundStrands_; ++strand) {
    for (size_t vertex = 0; vertex < verticesPerStrand_; ++vertex) {
      const uint32_t mask = masks[strand * maskWords_ + vertex / kMaskBits];
      if (((mask >> (vertex % kMaskBits)) & 1) == 0) continue;
      const size_t element = (*targets_)[strand] + vertex;
      const Float4& p = places[element];
      deepest = std::max(
          deepest, deepestOf(&found[element * kMaxContacts], origin_.relative({p.x, p.y, p.z})));
    }
  }
  return deepest;
}

}  // namespace detail
}  // namespace pelage
