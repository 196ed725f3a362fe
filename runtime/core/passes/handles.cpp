#include "passes/handles.h"

#include <memory_resource>
#include <mutex>

namespace pelage::detail {

namespace {

struct Pool {
  std::mutex mutex;
  std::pmr::unsynchronized_pool_resource memory;
};

// Never destroyed: handles may be as old as the program.
Pool& pool() {
  static Pool& one = *new Pool;
  return one;
}

}  // namespace

void* allocateHandle(size_t bytes, size_t alignment) {
  Pool& own = pool();
  const std::lock_guard lock(own.mutex);
  return own.memory.allocate(bytes, alignment);
}

void freeHandle(void* memory, size_t bytes, size_t alignment) noexcept {
  Pool& own = pool();
  const std::lock_guard lock(own.mutex);
  own.memory.deallocate(memory, bytes, alignment);
}

}  // namespace pelage::detail
