#include "shadow/shadow_banks.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
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

}  // namespace

bool isKnown(const std::shared_ptr<ListTicket>& maker, uint64_t frame) {
  return maker != nullptr && isMade(*maker, frame);
}

void ShadowBanks::beginFrame(uint64_t frame, uint64_t moves) {
  if (std::exchange(begun_, frame) == frame) return;
  for (const std::unique_ptr<ShadowBank>& bank : banks_) {
    if (!bank->tickets.isFree(frame)) continue;
    std::erase_if(bank->maps,
                  [](const ShadowMap& map) { return map.opaque != BufferId::kInvalid; });
    const auto isOver = [&](const ShadowMap& map) {
      return map.frame != bank->lastFrame || map.moves != moves;
    };
    if (std::ranges::any_of(bank->maps, isOver)) bank->maps.clear();
    bank->used = 0;
    for (const ShadowMap& map : bank->maps)
      bank->used = std::max(bank->used, uint64_t{map.view.firstWord} + map.words);
  }
}

ShadowMap* ShadowBank::find(const StrandShadowPlan& map, const ShadowPlan& plan, uint64_t frame) {
  for (ShadowMap& known : maps) {
    if (known.opaque != BufferId::kInvalid || known.hairs != plan.hairs ||
        known.moves != plan.moves || !isKnown(known.maker, frame))
      continue;
    StrandShadowView view = map.view;
    view.firstWord = known.view.firstWord;
    if (isEqual(view, known.view)) return &known;
  }
  return nullptr;
}

ShadowMap* ShadowBank::find(const OpaqueShadowPlan& plan, uint64_t frame) {
  for (ShadowMap& map : maps)
    if (map.opaque == plan.depth && map.words == plan.words && map.frame == frame &&
        isKnown(map.maker, frame))
      return &map;
  return nullptr;
}

uint64_t ShadowBank::missingWords(const ShadowPlan& plan, uint64_t frame) {
  uint64_t missing = 0;
  for (const StrandShadowPlan& map : plan.maps)
    if (find(map, plan, frame) == nullptr) missing += map.words;
  for (const OpaqueShadowPlan& opaque : plan.opaques)
    if (find(opaque, frame) == nullptr) missing += opaque.words;
  return missing;
}

bool ShadowBank::hasKnownMap(uint64_t frame) const {
  return std::ranges::any_of(maps, [&](const ShadowMap& map) { return isKnown(map.maker, frame); });
}

Result<ShadowBanks::Choice> ShadowBanks::choose(const ShadowPlan& plan,
                                                const BufferFactory& factory,
                                                uint64_t frame) const {
  if (plan.words == 0) {
    if (banks_.empty()) return Choice{.bank = 0, .empties = true, .words = kLeastWords};
    return Choice{};
  }
  size_t bank = banks_.size();
  for (size_t i = 0; i < banks_.size(); ++i) {
    if (banks_[i]->missingWords(plan, frame) == 0) return Choice{.bank = i};
    if (bank == banks_.size() && banks_[i]->tickets.isFree(frame)) bank = i;
  }
  for (size_t i = 0; i < banks_.size(); ++i) {
    const bool inUse = !banks_[i]->tickets.isFree(frame) || banks_[i]->hasKnownMap(frame);
    const uint64_t end = banks_[i]->used + banks_[i]->missingWords(plan, frame);
    if (inUse && end <= std::min(wordsOf(factory, banks_[i]->words), kMostWords))
      return Choice{.bank = i};
  }
  const Result<uint64_t> words = limit(plan.words, bank, factory, frame);
  if (!words) return words.error();
  return Choice{.bank = bank, .empties = true, .words = std::max(*words, kLeastWords)};
}

