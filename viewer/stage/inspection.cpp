#include "stage/inspection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

#include "pelage/constants.h"
#include "stage/inspection_passes.h"
#include "stage/strand_detail.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using namespace viewer_kernels;
using pelage::BufferId;
using pelage::BufferRange;
using pelage::BufferUsage;
using pelage::CapsuleCollider;
using pelage::Float3;
using pelage::Float4;
using pelage::HairObject;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::ResourceTable;
using pelage::Result;
using pelage::View;

namespace {

constexpr float kStrandPixels = 1.5f;  // width of strands with a value
constexpr float kGuidePixels = 1.2f;   // of guides and follow hairs, which are many
constexpr float kCountedPixels = 1;    // least width of what the transparency methods draw
constexpr uint32_t kCornersOfStrip = 4;
constexpr uint64_t kSummaryBytes = strand_value::kSummaryWords * sizeof(uint32_t);
constexpr uint64_t kSumBytes = overdraw::kOverdrawWords * sizeof(uint32_t);
constexpr int kSliceLines = 4;  // from 0 to the range

const HairObject& objectOf(const Inspected& what, size_t index) {
  return what.scene->hair(what.demo->hairs()[index]);
}

// As many strands as draws of the hair show; guides alone have edges that a solver keeps.
uint32_t posedStrands(const InspectionLook& look, const HairObject& object) {
  if (look.value == InspectedValue::kDetail) return object.strandCount();
  if (look.value == InspectedValue::kStretch) return object.guideCount();
  return std::max(drawnStrandsOf(object).count, 1u);
}

BufferRange wholeOr(const ResourceTable& table, BufferId buffer, const BufferRange& standIn) {
  const BufferRange range = table.whole(buffer);
  return range.isBound() ? range : standIn;
}

pelage::DrawState solid(const View& view) {
  pelage::DrawState state;
  state.topology = pelage::PrimitiveTopology::kTriangleStrip;
  state.depthCompare =
      view.reversedDepth ? pelage::DepthCompare::kGreater : pelage::DepthCompare::kLess;
  return state;
}

std::vector<Float4> packColliders(const Inspected& what, size_t index) {
  std::vector<CapsuleCollider> capsules;
  if (index == 0) capsules = what.demo->capsules(what.seconds);
  capsules.insert(capsules.end(), what.others.begin(), what.others.end());
  std::vector<Float4> packed;
  for (const CapsuleCollider& c : capsules) {
    packed.push_back({c.head.x, c.head.y, c.head.z, c.headRadius});
    packed.push_back({c.tail.x, c.tail.y, c.tail.z, c.tailRadius});
  }
  return packed;
}

std::vector<Float4> packGrids(const Inspected& what) {
  std::vector<Float4> packed;
  for (const pelage::ColliderId id : what.demo->colliders()) {
    const pelage::SdfGrid& grid = what.scene->collider(id).grid();
    packed.push_back({grid.origin.x, grid.origin.y, grid.origin.z, grid.cellSize});
    packed.push_back({std::bit_cast<float>(grid.nodes[0]), std::bit_cast<float>(grid.nodes[1]),
                      std::bit_cast<float>(grid.nodes[2]), 0});
  }
  return packed;
}

// Number of SDFs and capsules that a hair object can reach.
uint32_t slotsOf(const ResourceTable& table, BufferId sdfs) {
  constexpr uint64_t kSlotBytes = pelage::sdf::kSdfElements * sizeof(pelage::Uint4);
  return static_cast<uint32_t>(table.whole(sdfs).size / kSlotBytes);
}

std::vector<uint32_t> wordsOf(const std::vector<std::byte>& bytes) {
  std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(uint32_t));
  return words;
}

}  // namespace

DrawValuesConstants valuesOf(const InspectionLook& look, const View& view, uint32_t vertices) {
  const InspectionKey key = inspectionKey(look, {}, pelage::Transparency::kTiles);
  DrawValuesConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.valuesToClip));
  for (size_t i = 0; i < key.ramp->colors.size(); ++i) {
    const Float3& color = key.ramp->colors[i];
    constants.valueRamp[i] = {color.x, color.y, color.z, 1};
  }
  const auto width = static_cast<float>(view.width), height = static_cast<float>(view.height);
  constants.valueArea = {view.x, view.y, width, height};
  constants.valueLow = lowOf(look);
  constants.valueHigh = highOf(look);
  constants.valueVertexCount = vertices;
  constants.valueAbove = -strand_value::kMostValue;
  const bool many = look.value == InspectedValue::kGuides || look.value == InspectedValue::kDetail;
  constants.valueWidth = many ? kGuidePixels : kStrandPixels;
  const Float4& up = view.worldToClip.rows[1];
  constants.valueFocal = std::hypot(up.x, up.y, up.z) * height / 2;
  return constants;
}

