#include "passes/shared_tables.h"

#include <algorithm>
#include <utility>

#include "base/hash.h"

namespace pelage::detail {

BufferId SharedTables::add(ResourceTable& resources, const std::string& what, BufferDesc desc) {
  const uint64_t hash = hash64(desc.initial);
  for (const Table& table : tables_) {
    if (table.hash != hash || table.what != what) continue;
    const BufferDesc* held = resources.find(table.buffer);
    if (held != nullptr && held->stride == desc.stride && held->usage == desc.usage &&
        held->initial == desc.initial)
      return table.buffer;
  }
  const BufferId buffer = resources.add(std::move(desc));
  tables_.push_back({what, hash, buffer});
  return buffer;
}

bool SharedTables::contains(BufferId buffer) const {
  return std::any_of(tables_.begin(), tables_.end(),
                     [&](const Table& table) { return table.buffer == buffer; });
}

void SharedTables::collect(ResourceTable& resources, HazardTracker& hazards,
                           const std::function<bool(BufferId)>& isUsed) {
  if (!released_) return;
  released_ = false;
  std::erase_if(tables_, [&](const Table& table) {
    if (isUsed(table.buffer)) return false;
    resources.remove(table.buffer);
    hazards.forget(table.buffer);
    return true;
  });
}

}  // namespace pelage::detail