// Words of a bank beside banks that lists still need: `words` at least, and under the cap as many
// as keep the next frame from making maps twice.
Result<uint64_t> ShadowBanks::limit(uint64_t words, size_t bank, const BufferFactory& factory,
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

ShadowBank& ShadowBanks::prepare(const Choice& choice, const BufferFactory& factory,
                                 uint64_t frame) {
  if (choice.bank == banks_.size()) banks_.push_back(std::make_unique<ShadowBank>());
  ShadowBank& bank = *banks_[choice.bank];
  if (!choice.empties) {
    if (!bank.hasKnownMap(frame) && bank.tickets.isFree(frame)) bank.clear();
    return bank;
  }
  const bool created = bank.tickets.hasRun();
  bank.tickets.lose(kShadowsRemade);
  bank.clear();
  // Where it holds what several did, the others are of no use any more.
  if (choice.words > wordsOf(factory, bank.words)) {
    std::erase_if(banks_, [&](const std::unique_ptr<ShadowBank>& other) {
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

Result<void> ShadowBanks::check(const ShadowPlan& plan, const BufferFactory& factory,
                                uint64_t frame) const {
  const Result<Choice> choice = choose(plan, factory, frame);
  return choice ? Result<void>() : choice.error();
}

Result<ShadowBank*> ShadowBanks::take(const ShadowPlan& plan, const BufferFactory& factory,
                                      uint64_t frame) {
  const Result<Choice> choice = choose(plan, factory, frame);
  if (!choice) return choice.error();
  if (frame != frame_ && plan.words > 0) {
    wanted_ = 0;
    frame_ = frame;
  }
  if (choice->empties) {
    for (const std::unique_ptr<ShadowBank>& bank : banks_) {
      const uint64_t missing = bank->missingWords(plan, frame);
      if (missing < plan.words) wanted_ = std::max(wanted_, bank->used + missing);
    }
  }
  ShadowBank& bank = prepare(*choice, factory, frame);
  bank.lastFrame = frame;
  return &bank;
}

void ShadowBanks::forget() {
  for (const std::unique_ptr<ShadowBank>& bank : banks_) bank->maps.clear();
}

uint64_t ShadowBanks::bytes(const ResourceTable& resources) const {
  uint64_t bytes = 0;
  for (const std::unique_ptr<ShadowBank>& bank : banks_) bytes += resources.whole(bank->words).size;
  return bytes;
}

void ShadowBanks::trim(const BufferFactory& factory, const char* reason) {
  for (const std::unique_ptr<ShadowBank>& bank : banks_) {
    bank->tickets.lose(reason);
    factory.remove(bank->words);
  }
  banks_.clear();
}

ShadowTable& ShadowTables::take(std::span<const StrandShadowView> content, bool complete,
                                const BufferFactory& factory, uint64_t frame) {
  ShadowTable* free = nullptr;
  for (const std::unique_ptr<ShadowTable>& table : tables_) {
    const bool equal = complete && isKnown(table->maker, frame) &&
                       std::ranges::equal(content, table->content, isEqual);
    if (equal || content.empty()) return *table;
    if (free == nullptr && table->tickets.isFree(frame)) free = table.get();
  }
  if (free == nullptr) {
    tables_.push_back(std::make_unique<ShadowTable>());
    free = tables_.back().get();
    factory.ensureCapacity({free->views, "shadows/views",
                            kMaxStrandShadows * sizeof(StrandShadowView), sizeof(StrandShadowView),
                            BufferUsage::kStorage | BufferUsage::kUpload});
  }
  free->tickets.lose(kShadowsRemade);
  free->content.assign(content.begin(), content.end());
  free->maker = nullptr;
  return *free;
}

void ShadowTables::forget() {
  for (const std::unique_ptr<ShadowTable>& table : tables_) table->maker = nullptr;
}

uint64_t ShadowTables::bytes(const ResourceTable& resources) const {
  uint64_t bytes = 0;
  for (const std::unique_ptr<ShadowTable>& table : tables_)
    bytes += resources.whole(table->views).size;
  return bytes;
}

void ShadowTables::trim(const BufferFactory& factory, const char* reason) {
  for (const std::unique_ptr<ShadowTable>& table : tables_) {
    table->tickets.lose(reason);
    factory.remove(table->views);
  }
  tables_.clear();
}

std::optional<size_t> ShadowedHairs::numberOf(std::span<const ShadowedHair> hairs, uint64_t moves) {
  if (std::exchange(moves_, moves) != moves) count_ = 0;
  for (size_t i = 0; i < count_; ++i)
    if (std::ranges::equal(hairs, hairs_[i])) return i;
  if (count_ == kMostHairs) {
    count_ = 0;
    return std::nullopt;
  }
  if (count_ == hairs_.size()) hairs_.emplace_back();
  hairs_[count_].assign(hairs.begin(), hairs.end());
  return count_++;
}

}  // namespace pelage::detail
