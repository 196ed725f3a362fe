#include "passes/list_run.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "passes/handles.h"

namespace pelage {
namespace detail {

ListRun::~ListRun() {
  if (record != nullptr) abandon(*record);
}

RunHandle openRun(const std::shared_ptr<RunOrder>& order, const RunRecord* last,
                  const PassList& list) {
  std::shared_ptr<ListRun> run = makeHandle<ListRun>();
  run->record = makeHandle<RunRecord>();
  run->passes = list.passes.size();
  run->uploads = list.uploads.size();
  const std::lock_guard lock(order->mutex);
  run->record->order = order;
  run->record->number = ++order->lists;
  run->record->behind = last != nullptr ? last->number : order->recorded;
  return run;
}

RunState stateOf(const RunRecord& record) {
  const std::lock_guard lock(record.order->mutex);
  return record.state;
}

bool hasRun(const PassList& list) {
  if (list.run == nullptr) return false;
  const RunState state = stateOf(*list.run->record);
  return state == RunState::kRecorded || state == RunState::kDelivered;
}

bool isAbandoned(const PassList& list) {
  return list.run != nullptr && stateOf(*list.run->record) == RunState::kAbandoned;
}

void abandon(RunRecord& record, const char* reason) {
  const std::lock_guard lock(record.order->mutex);
  if (record.state == RunState::kDelivered || record.state == RunState::kAbandoned) return;
  // Later recorded lists are withdrawn with it.
  if (record.state == RunState::kRecorded)
    record.order->recorded = std::min(record.order->recorded, record.behind);
  record.state = RunState::kAbandoned;
  record.reason = reason;
}

// Notes that a list is the last one that was recorded.
static void note(const RunRecord& record, ExecutorId executor) {
  record.order->recorded = record.number;
  record.order->executor = executor;
}

void setRecorded(RunRecord& record, ExecutorId executor) {
  const std::lock_guard lock(record.order->mutex);
  if (record.state != RunState::kOpen) return;
  record.state = RunState::kRecorded;
  note(record, executor);
}

void setDelivered(RunRecord& record, ExecutorId executor) {
  const std::lock_guard lock(record.order->mutex);
  if (record.state == RunState::kAbandoned) return;
  if (record.state == RunState::kOpen) note(record, executor);
  record.state = RunState::kDelivered;
}

}  // namespace detail

namespace {

Error refuse(const char* what) { return {ErrorCode::kInvalidArgument, what}; }

Result<void> checkBarriers(const PassList& list) {
  const bool empty = list.passes.empty() && list.uploads.empty();
  if (list.run == nullptr) {
    if (empty) return {};
    return refuse("the list has no barriers: call Scene::finish() or HazardTracker::resolve()");
  }
  if (list.run->passes != list.passes.size() || list.run->uploads != list.uploads.size()) {
    return refuse(
        "the list got passes or uploads after its barriers: call Scene::finish() behind "
        "everything that adds to it");
  }
  return {};
}

// Buffers of another executor have the results of the lists before.
Result<void> checkExecutor(const detail::RunOrder& order, ExecutorId executor) {
  const ExecutorId before = order.executor;
  if (order.recorded == 0 || before == executor) return {};
  if (before == ExecutorId::kUnknown || executor == ExecutorId::kUnknown) return {};
  return refuse(
      "the lists before this one ran on another runtime, whose buffers have their results: run "
      "all lists of a scene on one, or call Scene::recover() to go on with this one");
}

}  // namespace

ExecutorId newExecutorId() {
  static std::atomic<uint64_t> count{0};
  return static_cast<ExecutorId>(++count);
}

Result<void> checkRun(const PassList& list, ExecutorId executor) {
  if (list.run == nullptr) return checkBarriers(list);
  const detail::RunRecord& record = *list.run->record;
  const std::lock_guard lock(record.order->mutex);
  switch (record.state) {
    case detail::RunState::kOpen:
      break;
    case detail::RunState::kRecorded:
    case detail::RunState::kDelivered:
      return refuse("the list has run before; each runs once: clear() it, and write it again");
    case detail::RunState::kAbandoned:
      if (record.reason != nullptr) {
        return {Error{ErrorCode::kInvalidArgument,
                      std::string("the list was abandoned: ") + record.reason}};
      }
      return refuse(
          "the list was abandoned: Scene::simulate() or Scene::abandon() came before it "
          "ran, or a list before it did not run; write it again");
  }
  if (Result<void> checked = checkBarriers(list); !checked) return checked;
  if (record.behind == record.order->recorded) return checkExecutor(*record.order, executor);
  if (record.order->recorded > record.number)
    return refuse("a list that was finished after this one has run before it: keep their order");
  return refuse(
      "a list that was finished before this one has not run: run it first, or abandon it "
      "and finish this one again");
}

Result<void> checkDraws(const PassList& list) {
  if (Result<void> checked = checkBarriers(list); !checked || list.run == nullptr) return checked;
  if (detail::hasRun(list)) return {};
  return refuse("the list's draws run after its dispatches: record() the list first");
}

void setRecorded(const RunHandle& run, ExecutorId executor) {
  if (run != nullptr) detail::setRecorded(*run->record, executor);
}

void setDelivered(const RunHandle& run, ExecutorId executor) {
  if (run != nullptr) detail::setDelivered(*run->record, executor);
}

void abandon(const RunHandle& run) {
  if (run != nullptr) detail::abandon(*run->record);
}

}  // namespace pelage
