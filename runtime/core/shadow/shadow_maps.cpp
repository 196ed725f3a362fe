#include "shadow/shadow_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "pelage/view.h"

namespace pelage::detail {

namespace {

constexpr const char* kShadowsRemade =
    "its shadow maps were remade by a later draw(); write it again";
constexpr uint64_t kLeastWords = 4;  // kernels have the buffer bound where no light has a shadow
constexpr uint64_t kMostWords = std::numeric_limits<uint32_t>::max();
constexpr size_t kMostHairs = 64;  // whose maps are told apart

uint64_t wordsOf(const BufferFactory& factory, BufferId buffer) {
  return factory.bytesOf(buffer) / sizeof(uint32_t);
}

bool isEqual(const StrandShadowView& a, const StrandShadowView& b) {
  const auto bytesOf = [](const StrandShadowView& view) {
    return std::as_bytes(std::span(&view, 1));
  };
  return std::ranges::equal(bytesOf(a), bytesOf(b));
}

bool isKnown(const std::shared_ptr<ListTicket>& maker, uint64_t frame) {
  return maker != nullptr && isMade(*maker, frame);
}

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
  plan.hairs = numberOf(hairs, moves);
  plan.moves = moves;
  beginFrame(frame, moves);
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
  if (const Result<Choice> choice = choose(plan, factory, frame); !choice) return choice.error();
  return {};
}

size_t ShadowMaps::numberOf(std::span<const ShadowedHair> hairs, uint64_t moves) {
  if (std::exchange(moves_, moves) != moves) hairCount_ = 0;
  for (size_t i = 0; i < hairCount_; ++i)
    if (std::ranges::equal(hairs, hairs_[i])) return i;
  if (hairCount_ == kMostHairs) {
    forget();
    hairCount_ = 0;
  }
  if (hairCount_ == hairs_.size()) hairs_.emplace_back();
  hairs_[hairCount_].assign(hairs.begin(), hairs.end());
  return hairCount_++;
}

// Drops the maps that no view is going to read again, so that lights that move take no more room
// from frame to frame: all of a bank where the last frame left one of them unread.
void ShadowMaps::beginFrame(uint64_t frame, uint64_t moves) {
  if (std::exchange(begun_, frame) == frame) return;
  for (const std::unique_ptr<Bank>& bank : banks_) {
    if (!bank->tickets.isFree(frame)) continue;
    std::erase_if(bank->maps, [](const Map& map) { return map.opaque != BufferId::kInvalid; });
    const auto isOver = [&](const Map& map) {
      return map.frame != bank->frame || map.moves != moves;
    };
    if (std::ranges::any_of(bank->maps, isOver)) bank->maps.clear();
    bank->used = 0;
    for (const Map& map : bank->maps)
      bank->used = std::max(bank->used, uint64_t{map.view.firstWord} + map.words);
  }
}

// One with the same light and hair.
ShadowMaps::Map* ShadowMaps::findMap(Bank& bank, const StrandShadowPlan& plan, const ShadowPlan& of,
                                     uint64_t frame) {
  for (Map& map : bank.maps) {
    if (map.opaque != BufferId::kInvalid || map.hairs != of.hairs || map.moves != of.moves ||
        !isKnown(map.maker, frame))
      continue;
    StrandShadowView view = plan.view;
    view.firstWord = map.view.firstWord;
    if (isEqual(view, map.view)) return &map;
  }
  return nullptr;
}

// One of this frame: an engine fills its map before the first view that reads it.
ShadowMaps::Map* ShadowMaps::findOpaque(Bank& bank, const OpaqueShadowPlan& plan, uint64_t frame) {
  for (Map& map : bank.maps)
    if (map.opaque == plan.depth && map.words == plan.words && map.frame == frame &&
        isKnown(map.maker, frame))
      return &map;
  return nullptr;
}

uint64_t ShadowMaps::missingWords(Bank& bank, const ShadowPlan& plan, uint64_t frame) {
  uint64_t words = 0;
  for (const StrandShadowPlan& map : plan.maps)
    if (findMap(bank, map, plan, frame) == nullptr) words += map.words;
  for (const OpaqueShadowPlan& opaque : plan.opaques)
    if (findOpaque(bank, opaque, frame) == nullptr) words += opaque.words;
  return words;
}

Result<ShadowMaps::Choice> ShadowMaps::choose(const ShadowPlan& plan, const BufferFactory& factory,
                                              uint64_t frame) const {
  if (plan.words == 0) {
    if (banks_.empty()) return Choice{.bank = 0, .empties = true, .words = kLeastWords};
    return Choice{};
  }
  size_t bank = banks_.size();
  for (size_t i = 0; i < banks_.size(); ++i) {
    if (missingWords(*banks_[i], plan, frame) == 0) return Choice{.bank = i};
    if (bank == banks_.size() && banks_[i]->tickets.isFree(frame)) bank = i;
  }
  for (size_t i = 0; i < banks_.size(); ++i) {
    const bool inUse = !banks_[i]->tickets.isFree(frame) ||
                       std::any_of(banks_[i]->maps.begin(), banks_[i]->maps.end(),
                                   [&](const Map& map) { return isKnown(map.maker, frame); });
    const uint64_t end = banks_[i]->used + missingWords(*banks_[i], plan, frame);
    if (inUse && end <= std::min(wordsOf(factory, banks_[i]->words), kMostWords))
      return Choice{.bank = i};
  }
  const Result<uint64_t> words = limit(plan.words, bank, factory, frame);
  if (!words) return words.error();
  return Choice{.bank = bank, .empties = true, .words = std::max(*words, kLeastWords)};
}

// Words of a bank beside banks that lists still need: `words` at least, and under the cap as many
// as keep the next frame from making maps twice.
Result<uint64_t> ShadowMaps::limit(uint64_t words, size_t bank, const BufferFactory& factory,
                                   uint64_t frame) const {
  uint64_t others = 0;
  for (size_t i = 0; i < banks_.size(); ++i)
    if (i != bank && !banks_[i]->tickets.isFree(frame)) others += factory.bytesOf(banks_[i]->words);
  const uint64_t bytes = words * sizeof(uint32_t);
  if (others + bytes > maxBytes) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("view: shadow maps take {} bytes{}, but Scene::setShadowMemory() "
                    "allows {}: use fewer texels or layers",
                    bytes, others > 0 ? fmt::format(" beside {} of earlier views", others) : "",
                    maxBytes)};
  }
  const uint64_t grown =
      std::min(std::max(frame != frame_ ? wanted_ : uint64_t{0}, words), kMostWords);
  return others + grown * sizeof(uint32_t) <= maxBytes ? grown : words;
}

