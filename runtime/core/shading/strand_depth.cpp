#include "shading/strand_depth.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "base/finite.h"
#include "pelage/bindings.h"
#include "pelage/kernels.h"

namespace pelage {

Result<void> validate(const HairDepthSettings& settings) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "HairDepthSettings::" + what};
  };
  if (!(settings.opacity >= 0 && settings.opacity <= 1))
    return refuse("opacity is " + std::to_string(settings.opacity) + ", but must be in 0..1");
  if (settings.color != HairDepthColor::kMotion) return {};
  if (!detail::isFinite(settings.previousWorldToClip))
    return refuse("previousWorldToClip is not finite");
  for (const float value : {settings.jitter.x, settings.jitter.y})
    if (!std::isfinite(value)) return refuse("jitter is not finite");
  for (const float value : {settings.previousJitter.x, settings.previousJitter.y})
    if (!std::isfinite(value)) return refuse("previousJitter is not finite");
  return {};
}

namespace detail {

namespace {

constexpr const char* kDepthRemade =
    "its buffers were remade by a later drawDepth(); write it again";

Float4 change(const Float4& to, const Float4& from) {
  const auto difference = [](float a, float b) {
    return static_cast<float>(static_cast<double>(a) - static_cast<double>(b));
  };
  return {difference(to.x, from.x), difference(to.y, from.y), difference(to.z, from.z),
          difference(to.w, from.w)};
}

// The bindings of draws and dispatches over an object, beside the strands themselves.
StrandDepthBindings depthBindings(const DrawnView& view, const DrawnHair& hair,
                                  const HairDepthSettings& settings,
                                  const StrandBindings& strands) {
  StrandDepthConstants constants = {};
  // Interpolation may make opaque hair slightly less opaque.
  constants.depthOpacity = settings.opacity * (1 - 1e-5f);
  constants.previousTipSeparation = hair.tipSeparation;
  constants.motionRecordCount = static_cast<uint32_t>(hair.drawnVertices());
  StrandDepthBindings bindings;
  // Without positions of before, nothing has moved in the world.
  bindings.previousPositions = strands.posTan.renderPositions;
  if (hair.before.positions != BufferId::kInvalid) {
    bindings.previousPositions.buffer = hair.before.positions;
    constants.previousTipSeparation = hair.before.tipSeparation;
    constants.previousRoots = hair.guideCount;
  }
  if (settings.color == HairDepthColor::kMotion) {
    const Float4* now = view.view.worldToClip.rows;
    const Float4* before = settings.previousWorldToClip.rows;
    constexpr size_t kRows[] = {0, 1, 3};
    for (size_t i = 0; i < std::size(kRows); ++i)
      constants.clipChange[i] = change(now[kRows[i]], before[kRows[i]]);
    constants.jitterChange = {settings.jitter.x - settings.previousJitter.x,
                              settings.jitter.y - settings.previousJitter.y};
  }
  bindings.strandDepthConstants = constants;
  return bindings;
}

BufferRange recordsOf(const DrawnView& view, const DrawnHair& hair) {
  return {view.records.buffer, hair.drawnVertices() * kRecordBytes,
          hair.firstRecord * kRecordBytes};
}

Result<void> addMotion(const DrawnView& view, const DrawnHair& hair,
                       const HairDepthSettings& settings, PassList& list) {
  const StrandBindings strands = strandBindings(view, hair, 0);
  StrandDepthBindings depth = depthBindings(view, hair, settings, strands);
  depth.motionRecords = recordsOf(view, hair);
  const RecordThreads threads = recordThreads(hair.drawnVertices());
  PassBuilder builder(list);
  builder
      .dispatch(transformMotionVariant({.follows = hair.evaluatedStrands() > 0}), threads.x,
                threads.y)
      .bytes(strands.bytes + hair.drawnVertices() * 3 * sizeof(Uint4));
  return builder.finish(strands.posTan, strands.render, depth);
}

Result<void> addDraw(const DrawnView& view, const DrawnHair& hair,
                     const HairDepthSettings& settings, PassList& list) {
  const bool motion = settings.color == HairDepthColor::kMotion;
  const KernelVariant& pixel = strandDepthPixelVariant({.motion = motion});
  DrawState state;
  state.depthCompare =
      view.view.reversedDepth ? DepthCompare::kGreaterEqual : DepthCompare::kLessEqual;
  state.colorWrite = settings.color != HairDepthColor::kNone;
  const StrandBindings strands = strandBindings(view, hair, 0);
  PassBuilder builder(list);
  if (view.transformsFirst) {
    // An instance is a segment, or the gap between two strands.
    const uint64_t records = hair.drawnVertices();
    const KernelVariant& vertex =
        motion ? motionRecordVertexVariant({}) : strandRecordVertexVariant({.smooth = false});
    state.topology = PrimitiveTopology::kTriangleStrip;
    builder.draw(vertex, pixel, state, 4, static_cast<uint32_t>(records - 1))
        .vertices(recordsOf(view, hair))
        .bytes(records * kRecordBytes);
  } else {
    const bool attributes = strandAttributes(view, hair) != 0;
    const KernelVariant& vertex =
        motion ? strandMotionVertexVariant({.attributes = attributes})
               : strandVertexVariant({.smooth = false, .attributes = attributes});
    builder
        .draw(vertex, pixel, state, (hair.vertexCount - 1) * 6, hair.strands.count,
              hair.buffers->indices)
        .bytes(strands.bytes);
  }
  return builder.finish(strands.posTan, strands.render,
                        depthBindings(view, hair, settings, strands));
}

}  // namespace

Result<void> StrandDepths::check(DrawnView& view, const HairDepthSettings& settings) {
  if (!view.transformsFirst) return {};
  const uint64_t bytes = placeRecords(view);
  uint64_t largest = 0;
  for (const DrawnHair& hair : view.hairs)
    largest = std::max(largest, hair.drawnVertices() * kRecordBytes);
  const auto refuse = [](uint64_t needed, const char* what, const char* cap, uint64_t limit) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("depth: the vertices of ") + what + " take " + std::to_string(needed) +
                     " bytes on the screen, but HairDepthSettings::" + cap + " is " +
                     std::to_string(limit) + ": draw fewer strands (HairObject::drawnShare)"};
  };
  const uint64_t most = std::min(settings.maxBufferBytes, kMaxRecords * kRecordBytes);
  if (largest > most) return refuse(largest, "an object", "maxBufferBytes", most);
  if (bytes > settings.maxBytes) return refuse(bytes, "the view", "maxBytes", settings.maxBytes);
  return {};
}