Inspection::Hair& Inspection::hairOf(const Inspected& what, size_t index) {
  const auto [at, isNew] = hairs_.try_emplace(what.demo->hairs()[index]);
  if (!isNew) return at->second;
  const HairObject& object = objectOf(what, index);
  ResourceTable& table = what.scene->resources();
  Hair hair;
  hair.records = table.add(
      {.name = object.name() + "/values",
       .size = uint64_t{object.strandCount()} * object.verticesPerStrand() * sizeof(Float4),
       .stride = sizeof(Float4),
       .usage = BufferUsage::kStorage | BufferUsage::kVertex});
  hair.summary =
      table.add({.name = object.name() + "/summary",
                 .size = kSummaryBytes,
                 .stride = sizeof(uint32_t),
                 .usage = BufferUsage::kStorage | BufferUsage::kUpload | BufferUsage::kReadback});
  const auto lengths = std::as_bytes(std::span(what.demo->restLengths(index)));
  hair.restLengths = table.add({.name = object.name() + "/restLengths",
                                .size = lengths.size(),
                                .stride = sizeof(float),
                                .initial = std::vector<std::byte>(lengths.begin(), lengths.end())});
  return at->second = hair;
}

Result<void> Inspection::pose(const InspectionLook& look, const Inspected& what, size_t index,
                              Hair& hair, PassList& list) {
  const HairObject& object = objectOf(what, index);
  const ResourceTable& table = what.scene->resources();
  const uint32_t vertices = object.verticesPerStrand();
  const BufferRange positions = table.whole(object.buffers().positions);
  hair.posed = posedStrands(look, object);
  const bool stored = positions.size >= uint64_t{object.strandCount()} * vertices * sizeof(Float4);
  StrandPoseConstants constants = {};
  constants.poseVertexCount = vertices;
  constants.poseGuideCount = object.guideCount();
  constants.poseStrandCount = hair.posed;
  constants.poseEvaluatesFollows = stored ? 0 : 1;
  constants.poseTipSeparation = object.settings.tipSeparation;
  const uint32_t zeros[strand_value::kSummaryWords] = {};
  pelage::addUpload(list, hair.summary, std::as_bytes(std::span(zeros)));
  PassBuilder pass(list);
  dispatchOver(pass, poseStrandsVariant({}), uint64_t{hair.posed} * vertices);
  const BufferRange roots = object.rootTransforms();
  return pass.finish(StrandPoseBindings{
      .strandPoseConstants = constants,
      .posePositions = positions,
      .poseFollowHairs = wholeOr(table, object.buffers().followHairRecords, positions),
      .poseRoots = roots.isBound() ? roots : positions,
      .poseRecords = table.whole(hair.records)});
}

// Stretch of guides; for other views the kind of each strand.
Result<void> Inspection::measureStretch(const InspectionLook& look, const Inspected& what,
                                        size_t index, const Hair& hair, PassList& list) {
  const HairObject& object = objectOf(what, index);
  const ResourceTable& table = what.scene->resources();
  const bool kinds = look.value != InspectedValue::kStretch;
  StrandStretchConstants constants = {};
  constants.stretchVertexCount = object.verticesPerStrand();
  constants.stretchVertices =
      std::min(object.guideCount(), hair.posed) * object.verticesPerStrand();
  constants.stretchLimit = look.stretchRange;
  constants.stretchPosed = hair.posed * object.verticesPerStrand();
  PassBuilder pass(list);
  dispatchOver(pass, kinds ? markGuidesVariant({}) : measureStretchVariant({}),
               kinds ? constants.stretchPosed : constants.stretchVertices);
  return pass.finish(StrandStretchBindings{.strandStretchConstants = constants,
                                           .restLengths = table.whole(hair.restLengths),
                                           .stretchRecords = table.whole(hair.records),
                                           .stretchSummary = table.whole(hair.summary)});
}