ShadowMaps::Bank& ShadowMaps::prepare(const Choice& choice, const BufferFactory& factory,
                                      uint64_t frame) {
  if (choice.bank == banks_.size()) banks_.push_back(std::make_unique<Bank>());
  Bank& bank = *banks_[choice.bank];
  if (!choice.empties) {
    const bool old = std::none_of(bank.maps.begin(), bank.maps.end(),
                                  [&](const Map& map) { return isKnown(map.maker, frame); });
    if (old && bank.tickets.isFree(frame)) {
      bank.maps.clear();
      bank.used = 0;
    }
    return bank;
  }
  const bool created = bank.tickets.hasRun();
  bank.tickets.lose(kShadowsRemade);
  bank.maps.clear();
  bank.used = 0;
  // Where it holds what several did, the others are of no use any more.
  if (choice.words > wordsOf(factory, bank.words)) {
    std::erase_if(banks_, [&](const std::unique_ptr<Bank>& other) {
      if (other.get() == &bank || !other->tickets.isFree(frame)) return false;
      other->tickets.lose(kShadowsRemade);
      factory.remove(other->words);
      return true;
    });
  }
  const bool made = factory.ensureCapacity(
      {bank.words, "shadows/words", choice.words * sizeof(uint32_t), sizeof(uint32_t)}, !created);
  if (made) bank.tickets.forgetRuns();
  return bank;
}

