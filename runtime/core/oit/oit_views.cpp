#include "oit/oit_views.h"

#include <algorithm>
#include <utility>

#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

constexpr const char* kViewRemade = "its buffers were remade by a later draw(); write it again";

size_t listsOf(Transparency method, size_t batches) {
  switch (method) {
    case Transparency::kAlphaTest:
    case Transparency::kStochastic:
      return 1;
    case Transparency::kWindowed:
      return 2 * batches;
    case Transparency::kTiles:
      return 1 + batches;
    case Transparency::kHybrid4:
    case Transparency::kHybrid8:
    case Transparency::kHybrid16:
      return 3;
    case Transparency::kShortCut:
      return 4;
  }
  return 1;
}

bool isOpaque(Transparency method) {
  return method == Transparency::kAlphaTest || method == Transparency::kStochastic;
}

Result<void> checkDepth(const View& view, BufferId depth, const BufferFactory& factory) {
  const uint64_t bytes = uint64_t{view.width} * view.height * sizeof(float);
  if (depth == BufferId::kInvalid || factory.bytesOf(depth) >= bytes) return {};
  return Error{ErrorCode::kInvalidArgument,
               "view: opaqueDepth has " + std::to_string(factory.bytesOf(depth)) +
                   " bytes, but a float a pixel takes " + std::to_string(bytes)};
}

// Checks memory for vertices in screen space.
Result<void> checkRecords(const DrawnView& view, uint64_t bytes,
                          const TransparencySettings& settings) {
  uint64_t largest = 0;
  for (const DrawnHair& hair : view.hairs)
    largest = std::max(largest, hair.drawnVertices() * kRecordBytes);
  const auto refuse = [](uint64_t needed, const char* what, const char* cap, uint64_t limit) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("transparency: the vertices of ") + what + " take " +
                     std::to_string(needed) + " bytes on the screen, but " + cap + " is " +
                     std::to_string(limit) + ": draw fewer strands (HairObject::drawnShare)"};
  };
  if (largest > settings.maxBufferBytes || largest / kRecordBytes > kMaxRecords)
    return refuse(largest, "an object", "maxBufferBytes", settings.maxBufferBytes);
  if (bytes > settings.maxBytes) return refuse(bytes, "the view", "maxBytes", settings.maxBytes);
  return {};
}

Result<void> addMethod(OitDraw& draw, std::vector<PassList>& lists) {
  const Transparency method = draw.settings.method;
  if (isOpaque(method))
    return addOpaqueDraws(draw.view, method == Transparency::kStochastic, lists[0]);
  if (method == Transparency::kShortCut) return addShortCutPasses(draw, lists);
  if (const uint32_t layers = layerCount(method); layers > 0)
    return addHybridPasses(draw, layers, lists);
  const std::span<const MaterialBatch> batches = draw.plan.batches.all();
  for (size_t i = 0; i < batches.size(); ++i) {
    Result<void> added = method == Transparency::kTiles
                             ? addTilePasses(draw, batches[i], lists[1 + i])
                             : addListPasses(draw, batches[i], lists[2 * i], lists[2 * i + 1]);
    if (!added) return added;
  }
  return {};
}

TransparencyTiles tilesOf(const OitDraw& draw) {
  TransparencyTiles tiles;
  tiles.method = draw.settings.method;
  const View& view = draw.view.view;
  const ListSizes sizes = listSizes(view.width, view.height, false);
  tiles.columns = sizes.columns;
  tiles.rows = static_cast<uint32_t>(sizes.tiles / sizes.columns);
  tiles.nodeCount = draw.plan.sizes.nodeCount;
  const bool lists = tiles.method == Transparency::kWindowed;
  tiles.counters = draw.buffers.lists.counters;
  tiles.tiles = lists ? draw.buffers.lists.tiles : draw.buffers.strands.tiles;
  if (!lists) return tiles;
  tiles.heads = draw.buffers.lists.heads;
  tiles.nodes = draw.buffers.lists.nodes;
  return tiles;
}

}  // namespace

DrawState overTarget() {
  DrawState over;
  over.depthCompare = DepthCompare::kAlways;
  over.depthWrite = false;
  over.blend = BlendMode::kPremultipliedAlpha;
  return over;
}

std::vector<BufferId*> OitBuffers::all() {
  return {&lists.heads,     &lists.nodes,     &lists.counters, &lists.tiles,   &lists.tail,
          &hybrid.depths,   &hybrid.colors,   &hybrid.tail,    &hybrid.tiles,  &hybrid.counters,
          &shortCut.depths, &shortCut.colors, &shortCut.tiles, &shortCut.tail, &shortCut.counters,
          &strands.records, &strands.pixels,  &strands.tiles,  &strands.sums,  &strands.fragments,
          &strands.visible, &strands.picture};
}