Result<void> Inspection::measurePenetration(const InspectionLook& look, const Inspected& what,
                                            size_t index, Hair& hair, PassList& list) {
  const HairObject& object = objectOf(what, index);
  ResourceTable& table = what.scene->resources();
  std::vector<Float4> colliders = packColliders(what, index);
  StrandPenetrationConstants constants = {};
  constants.depthVertexCount = object.verticesPerStrand();
  constants.depthVertices = hair.posed * object.verticesPerStrand();
  constants.depthCapsuleCount = static_cast<uint32_t>(colliders.size() / 2);
  constants.depthLimit = look.penetrationRange;
  const BufferRange records = table.whole(hair.records);
  const BufferRange slots = table.whole(object.buffers().sdfs);
  if (slots.isBound()) {
    const std::vector<Float4> grids = packGrids(what);
    constants.depthSlotCount = slotsOf(table, object.buffers().sdfs);
    constants.depthGridCount = static_cast<uint32_t>(grids.size() / 2);
    colliders.insert(colliders.end(), grids.begin(), grids.end());
  }
  if (colliders.empty()) colliders.emplace_back();  // a buffer has a size
  const auto bytes = std::as_bytes(std::span(colliders));
  if (table.whole(hair.colliders).size < bytes.size()) {
    if (hair.colliders != BufferId::kInvalid) table.remove(hair.colliders);
    hair.colliders = table.add({.name = object.name() + "/inspectedColliders",
                                .size = bytes.size(),
                                .stride = sizeof(Float4),
                                .usage = BufferUsage::kStorage | BufferUsage::kUpload});
  }
  pelage::addUpload(list, hair.colliders, bytes);
  PassBuilder pass(list);
  dispatchOver(pass, measurePenetrationVariant({}), constants.depthVertices);
  const BufferRange summary = table.whole(hair.summary);
  const BufferRange standIn = table.whole(hair.restLengths);
  return pass.finish(
      StrandPenetrationBindings{.strandPenetrationConstants = constants,
                                .depthColliders = table.whole(hair.colliders),
                                .depthSlots = slots.isBound() ? slots : standIn,
                                .depthKeys = wholeOr(table, what.scene->sdfKeys(), standIn),
                                .depthRecords = records,
                                .depthSummary = summary});
}

// Dispatches come before draws.
Result<void> Inspection::drawStrands(const InspectionLook& look, const Inspected& what,
                                     const View& view, PassList& list) {
  for (size_t i = 0; i < what.demo->hairs().size(); ++i) {
    Hair& hair = hairOf(what, i);
    Result<void> done = pose(look, what, i, hair, list);
    if (done && look.value == InspectedValue::kPenetration)
      done = measurePenetration(look, what, i, hair, list);
    else if (done && look.value == InspectedValue::kDetail)
      done = markDetail(objectOf(what, i), what.scene->resources(), hair.records, list);
    else if (done)
      done = measureStretch(look, what, i, hair, list);
    if (!done) return done;
  }
  for (size_t i = 0; i < what.demo->hairs().size(); ++i) {
    const HairObject& object = objectOf(what, i);
    const DrawValuesConstants constants = valuesOf(look, view, object.verticesPerStrand());
    const Result<void> done =
        look.value == InspectedValue::kOverdraw
            ? countStrands(what, object, hairOf(what, i), constants, view, list)
            : drawValues(look, object, hairOf(what, i), constants, view, list);
    if (!done) return done;
  }
  return {};
}

Result<void> Inspection::drawValues(const InspectionLook& look, const HairObject& object,
                                    const Hair& hair, DrawValuesConstants constants,
                                    const View& view, PassList& list) {
  pelage::DrawState state = solid(view);
  // Strands that are left out hide none that are drawn.
  state.depthWrite = look.value != InspectedValue::kDetail;
  if (Result<void> done = drawStrands(object, hair, constants, state, list); !done) return done;
  constants.valueAbove = 0;
  state.depthWrite = true;
  if (look.value == InspectedValue::kDetail)
    return drawStrands(object, hair, constants, state, list);
  // What is inside of a collider is behind its surface.
  state.depthCompare = pelage::DepthCompare::kAlways;
  if (look.value == InspectedValue::kPenetration)
    return drawStrands(object, hair, constants, state, list);
  return {};
}

Result<void> Inspection::drawStrands(const HairObject& object, const Hair& hair,
                                     const DrawValuesConstants& constants,
                                     const pelage::DrawState& state, PassList& list) {
  const uint64_t records = uint64_t{hair.posed} * object.verticesPerStrand();
  PassBuilder pass(list);
  pass.draw(valueVertexVariant({}), valuePixelVariant({}), state, kCornersOfStrip,
            static_cast<uint32_t>(records - 1))
      .vertices({hair.records, records * sizeof(Float4)});
  return pass.finish(DrawValuesBindings{.drawValuesConstants = constants});
}

