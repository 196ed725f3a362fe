// Shadow maps: each light has one map, whatever number of views sees it, for as long as neither it
// nor hair changes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "passes/buffer_factory.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "shadow/opaque_shadow.h"
#include "shadow/shadow_banks.h"
#include "shadow/strand_shadow.h"

namespace pelage::detail {

class ShadowMaps {
 public:
  /// Bytes that the maps of a frame may take.
  void setMaxBytes(uint64_t bytes) { banks_.maxBytes = bytes; }

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
  BufferId words() const { return bank_ != nullptr ? bank_->words : BufferId::kInvalid; }
  BufferId views() const { return table_ != nullptr ? table_->views : BufferId::kInvalid; }

 private:
  Result<void> recordOpaques(ShadowPlan& plan, const BufferFactory& factory, uint64_t frame,
                             PassList& list);

  ShadowBanks banks_;
  ShadowTables tables_;
  ShadowedHairs hairs_;
  std::vector<StrandShadowView> content_;  ///< of the table at hand; memory that is kept
  ShadowBank* bank_ = nullptr;             ///< of the last record()
  ShadowTable* table_ = nullptr;           ///< likewise
};

}  // namespace pelage::detail
