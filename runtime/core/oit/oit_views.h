// Transparency of views: their passes, and buffers for each view whose lists are still to run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "oit/material_batches.h"
#include "oit/transparency.h"
#include "passes/buffer_factory.h"
#include "passes/list_ticket.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/transparency.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

/// Usage of the buffer of strands in screen space.
inline constexpr BufferUsage kRecordUsage = BufferUsage::kStorage | BufferUsage::kVertex;
/// Blends a resolved picture of hair over the target.
DrawState overTarget();

/// The buffers of one view. Each is made by the first draw that needs it, and only grows.
struct OitBuffers {
  /// Per-pixel linked lists; their layout is in kernels/oit/layouts/ppll_build.hlsli.
  struct Lists {
    BufferId heads = BufferId::kInvalid, nodes = BufferId::kInvalid, counters = BufferId::kInvalid,
             tiles = BufferId::kInvalid, tail = BufferId::kInvalid;
  } lists;
  /// Methods with a fixed number of layers; see kernels/oit/layouts/hybrid_depths.hlsli,
  /// hybrid_colors.hlsl and short_cut_*.hlsli.
  struct Layers {
    BufferId depths = BufferId::kInvalid, colors = BufferId::kInvalid, tail = BufferId::kInvalid,
             counters = BufferId::kInvalid, tiles = BufferId::kInvalid;
  } hybrid, shortCut;
  /// Strands in tiles; see kernels/oit/layouts/strand_tiles.hlsli. Counters are those of lists.
  struct Tiles {
    BufferId records = BufferId::kInvalid, pixels = BufferId::kInvalid, tiles = BufferId::kInvalid,
             fragments = BufferId::kInvalid, visible = BufferId::kInvalid,
             sums = BufferId::kInvalid, picture = BufferId::kInvalid;
  } strands;

  std::vector<BufferId*> all();
};

/// The checked plan of a draw, made before anything changes.
struct OitPlan {
  MaterialBatches batches;  ///< of methods that keep materials
  uint64_t vertices = 0;    ///< of the largest of them
  TransparencyPlan sizes;
  uint64_t recordBytes = 0;  ///< where hair is transformed first
};

/// One draw of a view, as the methods take it.
struct OitDraw {
  const DrawnView& view;
  const TransparencySettings& settings;
  const OitPlan& plan;
  OitBuffers& buffers;
  BufferFactory factory;
  std::string suffix;   ///< of buffers' names
  bool exact = false;   ///< buffers that are too large were never created: make them anew, too
  bool remade = false;  ///< one was made

  void ensureCapacity(BufferId& buffer, const char* name, uint64_t bytes, uint32_t stride,
                      BufferUsage usage = BufferUsage::kStorage) {
    remade |= factory.ensureCapacity({buffer, name, bytes, stride, usage, suffix}, exact);
  }
};

Result<void> addListPasses(OitDraw& draw, const MaterialBatch& batch, PassList& buildList,
                           PassList& resolveList);
Result<void> addTilePasses(OitDraw& draw, const MaterialBatch& batch, PassList& list);
Result<void> addHybridPasses(OitDraw& draw, uint32_t layers, std::vector<PassList>& lists);
Result<void> addShortCutPasses(OitDraw& draw, std::vector<PassList>& lists);

class OitViews {
 public:
  /// Errors: those of planTransparency(); opaqueDepth that is too small; engineLights that lack a
  /// kernel. Notes the lights in the view.
  static Result<void> check(DrawnView& view, const TransparencySettings& settings,
                            const BufferFactory& factory, OitPlan& plan);
  /// Adds the passes of a method. The view gets the first buffers that no list names which is still
  /// to run: so views of a frame have buffers of their own, and the next frame has them again.
  /// \param lists as many as the method needs are made; those from 1 on are empty.
  Result<void> record(DrawnView& view, const TransparencySettings& settings, const OitPlan& plan,
                      const BufferFactory& factory, uint64_t frame, std::vector<PassList>& lists);
  /// Counters of the lists or tiles of the view that was drawn last; kInvalid before the first one.
  BufferId counters() const;
  /// Tiles of the view that was drawn last; buffers are kInvalid where it has none.
  const TransparencyTiles& tiles() const { return tiles_; }
  /// [view] bytes of its buffers, for all methods it has had.
  std::vector<uint64_t> bytes(const ResourceTable& resources) const;
  /// Frees all buffers. \param reason why lists that have not run cannot any more.
  void trim(const BufferFactory& factory, const char* reason);

 private:
  struct Slot {
    OitBuffers buffers;
    TicketSet tickets;
  };
  size_t freeSlot(uint64_t frame);
  std::vector<std::unique_ptr<Slot>> slots_;
  size_t last_ = 0;
  TransparencyTiles tiles_;  // of the last view
};

}  // namespace pelage::detail
