#include "stage/strand_inspection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "stage/inspection_passes.h"
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

constexpr float kCountedPixels = 1;  // smallest width that the transparency methods draw
constexpr uint64_t kSummaryBytes = strand_value::kSummaryWords * sizeof(uint32_t);

const HairObject& objectOf(const Inspected& what, size_t index) {
  return what.scene->hair(what.demo->hairs()[index]);
}

// Returns the number of strands to pose: those that draws show; for stretch the guides, the only
// strands with edges that a solver keeps.
uint32_t posedStrands(const InspectionLook& look, const HairObject& object) {
  if (look.value == InspectedValue::kDetail) return object.strandCount();
  if (look.value == InspectedValue::kStretch) return object.guideCount();
  return std::max(drawnStrandsOf(object).count, 1u);
}

BufferRange wholeOr(const ResourceTable& table, BufferId buffer, const BufferRange& standIn) {
  const BufferRange range = table.whole(buffer);
  return range.isBound() ? range : standIn;
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

Result<void> pose(const InspectionLook& look, const Inspected& what, size_t index,
                  StrandValues& hair, PassList& list) {
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

// Measures the stretch of guides; other views mark the kind of each strand.
Result<void> measureStretch(const InspectionLook& look, const Inspected& what, size_t index,
                            const StrandValues& hair, PassList& list) {
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

Result<void> measurePenetration(const InspectionLook& look, const Inspected& what, size_t index,
                                StrandValues& hair, PassList& list) {
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
  if (colliders.empty()) colliders.emplace_back();  // a buffer must not be empty
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

Result<void> markDetail(const HairObject& hair, const pelage::ResourceTable& table,
                        pelage::BufferId records, pelage::PassList& list) {
  const pelage::DrawnStrands drawn = drawnStrandsOf(hair);
  const BufferRange rest = table.whole(hair.buffers().rest);
  StrandDetailConstants constants = {};
  constants.detailVertexCount = hair.verticesPerStrand();
  constants.detailVertices = hair.strandCount() * hair.verticesPerStrand();
  constants.detailShown = drawn.shown;
  constants.detailFading = drawn.fading;
  constants.detailGuideCount = hair.guideCount();
  constants.detailSimulatedCount = simulatedGuides(hair);
  StrandDetailBindings bindings = {.strandDetailConstants = constants,
                                   .detailRest = rest.isBound() ? rest : table.whole(records),
                                   .detailRecords = table.whole(records)};
  PassBuilder mark(list);
  dispatchOver(mark, markDetailVariant({}), constants.detailVertices);
  if (Result<void> done = mark.finish(bindings); !done) return done;
  // The classic solver does not order strands: it simulates all or none.
  const bool ordered = hair.settings.solver == pelage::Solver::kExact && rest.isBound();
  if (!ordered || constants.detailSimulatedCount == hair.guideCount()) return {};
  // The last elements are [guide] ExactStrand.
  constants.detailFirstStrand = static_cast<uint32_t>(rest.size / sizeof(pelage::Float4)) -
                                strand_detail::kExactStrandElements * hair.guideCount();
  bindings.strandDetailConstants = constants;
  PassBuilder interpolated(list);
  dispatchOver(interpolated, markInterpolatedVariant({}),
               uint64_t{hair.guideCount()} * hair.verticesPerStrand());
  return interpolated.finish(bindings);
}

Result<void> drawRecords(const HairObject& object, const StrandValues& hair,
                         const DrawValuesConstants& constants, const pelage::DrawState& state,
                         PassList& list) {
  const uint64_t records = uint64_t{hair.posed} * object.verticesPerStrand();
  PassBuilder pass(list);
  pass.draw(valueVertexVariant({}), valuePixelVariant({}), state, kCornersOfStrip,
            static_cast<uint32_t>(records - 1))
      .vertices({hair.records, records * sizeof(Float4)});
  return pass.finish(DrawValuesBindings{.drawValuesConstants = constants});
}

Result<void> drawValues(const InspectionLook& look, const HairObject& object,
                        const StrandValues& hair, DrawValuesConstants constants, const View& view,
                        PassList& list) {
  pelage::DrawState state = solid(view);
  // Strands that are left out must not hide strands that are drawn.
  state.depthWrite = look.value != InspectedValue::kDetail;
  if (Result<void> done = drawRecords(object, hair, constants, state, list); !done) return done;
  constants.valueAbove = 0;
  state.depthWrite = true;
  if (look.value == InspectedValue::kDetail)
    return drawRecords(object, hair, constants, state, list);
  // Vertices in a collider are behind its surface.
  state.depthCompare = pelage::DepthCompare::kAlways;
  if (look.value == InspectedValue::kPenetration)
    return drawRecords(object, hair, constants, state, list);
  return {};
}

Result<void> countStrands(const HairObject& object, const StrandValues& hair,
                          DrawValuesConstants constants, const View& view,
                          const OverdrawBindings& counters, PassList& list) {
  constants.valueWidth = kCountedPixels;
  constants.valueRadius = object.material.fiberRadius / std::max(object.drawnShare, 1e-3f);
  constants.valueTipRatio = object.material.tipRadiusRatio;
  pelage::DrawState state = solid(view);
  state.depthWrite = state.colorWrite = false;
  const uint64_t records = uint64_t{hair.posed} * object.verticesPerStrand();
  PassBuilder pass(list);
  pass.draw(valueVertexVariant({}), countPixelVariant({}), state, kCornersOfStrip,
            static_cast<uint32_t>(records - 1))
      .vertices({hair.records, records * sizeof(Float4)});
  return pass.finish(DrawValuesBindings{.drawValuesConstants = constants}, counters);
}

}  // namespace

uint32_t simulatedGuides(const HairObject& hair) {
  if (!hair.simulated) return 0;
  if (hair.buffers().lodParents == pelage::BufferId::kInvalid) return hair.guideCount();
  const double wanted =
      std::ceil(static_cast<double>(hair.simulatedShare) * static_cast<double>(hair.guideCount()));
  return static_cast<uint32_t>(std::clamp(wanted, 1.0, static_cast<double>(hair.guideCount())));
}

void addDetail(const HairObject& hair, InspectionFigures& figures) {
  const pelage::DrawnStrands drawn = drawnStrandsOf(hair);
  figures.known = true;
  figures.strands += hair.strandCount();
  figures.drawn += drawn.count;
  figures.fading += static_cast<uint64_t>(std::ceil(drawn.fading));
  figures.widening = std::max(figures.widening, drawn.widening);
  figures.guides += hair.guideCount();
  figures.simulated += simulatedGuides(hair);
}

StrandValues& StrandInspection::valuesOf(const Inspected& what, size_t index) {
  const auto [at, isNew] = hairs_.try_emplace(what.demo->hairs()[index]);
  if (!isNew) return at->second;
  const HairObject& object = objectOf(what, index);
  ResourceTable& table = what.scene->resources();
  StrandValues hair;
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
  hair.restLengths = table.add(object.name() + "/restLengths", what.demo->restLengths(index));
  return at->second = hair;
}

// Poses the strands, and gives their vertices values: dispatches come before draws.
Result<void> StrandInspection::evaluate(const InspectionLook& look, const Inspected& what,
                                        PassList& list) {
  for (size_t i = 0; i < what.demo->hairs().size(); ++i) {
    StrandValues& hair = valuesOf(what, i);
    Result<void> done = pose(look, what, i, hair, list);
    if (done && look.value == InspectedValue::kPenetration)
      done = measurePenetration(look, what, i, hair, list);
    else if (done && look.value == InspectedValue::kDetail)
      done = markDetail(objectOf(what, i), what.scene->resources(), hair.records, list);
    else if (done)
      done = measureStretch(look, what, i, hair, list);
    if (!done) return done;
  }
  return {};
}

Result<void> StrandInspection::draw(const InspectionLook& look, const Inspected& what,
                                    const View& view, const OverdrawBindings* counters,
                                    PassList& list) {
  if (Result<void> done = evaluate(look, what, list); !done) return done;
  for (size_t i = 0; i < what.demo->hairs().size(); ++i) {
    const HairObject& object = objectOf(what, i);
    const StrandValues& hair = valuesOf(what, i);
    const DrawValuesConstants constants = viewer::valuesOf(look, view, object.verticesPerStrand());
    Result<void> done = counters != nullptr
                            ? countStrands(object, hair, constants, view, *counters, list)
                            : drawValues(look, object, hair, constants, view, list);
    if (!done) return done;
  }
  return {};
}

Result<InspectionFigures> StrandInspection::measure(const pelage::BufferReader& read) const {
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
  return sum;
}

void StrandInspection::clear(pelage::Scene& scene) {
  ResourceTable& table = scene.resources();
  for (const auto& [id, hair] : hairs_)
    for (const BufferId buffer : {hair.records, hair.summary, hair.restLengths, hair.colliders})
      if (buffer != BufferId::kInvalid) table.remove(buffer);
  hairs_.clear();
}

}  // namespace viewer