// Strands as wide as the transparency methods draw them.
Result<void> Inspection::countStrands(const Inspected& what, const HairObject& object,
                                      const Hair& hair, DrawValuesConstants constants,
                                      const View& view, PassList& list) const {
  constants.valueWidth = kCountedPixels;
  constants.valueRadius = object.material.fiberRadius / std::max(object.drawnShare, 1e-3f);
  constants.valueTipRatio = object.material.tipRadiusRatio;
  pelage::DrawState state = solid(view);
  state.depthWrite = state.colorWrite = false;
  const ResourceTable& table = what.scene->resources();
  const uint64_t records = uint64_t{hair.posed} * object.verticesPerStrand();
  PassBuilder pass(list);
  pass.draw(valueVertexVariant({}), countPixelVariant({}), state, kCornersOfStrip,
            static_cast<uint32_t>(records - 1))
      .vertices({hair.records, records * sizeof(Float4)});
  return pass.finish(
      DrawValuesBindings{.drawValuesConstants = constants},
      OverdrawBindings{.overdraw = table.whole(counts_), .overdrawSummary = table.whole(sums_)});
}

// Fragments are counted by draws, and the picture is made of the counts behind them.
Result<void> Inspection::drawOverdraw(const InspectionLook& look, const Inspected& what,
                                      const View& view, pelage::Frame& frame) {
  ResourceTable& table = what.scene->resources();
  const uint64_t pixels = uint64_t{view.width} * view.height;
  if (table.whole(counts_).size != pixels * sizeof(uint32_t)) {
    if (counts_ != BufferId::kInvalid) table.remove(counts_);
    counts_ = table.add(
        {.name = "overdraw", .size = pixels * sizeof(uint32_t), .stride = sizeof(uint32_t)});
  }
  if (sums_ == BufferId::kInvalid)
    sums_ = table.add({.name = "overdraw/summary",
                       .size = kSumBytes,
                       .stride = sizeof(uint32_t),
                       .usage = BufferUsage::kStorage | BufferUsage::kReadback});
  const DrawValuesBindings drawn = {.drawValuesConstants = valuesOf(look, view, 2)};
  const OverdrawBindings counters = {.overdraw = table.whole(counts_),
                                     .overdrawSummary = table.whole(sums_)};
  PassList counting, showing;
  PassBuilder clear(counting);
  dispatchOver(clear, clearOverdrawVariant({}),
               std::max<uint64_t>(pixels, overdraw::kOverdrawWords));
  if (Result<void> done = clear.finish(drawn, counters); !done) return done;
  if (Result<void> done = drawStrands(look, what, view, counting); !done) return done;
  counting.area = showing.area = areaOf(view);
  if (const auto added = frame.addView(std::move(counting)); !added) return added.error();

  PassBuilder sum(showing);
  dispatchOver(sum, sumOverdrawVariant({}), pixels);
  if (Result<void> done = sum.finish(drawn, counters); !done) return done;
  PassBuilder show(showing);
  show.draw(coveringVertexVariant({}), overdrawPixelVariant({}), overEverything(), 3, 1);
  if (Result<void> done = show.finish(drawn, counters); !done) return done;
  if (const auto added = frame.addView(std::move(showing)); !added) return added.error();
  return {};
}

// A rectangle as large as the grid, for each collider that some hair can reach.
Result<void> Inspection::drawSlice(const InspectionLook& look, const Inspected& what,
                                   const View& view, PassList& list) {
  const ResourceTable& table = what.scene->resources();
  const BufferRange keys = table.whole(what.scene->sdfKeys());
  if (!keys.isBound()) return {};
  const DrawValuesConstants colors = valuesOf(look, view, 2);
  SliceConstants constants = {};
  std::copy(std::begin(colors.valuesToClip), std::end(colors.valuesToClip),
            std::begin(constants.sliceToClip));
  std::copy(std::begin(colors.valueRamp), std::end(colors.valueRamp),
            std::begin(constants.sliceRamp));
  constants.sliceLow = colors.valueLow;
  constants.sliceHigh = colors.valueHigh;
  constants.sliceLine = look.sliceRange / kSliceLines;
  const auto axis = static_cast<size_t>(look.sliceAxis);
  for (const pelage::HairId hair : what.demo->hairs()) {
    const BufferId sdfs = what.scene->hair(hair).buffers().sdfs;
    constants.sliceSlotCount = slotsOf(table, sdfs);
    if (constants.sliceSlotCount == 0) continue;
    for (const pelage::ColliderId collider : what.demo->colliders()) {
      const pelage::SdfGrid& grid = what.scene->collider(collider).grid();
      float corner[3] = {grid.origin.x, grid.origin.y, grid.origin.z};
      float edges[2][4] = {};
      const auto extent = [&](size_t a) {
        return static_cast<float>(grid.nodes[a] - 1) * grid.cellSize;
      };
      corner[axis] += std::clamp(look.slicePosition, 0.0f, 1.0f) * extent(axis);
      edges[0][(axis + 1) % 3] = extent((axis + 1) % 3);
      edges[1][(axis + 2) % 3] = extent((axis + 2) % 3);
      constants.sliceCorner = {corner[0], corner[1], corner[2], 0};
      constants.sliceAcross = {edges[0][0], edges[0][1], edges[0][2], 0};
      constants.sliceUp = {edges[1][0], edges[1][1], edges[1][2], 0};
      constants.sliceOrigin = {grid.origin.x, grid.origin.y, grid.origin.z, grid.cellSize};
      constants.sliceNodes = {grid.nodes[0], grid.nodes[1], grid.nodes[2], 0};
      PassBuilder pass(list);
      pass.draw(sliceVertexVariant({}), slicePixelVariant({}), solid(view), kCornersOfStrip, 1);
      Result<void> done = pass.finish(SliceBindings{
          .sliceConstants = constants, .sliceSlots = table.whole(sdfs), .sliceKeys = keys});
      if (!done) return done;
    }
  }
  return {};
}

