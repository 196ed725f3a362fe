// Buffers that several lists take in turn: which lists still need what is in them.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "passes/handles.h"
#include "passes/list_run.h"
#include "pelage/pass_list.h"

namespace pelage::detail {

/// The account of a list that names such buffers, and of its copies. Who shares the buffers out
/// holds it, too.
struct ListTicket {
  uint64_t frame = 0;                 ///< in which the list was written
  HandleArray<RunRecord> runs;        ///< of the list and of its copies; empty before the barriers
  HandleArray<ListTicket> needs;      ///< of lists that write what this one reads
  const char* lost = nullptr;         ///< why the buffers are not the list's any more
  std::atomic<bool> dropped = false;  ///< no copy is left
};

/// Shared by the copies of a list.
struct ListHold {
  std::shared_ptr<ListTicket> ticket;
  ListHold() = default;
  ~ListHold();
  ListHold(const ListHold&) = delete;
  ListHold& operator=(const ListHold&) = delete;
};

/// The ticket of a list that is being written in this frame. A list has one.
std::shared_ptr<ListTicket> ticketOf(PassList& list, uint64_t frame);

/// Whether the list may still run, so that its buffers are not free. Until it has its barriers it
/// may in the frame that it was written in; where it was recorded but not submitted, that frame has
/// it still.
bool isPending(const ListTicket& ticket, uint64_t frame);
/// Whether what the list writes is there for lists that run after it.
bool isMade(const ListTicket& ticket, uint64_t frame);
/// Whether the list has been recorded or has run.
bool hasRun(const ListTicket& ticket);

/// Takes the list's buffers away: it does not run any more. \param reason behind "the list was
/// abandoned: "; of static lifetime.
void lose(ListTicket& ticket, const char* reason);

/// Notes the run of a list that has just got its barriers.
/// \return why it is not to run; nullptr where it may.
const char* noteRun(PassList& list);

/// Tickets of the lists that name one set of buffers.
class TicketSet {
 public:
  void add(const std::shared_ptr<ListTicket>& ticket);
  /// No list needs the buffers.
  bool isFree(uint64_t frame) const;
  /// Takes the buffers from all lists.
  void lose(const char* reason);
  /// A list with the buffers has been recorded since the last call of forgetRuns(): they could be
  /// created.
  bool hasRun();
  void forgetRuns() { ran_ = false; }

 private:
  std::vector<std::shared_ptr<ListTicket>> tickets_;
  bool ran_ = false;  ///< one that is not among them any more
};

}  // namespace pelage::detail
