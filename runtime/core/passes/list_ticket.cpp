#include "passes/list_ticket.h"

#include <algorithm>
#include <utility>

namespace pelage::detail {

namespace {

bool isAny(const ListTicket& ticket, RunState wanted) {
  return std::any_of(ticket.runs.begin(), ticket.runs.end(),
                     [&](const auto& run) { return stateOf(*run) == wanted; });
}

}  // namespace

ListHold::~ListHold() { ticket->dropped = true; }

std::shared_ptr<ListTicket> ticketOf(PassList& list, uint64_t frame) {
  if (list.hold != nullptr) {
    const std::shared_ptr<ListTicket>& held = list.hold->ticket;
    if (held->frame == frame && held->runs.empty() && held->lost == nullptr) return held;
  }
  std::shared_ptr<ListTicket> ticket = makeHandle<ListTicket>();  // first: a hold always has one
  ticket->frame = frame;
  std::shared_ptr<ListHold> hold = makeHandle<ListHold>();
  hold->ticket = std::move(ticket);
  list.hold = std::move(hold);
  return list.hold->ticket;
}

bool isPending(const ListTicket& ticket, uint64_t frame) {
  if (ticket.lost != nullptr) return false;
  if (ticket.runs.empty()) return !ticket.dropped && ticket.frame == frame;
  return isAny(ticket, RunState::kOpen) ||
         (ticket.frame == frame && isAny(ticket, RunState::kRecorded));
}

bool isMade(const ListTicket& ticket, uint64_t frame) {
  return isPending(ticket, frame) || hasRun(ticket);
}

bool hasRun(const ListTicket& ticket) {
  return isAny(ticket, RunState::kDelivered) || isAny(ticket, RunState::kRecorded);
}

void lose(ListTicket& ticket, const char* reason) {
  if (ticket.lost != nullptr) return;
  ticket.lost = reason;
  for (const auto& run : ticket.runs)
    if (stateOf(*run) == RunState::kOpen) abandon(*run, reason);
}

const char* noteRun(PassList& list) {
  if (list.hold == nullptr) return nullptr;
  ListTicket& ticket = *list.hold->ticket;
  std::erase_if(ticket.runs, [](const auto& run) { return stateOf(*run) == RunState::kAbandoned; });
  ticket.runs.push_back(list.run->record);
  if (ticket.lost != nullptr) return ticket.lost;
  for (const auto& needed : ticket.needs) {
    if (needed->runs.empty() && !needed->dropped) {
      return "a list that it needs has no barriers yet: finish() lists in the order in which they "
             "were written";
    }
    if (!isAny(*needed, RunState::kOpen) && !hasRun(*needed))
      return "a list that it needs does not run; write it again";
  }
  return nullptr;
}

void TicketSet::add(const std::shared_ptr<ListTicket>& ticket) {
  ran_ = hasRun();
  std::erase_if(tickets_, [&](const auto& held) {
    return held == ticket || (held->dropped && !isPending(*held, ticket->frame));
  });
  tickets_.push_back(ticket);
}

bool TicketSet::isFree(uint64_t frame) const {
  return std::none_of(tickets_.begin(), tickets_.end(),
                      [&](const auto& ticket) { return isPending(*ticket, frame); });
}

void TicketSet::lose(const char* reason) {
  ran_ = hasRun();
  for (const auto& ticket : tickets_) detail::lose(*ticket, reason);
  tickets_.clear();
}

bool TicketSet::hasRun() {
  return ran_ || std::any_of(tickets_.begin(), tickets_.end(),
                             [](const auto& ticket) { return detail::hasRun(*ticket); });
}

}  // namespace pelage::detail
