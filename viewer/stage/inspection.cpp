#include "stage/inspection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "pelage/constants.h"
#include "stage/inspection_passes.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using namespace viewer_kernels;
using pelage::BufferId;
using pelage::BufferRange;
using pelage::Float3;
using pelage::Float4;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::ResourceTable;
using pelage::Result;
using pelage::View;

uint32_t slotsOf(const ResourceTable& table, BufferId sdfs) {
  constexpr uint64_t kSlotBytes = pelage::sdf::kSdfElements * sizeof(pelage::Uint4);
  return static_cast<uint32_t>(table.whole(sdfs).size / kSlotBytes);
}

namespace {

constexpr float kStrandPixels = 1.5f;   // width of strands with a value
constexpr float kGuidePixels = 1.2f;    // of guides and follow hairs, which are many
constexpr int kSliceLines = 4;          // lines between 0 and the range
constexpr uint64_t kInspectEvery = 15;  // frames

// Draws a slice of the grid of each collider within range of some hair.
Result<void> drawSlice(const InspectionLook& look, const Inspected& what, const View& view,
                       PassList& list) {
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

Result<void> Inspection::drawSurfaces(const Inspected& what, const pelage::ColliderLook& look,
                                      const View& view, PassList& list) {
  for (const pelage::ColliderId collider : what.demo->colliders()) {
    Result<void> done = what.scene->drawCollider(collider, view, what.demo->light, look, list);
    if (!done) return done;
  }
  return {};
}

void Inspection::follow(const InspectionLook& look, pelage::Scene& scene) {
  if (look == look_) return;
  look_ = look;
  frames_ = 0;
  figures_ = {};
  if (!hasPasses(look.value)) clear(scene);
}

Result<void> Inspection::draw(const Inspected& what, const View& view, pelage::Frame& frame) {
  if (!hasPasses(look_.value)) return {};
  if (look_.value == InspectedValue::kTiles) return tiles_.draw(look_, *what.scene, view, frame);
  if (look_.value == InspectedValue::kOverdraw)
    return overdraw_.draw(look_, what, view, strands_, frame);
  if (look_.value == InspectedValue::kDetail) {
    figures_ = {};
    for (const pelage::HairId hair : what.demo->hairs())
      addDetail(what.scene->hair(hair), figures_);
  }
  PassList list;
  Result<void> done = look_.value == InspectedValue::kSdfSlice
                          ? drawSlice(look_, what, view, list)
                          : strands_.draw(look_, what, view, nullptr, list);
  if (!done) return done;
  list.area = areaOf(view);
  const auto added = frame.addView(std::move(list));
  if (!added) return added.error();
  return {};
}

Result<void> Inspection::measure(const pelage::BufferReader& read) {
  if (frames_++ % kInspectEvery != 0) return {};
  Result<InspectionFigures> measured = figures_;
  if (look_.value == InspectedValue::kOverdraw) measured = overdraw_.measure(read);
  if (look_.value == InspectedValue::kTiles) measured = tiles_.measure(read);
  if (look_.value == InspectedValue::kStretch || look_.value == InspectedValue::kPenetration)
    measured = strands_.measure(read);
  if (!measured) return measured.error();
  figures_ = *measured;
  return {};
}

void Inspection::clear(pelage::Scene& scene) {
  strands_.clear(scene);
  overdraw_.clear(scene);
  tiles_.clear(scene);
  figures_ = {};
}

}  // namespace viewer
