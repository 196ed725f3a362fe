// Colors of strands from textures of engines: a pass for each object of a view that has one. Each
// view has a buffer for them, of this room's own.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "passes/buffer_factory.h"
#include "passes/list_ticket.h"
#include "pelage/hair_buffers.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/strand_texture.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

/// Describes the error in an object's texture; empty if there is none.
std::string faultOf(const StrandTexture& texture, const HairBuffers& buffers);

class StrandColors {
 public:
  /// Adds the passes of a view, and notes in its objects where their colors are. Adds nothing where
  /// none has a texture.
  Result<void> record(DrawnView& view, const BufferFactory& factory, uint64_t frame,
                      PassList& list);
  /// Notes the lists of a view that read what record() was called for last, behind it.
  void share(const DrawnView& view, std::span<PassList> lists, uint64_t frame);
  /// Frees all buffers. \param reason why lists that have not run cannot any more.
  void trim(const BufferFactory& factory, const char* reason);

 private:
  struct Slot {
    BufferId colors = BufferId::kInvalid;
    TicketSet tickets;
  };
  Slot& freeSlot(uint64_t frame);
  std::vector<std::unique_ptr<Slot>> slots_;
  Slot* last_ = nullptr;
};

}  // namespace pelage::detail