Result<void> Inspection::drawSurfaces(const Inspected& what, const View& view, PassList& list) {
  for (const pelage::ColliderId collider : what.demo->colliders()) {
    Result<void> done = what.scene->drawCollider(collider, view, what.demo->light, {}, list);
    if (!done) return done;
  }
  return {};
}

Result<void> Inspection::draw(const InspectionLook& look, const Inspected& what, const View& view,
                              pelage::Frame& frame) {
  if (!hasPasses(look.value)) return {};
  if (look.value == InspectedValue::kTiles) return tiles_.draw(look, *what.scene, view, frame);
  if (look.value == InspectedValue::kDetail) {
    figures_ = {};
    for (size_t i = 0; i < what.demo->hairs().size(); ++i) addDetail(objectOf(what, i), figures_);
  }
  if (look.value == InspectedValue::kOverdraw) return drawOverdraw(look, what, view, frame);
  PassList list;
  Result<void> done = look.value == InspectedValue::kSdfSlice ? drawSlice(look, what, view, list)
                                                              : drawStrands(look, what, view, list);
  if (!done) return done;
  list.area = areaOf(view);
  const auto added = frame.addView(std::move(list));
  if (!added) return added.error();
  return {};
}

Result<void> Inspection::measureOverdraw(const pelage::BufferReader& read) {
  if (sums_ == BufferId::kInvalid) return {};
  const auto bytes = read(sums_);
  if (!bytes) return bytes.error();
  const std::vector<uint32_t> words = wordsOf(*bytes);
  figures_ = {};
  figures_.known = true;
  figures_.largest = static_cast<float>(words[overdraw::kOverdrawMost]);
  figures_.pixels = words[overdraw::kOverdrawPixels];
  figures_.fragments = words[overdraw::kOverdrawTotal];
  return {};
}

Result<void> Inspection::measure(const InspectionLook& look, const pelage::BufferReader& read) {
  if (look.value == InspectedValue::kOverdraw) return measureOverdraw(read);
  if (look.value == InspectedValue::kTiles) {
    const Result<InspectionFigures> counted = tiles_.measure(read);
    if (!counted) return counted.error();
    figures_ = *counted;
  }
  if (look.value != InspectedValue::kStretch && look.value != InspectedValue::kPenetration)
    return {};
  InspectionFigures sum;
  for (const auto& [id, hair] : hairs_) {
    const auto bytes = read(hair.summary);
    if (!bytes) return bytes.error();
    const std::vector<uint32_t> words = wordsOf(*bytes);
    sum.known = true;
    sum.largest = std::max(sum.largest, std::bit_cast<float>(words[strand_value::kSummaryLargest]));
    sum.beyond += words[strand_value::kSummaryBeyond];
    sum.notFinite += words[strand_value::kSummaryNotFinite];
    sum.measured += words[strand_value::kSummaryMeasured];
  }
  figures_ = sum;
  return {};
}

void Inspection::clear(pelage::Scene& scene) {
  ResourceTable& table = scene.resources();
  for (const auto& [id, hair] : hairs_)
    for (const BufferId buffer : {hair.records, hair.summary, hair.restLengths, hair.colliders})
      if (buffer != BufferId::kInvalid) table.remove(buffer);
  hairs_.clear();
  for (BufferId* buffer : {&counts_, &sums_}) {
    if (*buffer != BufferId::kInvalid) table.remove(*buffer);
    *buffer = BufferId::kInvalid;
  }
  tiles_.clear(scene);
  figures_ = {};
}

}  // namespace viewer