// The table gets content_.
ShadowMaps::Table& ShadowMaps::prepareTable(bool complete, const BufferFactory& factory,
                                            uint64_t frame) {
  Table* free = nullptr;
  for (const std::unique_ptr<Table>& table : tables_) {
    const bool equal = complete && isKnown(table->maker, frame) &&
                       std::ranges::equal(content_, table->content, isEqual);
    if (equal || content_.empty()) return *table;
    if (free == nullptr && table->tickets.isFree(frame)) free = table.get();
  }
  if (free == nullptr) {
    tables_.push_back(std::make_unique<Table>());
    free = tables_.back().get();
    factory.ensureCapacity({free->views, "shadows/views",
                            kMaxStrandShadows * sizeof(StrandShadowView), sizeof(StrandShadowView),
                            BufferUsage::kStorage | BufferUsage::kUpload});
  }
  free->tickets.lose(kShadowsRemade);
  free->content = content_;
  free->maker = nullptr;
  return *free;
}

Result<void> ShadowMaps::record(ShadowPlan& plan, std::span<const ShadowedHair> hairs,
                                const BufferFactory& factory, uint64_t frame, PassList& list) {
  const Result<Choice> choice = choose(plan, factory, frame);
  if (!choice) return choice.error();
  if (frame != frame_ && plan.words > 0) {
    wanted_ = 0;
    frame_ = frame;
  }
  if (choice->empties) {
    for (const std::unique_ptr<Bank>& bank : banks_) {
      const uint64_t missing = missingWords(*bank, plan, frame);
      if (missing < plan.words) wanted_ = std::max(wanted_, bank->used + missing);
    }
  }
  const std::shared_ptr<ListTicket> ticket = ticketOf(list, frame);
  bank_ = &prepare(*choice, factory, frame);
  bank_->frame = frame;

  uint32_t missing = 0;  // maps, as bits
  static_assert(kMaxStrandShadows <= 32);
  content_.clear();
  for (StrandShadowPlan& map : plan.maps) {
    Map* known = findMap(*bank_, map, plan, frame);
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
  table_ = &prepareTable(complete, factory, frame);
  words_ = bank_->words;
  views_ = table_->views;
  const bool known = complete && table_->maker != nullptr;
  // Without maps nothing is read of the table, whoever has filled it last.
  if (known && !content_.empty()) need(ticket, table_->maker);
  for (size_t i = 0; i < plan.maps.size() && !known; ++i) {
    table_->maker = ticket;
    StrandShadowBuffers buffers;
    buffers.views = views_;
    buffers.viewCount = kMaxStrandShadows;
    buffers.view = static_cast<uint32_t>(i);
    buffers.words = words_;
    buffers.wordCount = wordsOf(factory, words_);
    if ((missing >> i & 1) == 0) {
      addUpload(list, views_, std::as_bytes(std::span(&content_[i], 1)),
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
    if (Map* known = findOpaque(*bank_, opaque, frame); known != nullptr) {
      opaque.firstWord = known->view.firstWord;
      need(ticket, known->maker);
      continue;
    }
    opaque.firstWord = static_cast<uint32_t>(bank_->used);
    bank_->used += opaque.words;
    StrandShadowView view = {};
    view.firstWord = opaque.firstWord;
    bank_->maps.push_back({view, opaque.depth, opaque.words, 0, 0, frame, ticket});
    if (Result<void> added = addOpaqueShadow(list, opaque, words_, wordsOf(factory, words_));
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
  for (const std::unique_ptr<Bank>& bank : banks_) bank->maps.clear();
  for (const std::unique_ptr<Table>& table : tables_) table->maker = nullptr;
}

uint64_t ShadowMaps::bytes(const ResourceTable& resources) const {
  uint64_t bytes = 0;
  const auto add = [&](BufferId buffer) {
    const BufferDesc* desc = resources.find(buffer);
    bytes += desc != nullptr ? desc->size : 0;
  };
  for (const std::unique_ptr<Bank>& bank : banks_) add(bank->words);
  for (const std::unique_ptr<Table>& table : tables_) add(table->views);
  return bytes;
}

void ShadowMaps::trim(const BufferFactory& factory, const char* reason) {
  for (const std::unique_ptr<Bank>& bank : banks_) {
    bank->tickets.lose(reason);
    factory.remove(bank->words);
  }
  for (const std::unique_ptr<Table>& table : tables_) {
    table->tickets.lose(reason);
    factory.remove(table->views);
  }
  banks_.clear();
  tables_.clear();
  words_ = views_ = BufferId::kInvalid;
  bank_ = nullptr;
  table_ = nullptr;
}

}  // namespace pelage::detail