Result<void> OitViews::check(DrawnView& view, const TransparencySettings& settings,
                             const BufferFactory& factory, OitPlan& plan) {
  plan.batches.clear();
  plan.vertices = plan.recordBytes = 0;
  if (Result<void> complete = checkLights(settings.engineLights); !complete) return complete;
  view.engineLights = settings.engineLights;
  view.readsUv = readsRootUv(settings.engineLights);
  TransparencySettings left = settings;
  if (view.transformsFirst && settings.method != Transparency::kTiles) {
    plan.recordBytes = placeRecords(view);
    if (Result<void> fits = checkRecords(view, plan.recordBytes, settings); !fits) return fits;
    left.maxBytes -= plan.recordBytes;
  }
  if (settings.method == Transparency::kWindowed || settings.method == Transparency::kTiles)
    plan.batches.fill(view);
  for (const MaterialBatch& batch : plan.batches.all())
    plan.vertices = std::max(plan.vertices, batch.vertices);
  const Result<TransparencyPlan> sizes =
      planTransparency(view.view.width, view.view.height, left, plan.vertices);
  if (!sizes) {
    Error error = sizes.error();
    if (plan.recordBytes > 0) {
      error.message += "; in all maxBytes is " + std::to_string(settings.maxBytes) +
                       ", of which vertices on the screen take " + std::to_string(plan.recordBytes);
    }
    return error;
  }
  plan.sizes = *sizes;
  plan.sizes.bytes += plan.recordBytes;
  if (settings.method == Transparency::kTiles && !view.hairs.empty()) {
    return checkDepth(view.view, settings.opaqueDepth, factory);
  }
  return {};
}

Result<void> OitViews::record(DrawnView& view, const TransparencySettings& settings,
                              const OitPlan& plan, const BufferFactory& factory, uint64_t frame,
                              std::vector<PassList>& lists) {
  tiles_ = {};
  const size_t count = listsOf(settings.method, plan.batches.all().size());
  if (lists.size() < count) lists.resize(count);
  if (isOpaque(settings.method) && plan.recordBytes == 0)
    return addOpaqueDraws(view, settings.method == Transparency::kStochastic, lists[0]);

  last_ = freeSlot(frame);
  Slot& slot = *slots_[last_];
  const bool created = slot.tickets.hasRun();
  slot.tickets.lose(kViewRemade);
  OitDraw draw = {.view = view,
                  .settings = settings,
                  .plan = plan,
                  .buffers = slot.buffers,
                  .factory = factory,
                  .suffix = last_ == 0 ? "" : " of view " + std::to_string(last_ + 1),
                  .exact = !created};
  Result<void> added;
  if (plan.recordBytes > 0) {
    BufferId& records = slot.buffers.strands.records;
    draw.ensureCapacity(records, "transparency/strands", plan.recordBytes, sizeof(Uint4),
                        kRecordUsage);
    view.records = {records, plan.recordBytes};
    added = addTransforms(view, lists[0]);
  }
  if (added) added = addMethod(draw, lists);
  if (added && !plan.batches.all().empty()) tiles_ = tilesOf(draw);
  if (draw.remade) slot.tickets.forgetRuns();
  std::shared_ptr<ListTicket> before;
  for (size_t i = 0; i < count; ++i) {
    if (lists[i].passes.empty()) continue;  // nobody has to run it
    const std::shared_ptr<ListTicket> ticket = ticketOf(lists[i], frame);
    if (before != nullptr) ticket->needs.push_back(std::exchange(before, ticket));
    before = ticket;
    slot.tickets.add(ticket);
  }
  return added;
}

size_t OitViews::freeSlot(uint64_t frame) {
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [&](const auto& slot) { return slot->tickets.isFree(frame); });
  if (found != slots_.end()) return static_cast<size_t>(found - slots_.begin());
  slots_.push_back(std::make_unique<Slot>());
  return slots_.size() - 1;
}

BufferId OitViews::counters() const {
  return last_ < slots_.size() ? slots_[last_]->buffers.lists.counters : BufferId::kInvalid;
}

std::vector<uint64_t> OitViews::bytes(const ResourceTable& resources) const {
  std::vector<uint64_t> all;
  for (const auto& slot : slots_) {
    uint64_t& bytes = all.emplace_back(0);
    for (const BufferId* buffer : slot->buffers.all()) {
      const BufferDesc* desc = resources.find(*buffer);
      bytes += desc != nullptr ? desc->size : 0;
    }
  }
  return all;
}

void OitViews::trim(const BufferFactory& factory, const char* reason) {
  for (const auto& slot : slots_) {
    slot->tickets.lose(reason);
    for (BufferId* buffer : slot->buffers.all()) factory.remove(*buffer);
  }
  slots_.clear();
  last_ = 0;
  tiles_ = {};
}

}  // namespace pelage::detail