Result<void> StrandDepths::record(DrawnView& view, const HairDepthSettings& settings,
                                  const BufferFactory& factory, uint64_t frame, PassList& list) {
  if (view.transformsFirst && !view.hairs.empty()) {
    Slot& slot = freeSlot(frame);
    const bool created = slot.tickets.hasRun();
    slot.tickets.lose(kDepthRemade);
    const DrawnHair& last = view.hairs.back();
    const uint64_t bytes = (last.firstRecord + last.drawnVertices()) * kRecordBytes;
    if (factory.ensureCapacity({slot.records, "depth/strands", bytes, sizeof(Uint4),
                                BufferUsage::kStorage | BufferUsage::kVertex},
                               !created))
      slot.tickets.forgetRuns();
    view.records = {slot.records, bytes};
    slot.tickets.add(ticketOf(list, frame));
    if (Result<void> added = addTransforms(view, list); !added) return added;
    for (const DrawnHair& hair : view.hairs) {
      if (settings.color != HairDepthColor::kMotion) break;
      if (Result<void> added = addMotion(view, hair, settings, list); !added) return added;
    }
  }
  for (const DrawnHair& hair : view.hairs)
    if (Result<void> added = addDraw(view, hair, settings, list); !added) return added;
  return {};
}

StrandDepths::Slot& StrandDepths::freeSlot(uint64_t frame) {
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [&](const auto& slot) { return slot->tickets.isFree(frame); });
  if (found != slots_.end()) return **found;
  return *slots_.emplace_back(std::make_unique<Slot>());
}

void StrandDepths::trim(const BufferFactory& factory, const char* reason) {
  for (const auto& slot : slots_) {
    slot->tickets.lose(reason);
    factory.remove(slot->records);
  }
  slots_.clear();
}

}  // namespace detail
}  // namespace pelage
