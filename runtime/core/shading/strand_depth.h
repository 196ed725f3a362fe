// Draws of depth and motion of strands. Where the vertex stage has no storage buffers, each view
// has a buffer for its strands on the screen, of this room's own.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "passes/buffer_factory.h"
#include "passes/list_ticket.h"
#include "pelage/hair_depth.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

class StrandDepths {
 public:
  /// Changes nothing but where the objects' records begin. Errors: strands that are larger than the
  /// settings allow, where they are transformed first.
  static Result<void> check(DrawnView& view, const HairDepthSettings& settings);
  /// Adds the passes and draws of a view, behind check().
  Result<void> record(DrawnView& view, const HairDepthSettings& settings,
                      const BufferFactory& factory, uint64_t frame, PassList& list);
  /// Frees all buffers. \param reason why lists that have not run cannot any more.
  void trim(const BufferFactory& factory, const char* reason);

 private:
  struct Slot {
    BufferId records = BufferId::kInvalid;
    TicketSet tickets;
  };
  Slot& freeSlot(uint64_t frame);
  std::vector<std::unique_ptr<Slot>> slots_;
};

}  // namespace pelage::detail
