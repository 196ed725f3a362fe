#include "shadow/shadow_maps.h"

#include <algorithm>
#include <optional>
#include <span>

#include "pelage/view.h"

namespace pelage::detail {

namespace {

void need(const std::shared_ptr<ListTicket>& reader, const std::shared_ptr<ListTicket>& maker) {
  HandleArray<ListTicket>& needs = reader->needs;
  if (maker != reader && std::find(needs.begin(), needs.end(), maker) == needs.end())
    needs.push_back(maker);
}

}  // namespace

Result<void> ShadowMaps::check(std::span<const StrandShadowDef> defs,
                               std::span<const OpaqueShadowPlan> opaques,
                               std::span<const ShadowedHair> hairs, const BufferFactory& factory,
                               uint64_t frame, uint64_t moves, ShadowPlan& plan) {
  plan.maps.clear();
  plan.opaques.clear();
  plan.words = 0;
  std::optional<size_t> number = hairs_.numberOf(hairs, moves);
  if (!number) {
    forget();
    number = hairs_.numberOf(hairs, moves);
  }
  plan.hairs = *number;
  plan.moves = moves;
  banks_.beginFrame(frame, moves);
  for (StrandShadowDef def : defs) {
    def.firstWord = static_cast<uint32_t>(plan.words);
    const Result<StrandShadowPlan> map = planStrandShadow(def, hairs);
    if (!map) return map.error();
    plan.words += map->words;
    plan.maps.push_back(*map);
  }
  for (const OpaqueShadowPlan& opaque : opaques) {
    plan.words += opaque.words;
    plan.opaques.push_back(opaque);
  }
  return banks_.check(plan, factory, frame);
}

Result<void> ShadowMaps::record(ShadowPlan& plan, std::span<const ShadowedHair> hairs,
                                const BufferFactory& factory, uint64_t frame, PassList& list) {
  const std::shared_ptr<ListTicket> ticket = ticketOf(list, frame);
  const Result<ShadowBank*> bank = banks_.take(plan, factory, frame);
  if (!bank) return bank.error();
  bank_ = *bank;

  uint32_t missing = 0;  // maps, as bits
  static_assert(kMaxStrandShadows <= 32);
  content_.clear();
  for (StrandShadowPlan& map : plan.maps) {
    ShadowMap* known = bank_->find(map, plan, frame);
    if (known != nullptr) {
      known->frame = frame;
      map.view.firstWord = known->view.firstWord;
      need(ticket, known->maker);
    } else {
      missing |= 1u << content_.size();
      map.view.firstWord = static_cast<uint32_t>(bank_->used);
      bank_->used += map.words;
      bank_->maps.push_back(
          {map.view, BufferId::kInvalid, map.words, plan.hairs, plan.moves, frame, ticket});
    }
    content_.push_back(map.view);
  }
  const bool complete = missing == 0;
  table_ = &tables_.take(content_, complete, factory, frame);
  const bool known = complete && table_->maker != nullptr;
  // Without maps nothing is read of the table, whoever has filled it last.
  if (known && !content_.empty()) need(ticket, table_->maker);
  for (size_t i = 0; i < plan.maps.size() && !known; ++i) {
    table_->maker = ticket;
    StrandShadowBuffers buffers;
    buffers.views = views();
    buffers.viewCount = kMaxStrandShadows;
    buffers.view = static_cast<uint32_t>(i);
    buffers.words = words();
    buffers.wordCount = factory.bytesOf(words()) / sizeof(uint32_t);
    if ((missing >> i & 1) == 0) {
      addUpload(list, views(), std::as_bytes(std::span(&content_[i], 1)),
                i * sizeof(StrandShadowView));
    } else if (Result<void> added = addStrandShadow(list, plan.maps[i], buffers, hairs); !added) {
      return added;
    }
  }
  if (Result<void> copied = recordOpaques(plan, factory, frame, list); !copied) return copied;
  share({&list, 1}, frame);
  return {};
}

// Copies the maps of opaque geometry that are not in the bank.
Result<void> ShadowMaps::recordOpaques(ShadowPlan& plan, const BufferFactory& factory,
                                       uint64_t frame, PassList& list) {
  for (OpaqueShadowPlan& opaque : plan.opaques) {
    const std::shared_ptr<ListTicket> ticket = ticketOf(list, frame);
    if (ShadowMap* known = bank_->find(opaque, frame); known != nullptr) {
      opaque.firstWord = known->view.firstWord;
      need(ticket, known->maker);
      continue;
    }
    opaque.firstWord = static_cast<uint32_t>(bank_->used);
    bank_->used += opaque.words;
    StrandShadowView view = {};
    view.firstWord = opaque.firstWord;
    bank_->maps.push_back({view, opaque.depth, opaque.words, 0, 0, frame, ticket});
    if (Result<void> added =
            addOpaqueShadow(list, opaque, words(), factory.bytesOf(words()) / sizeof(uint32_t));
        !added)
      return added;
  }
  return {};
}

void ShadowMaps::share(std::span<PassList> lists, uint64_t frame) {
  for (PassList& list : lists) {
    if (list.passes.empty() && list.uploads.empty()) continue;  // nobody has to run it
    const std::shared_ptr<ListTicket> ticket = ticketOf(list, frame);
    bank_->tickets.add(ticket);
    table_->tickets.add(ticket);
  }
}

void ShadowMaps::forget() {
  banks_.forget();
  tables_.forget();
}

uint64_t ShadowMaps::bytes(const ResourceTable& resources) const {
  return banks_.bytes(resources) + tables_.bytes(resources);
}

void ShadowMaps::trim(const BufferFactory& factory, const char* reason) {
  banks_.trim(factory, reason);
  tables_.trim(factory, reason);
  bank_ = nullptr;
  table_ = nullptr;
}

}  // namespace pelage::detail
