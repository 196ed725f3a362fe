// The life of pass lists: whether they run, and in which order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

#include "pelage/pass_list.h"

namespace pelage::detail {

enum class RunState : uint8_t {
  kOpen,       ///< may run
  kRecorded,   ///< recorded into a command buffer
  kDelivered,  ///< has run, or is certain to
  kAbandoned,  ///< never runs
};

/// The lists of one HazardTracker, which run in order.
struct RunOrder {
  std::mutex mutex;       ///< of this and of all its records
  uint64_t lists = 0;     ///< so far
  uint64_t recorded = 0;  ///< number of the last one that was recorded or delivered; 0: none
  ExecutorId executor = ExecutorId::kUnknown;  ///< that has their results
};

/// The state of a list; its tracker and its scene share it.
struct RunRecord {
  std::shared_ptr<RunOrder> order;
  uint64_t number = 0;  ///< from 1
  uint64_t behind = 0;  ///< number of the list that is to be recorded right before it; 0: none
  RunState state = RunState::kOpen;
  const char* reason = nullptr;  ///< why it was abandoned, where that is known
};

/// State shared by the copies of a list. Destroying the last copy abandons a list that has not run.
struct ListRun {
  std::shared_ptr<RunRecord> record;
  size_t passes = 0, uploads = 0;  ///< that the barriers are for
  ListRun() = default;
  ~ListRun();
  ListRun(const ListRun&) = delete;
  ListRun& operator=(const ListRun&) = delete;
};

/// \param last  the open list that runs before; nullptr if there is none.
RunHandle openRun(const std::shared_ptr<RunOrder>& order, const RunRecord* last,
                  const PassList& list);
RunState stateOf(const RunRecord& record);
/// Whether the list, or a copy of it, was recorded or delivered.
bool hasRun(const PassList& list);
bool isAbandoned(const PassList& list);
/// No effect on one that was delivered. \param reason for checkRun(); of static lifetime.
void abandon(RunRecord& record, const char* reason = nullptr);
/// No effect on one that was abandoned.
void setRecorded(RunRecord& record, ExecutorId executor);
void setDelivered(RunRecord& record, ExecutorId executor);

}  // namespace pelage::detail
