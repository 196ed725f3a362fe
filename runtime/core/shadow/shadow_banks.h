// The memory of shadow maps: banks of maps, tables for shaders, and which hair maps are of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "passes/buffer_factory.h"
#include "passes/list_ticket.h"
#include "pelage/gpu_structs.h"
#include "pelage/result.h"
#include "shadow/opaque_shadow.h"
#include "shadow/strand_shadow.h"

namespace pelage::detail {

/// The maps of a view's lights, found out before anything changes.
struct ShadowPlan {
  std::vector<StrandShadowPlan> maps;  ///< in the order of the lights; firstWord is not known yet
  std::vector<OpaqueShadowPlan> opaques;  ///< likewise
  uint64_t words = 0;                     ///< of all of them
  size_t hairs = 0;                       ///< number of the hair that is in them
  uint64_t moves = 0;                     ///< HairStore::moves
};

struct ShadowMap {
  StrandShadowView view;                 ///< with its offset; the only member that depth maps use
  BufferId opaque = BufferId::kInvalid;  ///< what that is a copy of
  uint32_t words = 0;
  size_t hairs = 0;  ///< ShadowPlan::hairs
  uint64_t moves = 0;
  uint64_t frame = 0;  ///< of its last reader
  std::shared_ptr<ListTicket> maker;
};

/// Maps that are in one buffer.
struct ShadowBank {
  BufferId words = BufferId::kInvalid;
  uint64_t used = 0;       ///< words
  uint64_t lastFrame = 0;  ///< of its last reader
  std::vector<ShadowMap> maps;
  TicketSet tickets;

  /// One with the same light and hair, or nullptr.
  ShadowMap* find(const StrandShadowPlan& map, const ShadowPlan& plan, uint64_t frame);
  /// One of this frame: an engine fills its map before the first view that reads it.
  ShadowMap* find(const OpaqueShadowPlan& plan, uint64_t frame);
  uint64_t missingWords(const ShadowPlan& plan, uint64_t frame);
  bool hasKnownMap(uint64_t frame) const;
  void clear() {
    maps.clear();
    used = 0;
  }
};

/// A view's maps are all in one bank.
class ShadowBanks {
 public:
  uint64_t maxBytes = uint64_t{1} << 30;  ///< of all maps of a frame

  /// Drops the maps that no view is going to read again, so that lights that move take no more
  /// room from frame to frame: all of a bank where the last frame left one of them unread.
  void beginFrame(uint64_t frame, uint64_t moves);
  /// Errors: maps that leave no room under maxBytes.
  Result<void> check(const ShadowPlan& plan, const BufferFactory& factory, uint64_t frame) const;
  /// The bank for the maps of a plan.
  Result<ShadowBank*> take(const ShadowPlan& plan, const BufferFactory& factory, uint64_t frame);
  void forget();
  uint64_t bytes(const ResourceTable& resources) const;
  void trim(const BufferFactory& factory, const char* reason);

 private:
  /// Where a view has its maps.
  struct Choice {
    size_t bank = 0;       ///< one behind the last is made
    bool empties = false;  ///< its maps go
    uint64_t words = 0;    ///< that it has to have
  };
  Result<Choice> choose(const ShadowPlan& plan, const BufferFactory& factory, uint64_t frame) const;
  Result<uint64_t> limit(uint64_t words, size_t bank, const BufferFactory& factory,
                         uint64_t frame) const;
  ShadowBank& prepare(const Choice& choice, const BufferFactory& factory, uint64_t frame);

  std::vector<std::unique_ptr<ShadowBank>> banks_;
  uint64_t begun_ = 0;   ///< frame of the last beginFrame()
  uint64_t frame_ = 0;   ///< of the last take()
  uint64_t wanted_ = 0;  ///< capacity [words] that would have avoided drawing a map twice
};

/// The table of a view's maps for shaders.
struct ShadowTable {
  BufferId views = BufferId::kInvalid;
  std::vector<StrandShadowView> content;
  std::shared_ptr<ListTicket> maker;
  TicketSet tickets;
};

class ShadowTables {
 public:
  /// The table with a content. \param complete  all its maps have been made
  ShadowTable& take(std::span<const StrandShadowView> content, bool complete,
                    const BufferFactory& factory, uint64_t frame);
  void forget();
  uint64_t bytes(const ResourceTable& resources) const;
  void trim(const BufferFactory& factory, const char* reason);

 private:
  std::vector<std::unique_ptr<ShadowTable>> tables_;
};

/// The sets of hair that maps are of.
class ShadowedHairs {
 public:
  /// Number of a set, new where hair has moved; nothing where there are too many, which forgets
  /// all.
  std::optional<size_t> numberOf(std::span<const ShadowedHair> hairs, uint64_t moves);

 private:
  std::vector<std::vector<ShadowedHair>> hairs_;  ///< [number], since hair moved last
  size_t count_ = 0;                              ///< the others are memory that is kept
  uint64_t moves_ = 0;
};

/// Whether a list that has run, or is of this frame, makes it.
bool isKnown(const std::shared_ptr<ListTicket>& maker, uint64_t frame);

}  // namespace pelage::detail
