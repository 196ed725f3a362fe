#include "shading/strand_colors.h"

#include <algorithm>
#include <cmath>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

namespace {

constexpr uint32_t kMaxColorTexture = 65536, kMaxLevels = 17;
constexpr float kMaxLodBias = 16;
constexpr uint64_t kGuideBytes = 2 * sizeof(Uint2);
constexpr const char* kColorsRemade = "its buffers were remade by a later draw; write it again";

// Objects bind their own part, and devices want offsets that are multiples of up to 256 bytes.
uint64_t bytesOf(const DrawnHair& hair) {
  constexpr uint64_t kAlignment = 256;
  if (hair.texture == nullptr) return 0;
  return (hair.guideCount * kGuideBytes + kAlignment - 1) / kAlignment * kAlignment;
}

float length(const Float4& row) { return std::sqrt(row.x * row.x + row.y * row.y + row.z * row.z); }

// Size of a pixel where clip w is 1 [m]; 0 where the matrix has no rows across.
float pixelSize(const View& view) {
  const float height = 0.5f * static_cast<float>(view.height) * length(view.worldToClip.rows[1]);
  const float size = 1 / height;
  return std::isfinite(size) ? size : 0;
}

Result<void> addPass(const DrawnView& view, const DrawnHair& hair, PassList& list) {
  const StrandTexture& texture = *hair.texture;
  const float guides = static_cast<float>(hair.guideCount);
  StrandColorsConstants constants = {};
  constants.colorsGuideCount = hair.guideCount;
  constants.colorsVertexCount = hair.vertexCount;
  constants.colorsTexels = static_cast<float>(std::max(texture.width, texture.height));
  constants.colorsLastLevel = static_cast<float>(texture.mipLevels - 1);
  constants.colorsLodBias = texture.lodBias;
  constants.colorsSpread = std::sqrt(guides / std::clamp(hair.strands.shown, 1.0f, guides));
  constants.colorsPixelSize = pixelSize(view.view);
  constants.colorsClipW = view.view.worldToClip.rows[3];
  const uint64_t positions = uint64_t{hair.guideCount} * hair.vertexCount * sizeof(Float4);
  PassBuilder builder(list);
  dispatchRows(builder, sampleStrandColorsVariant(), hair.guideCount)
      .bind("g_strandTexture", texture.texture)
      .bind("g_strandSampler", texture.texture)
      .bytes(hair.guideCount * (2 * sizeof(Float4) + kGuideBytes));
  return builder.finish(StrandColorsBindings{
      .strandColorsConstants = constants,
      .colorsPositions = {hair.positions, positions},
      .strandUvs = {hair.buffers->strandUvs, hair.guideCount * sizeof(Float4)},
      .strandColors = hair.colors,
  });
}

}  // namespace

std::string faultOf(const StrandTexture& texture, const HairBuffers& buffers) {
  if (texture.texture == TextureId::kInvalid) return {};
  if (buffers.strandUvs == BufferId::kInvalid)
    return "strandTexture needs the UV of the roots: add the object with HairDef::strandUvs";
  const auto isSize = [](uint32_t size) { return size >= 1 && size <= kMaxColorTexture; };
  if (!isSize(texture.width) || !isSize(texture.height)) {
    return "strandTexture has " + std::to_string(texture.width) + " x " +
           std::to_string(texture.height) +
           " texels; width and height are those of mip level 0, 1 to 65536";
  }
  if (texture.mipLevels < 1 || texture.mipLevels > kMaxLevels)
    return "strandTexture.mipLevels is " + std::to_string(texture.mipLevels) +
           ", but must be 1 to 17";
  if (!(std::abs(texture.lodBias) <= kMaxLodBias))
    return "strandTexture.lodBias is " + std::to_string(texture.lodBias) +
           ", but must be -16 to 16";
  return {};
}

Result<void> StrandColors::record(DrawnView& view, const BufferFactory& factory, uint64_t frame,
                                  PassList& list) {
  uint64_t bytes = 0;
  for (const DrawnHair& hair : view.hairs) bytes += bytesOf(hair);
  if (bytes == 0) return {};
  Slot& slot = freeSlot(frame);
  last_ = &slot;
  const bool created = slot.tickets.hasRun();
  slot.tickets.lose(kColorsRemade);
  if (factory.ensureCapacity({slot.colors, "strand colors", bytes, sizeof(Uint2)}, !created))
    slot.tickets.forgetRuns();
  uint64_t offset = 0;
  for (DrawnHair& hair : view.hairs) {
    if (hair.texture == nullptr) continue;
    hair.colors = {slot.colors, hair.guideCount * kGuideBytes, offset};
    offset += bytesOf(hair);
    if (Result<void> added = addPass(view, hair, list); !added) return added;
  }
  slot.tickets.add(ticketOf(list, frame));
  return {};
}

void StrandColors::share(const DrawnView& view, std::span<PassList> lists, uint64_t frame) {
  const bool reads = std::any_of(view.hairs.begin(), view.hairs.end(),
                                 [](const DrawnHair& hair) { return hair.colors.isBound(); });
  if (!reads || lists.empty()) return;
  const std::shared_ptr<ListTicket> maker = ticketOf(lists[0], frame);
  for (PassList& list : lists.subspan(1)) {
    if (list.passes.empty()) continue;  // nobody has to run it
    const std::shared_ptr<ListTicket> ticket = ticketOf(list, frame);
    HandleArray<ListTicket>& needs = ticket->needs;
    if (std::find(needs.begin(), needs.end(), maker) == needs.end()) needs.push_back(maker);
    last_->tickets.add(ticket);
  }
}

StrandColors::Slot& StrandColors::freeSlot(uint64_t frame) {
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [&](const auto& slot) { return slot->tickets.isFree(frame); });
  if (found != slots_.end()) return **found;
  return *slots_.emplace_back(std::make_unique<Slot>());
}

void StrandColors::trim(const BufferFactory& factory, const char* reason) {
  for (const auto& slot : slots_) {
    slot->tickets.lose(reason);
    factory.remove(slot->colors);
  }
  slots_.clear();
  last_ = nullptr;
}

}  // namespace pelage::detail
