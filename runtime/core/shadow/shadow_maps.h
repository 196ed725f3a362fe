// Shadow maps: each light has one map, whatever number of views sees it, for as long as neither it
// nor hair changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "passes/buffer_factory.h"
#include "passes/list_ticket.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
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

class ShadowMaps {
 public:
  /// Bytes that the maps of a frame may take.
  uint64_t maxBytes = uint64_t{1} << 30;

  /// \param defs of the lights of a view that have a map, \param opaques of those that have one of
  /// opaque geometry, \param moves HairStore::moves. Errors: those of planStrandShadow(); maps that
  /// leave no room under maxBytes.
  Result<void> check(std::span<const StrandShadowDef> defs,
                     std::span<const OpaqueShadowPlan> opaques, std::span<const ShadowedHair> hairs,
                     const BufferFactory& factory, uint64_t frame, uint64_t moves,
                     ShadowPlan& plan);
  /// Adds the passes of the maps that no list has made since hair moved last, and uploads their
  /// table for shaders. \param plan of check(); gets the offsets of the maps.
  Result<void> record(ShadowPlan& plan, std::span<const ShadowedHair> hairs,
                      const BufferFactory& factory, uint64_t frame, PassList& list);
  /// Lists that read the maps of the last record(), besides the one that made them.
  void share(std::span<PassList> lists, uint64_t frame);
  /// Hair or the world has changed: no map is used again.
  void forget();
  /// Bytes of all maps and their tables.
  uint64_t bytes(const ResourceTable& resources) const;
  /// Frees all buffers. \param reason why lists that have not run cannot any more.
  void trim(const BufferFactory& factory, const char* reason);

  /// Buffers of the last record(); kInvalid before it.
  BufferId words() const { return words_; }
  BufferId views() const { return views_; }

 private:
  struct Map {
    StrandShadowView view;                 ///< with its offset; the only member that depth maps use
    BufferId opaque = BufferId::kInvalid;  ///< what that is a copy of
    uint32_t words = 0;
    size_t hairs = 0;  ///< ShadowPlan::hairs
    uint64_t moves = 0;
    uint64_t frame = 0;  ///< of its last reader
    std::shared_ptr<ListTicket> maker;
  };
  /// Maps that are in one buffer.
  struct Bank {
    BufferId words = BufferId::kInvalid;
    uint64_t used = 0;   ///< words
    uint64_t frame = 0;  ///< of its last reader
    std::vector<Map> maps;
    TicketSet tickets;
  };
  /// The table of a view's maps for shaders.
  struct Table {
    BufferId views = BufferId::kInvalid;
    std::vector<StrandShadowView> content;
    std::shared_ptr<ListTicket> maker;
    TicketSet tickets;
  };
  /// Where a view has its maps.
  struct Choice {
    size_t bank = 0;       ///< one behind the last is made
    bool empties = false;  ///< its maps go
    uint64_t words = 0;    ///< that it has to have
  };
  static Map* findMap(Bank& bank, const StrandShadowPlan& map, const ShadowPlan& plan,
                      uint64_t frame);
  static Map* findOpaque(Bank& bank, const OpaqueShadowPlan& plan, uint64_t frame);
  static uint64_t missingWords(Bank& bank, const ShadowPlan& plan, uint64_t frame);
  Result<Choice> choose(const ShadowPlan& plan, const BufferFactory& factory, uint64_t frame) const;
  size_t numberOf(std::span<const ShadowedHair> hairs, uint64_t moves);
  void beginFrame(uint64_t frame, uint64_t moves);
  Result<uint64_t> limit(uint64_t words, size_t bank, const BufferFactory& factory,
                         uint64_t frame) const;
  Result<void> recordOpaques(ShadowPlan& plan, const BufferFactory& factory, uint64_t frame,
                             PassList& list);
  Bank& prepare(const Choice& choice, const BufferFactory& factory, uint64_t frame);
  Table& prepareTable(bool complete, const BufferFactory& factory, uint64_t frame);

  std::vector<std::unique_ptr<Bank>> banks_;
  std::vector<std::unique_ptr<Table>> tables_;
  // Memory that is kept from frame to frame.
  std::vector<StrandShadowView> content_;         ///< of the table at hand
  std::vector<std::vector<ShadowedHair>> hairs_;  ///< [number], since hair moved last
  size_t hairCount_ = 0;
  uint64_t moves_ = 0;  ///< of them
  uint64_t begun_ = 0;  ///< frame of the last check()
  BufferId words_ = BufferId::kInvalid, views_ = BufferId::kInvalid;
  Bank* bank_ = nullptr;  ///< of the last record()
  Table* table_ = nullptr;
  uint64_t frame_ = 0;   ///< of the last record()
  uint64_t wanted_ = 0;  ///< capacity [words] that would have avoided drawing a map twice
};

}  // namespace pelage::detail
